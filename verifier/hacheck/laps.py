"""Laps along a recorded flow: all runs from a box of a plane come to it again; how that depends on the start."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from itertools import product
from typing import Any, NamedTuple

from hacheck.crossings import Crossing, crossed, during, sign_at
from hacheck.elementary import inverse
from hacheck.enclosures import Model, add, bounds, middle
from hacheck.flow_starts import FlowStarts
from hacheck.formula import conj
from hacheck.rational import Beyond, Refused, spend
from hacheck.records import Ends, Here, Stay
from hacheck.scope import Scope
from hacheck.tapes import holds, places
from hacheck.variations import VariedRecord, derived

Json = Any
Box = Mapping[str, Ends]
HALVINGS = 6  # of a step, where what has to be kept is looked at


class Lap(NamedTuple):
    """Bounds of the duration, the end and its derivatives (rows: end, columns: start); the end of the middle."""

    time: Ends
    state: list[Ends]
    slopes: list[list[Ends]]
    centre: list[Ends]


class Laps:
    """Laps from the plane `section[0] = section[1]` of a mode, with derivatives by some variables."""

    def __init__(self, scope: Scope, mode: str, section: tuple[str, str], data: Json, by: list[str]) -> None:
        self.scope, self.mode, self.variable, self.by = scope, mode, section[0], by
        self.value = Fraction(section[1])
        self.ends = [v for v in scope.types if v != self.variable]
        self.data, self.record = data, VariedRecord(scope, data, by)
        self.space, self.field = self.record.space, self.record.field(mode)
        tape, starts = self.field.tape, FlowStarts(scope, self.record)
        self.kept = conj([tape.truth(scope.modes[mode]["domain"]), *map(tape.truth, starts.window())])
        self.border = tape.value(["-", ["var", self.variable], section[1]])
        if any(op == ("name", "time") for op in tape.ops):
            raise Beyond("a periodic orbit beside the time")

    def all(self, box: Box) -> Iterator[Lap]:
        """A lap of each piece of a box of the plane."""
        (start,) = self.data["starts"]
        yield from self._pieces(start["pieces"], box)

    def start(self, box: Box) -> Here:
        """The states of a box of the plane, with their derivatives by the start."""
        one = {derived(v, c): (Fraction(v == c),) * 2 for v in self.scope.types for c in self.by}
        return self.record.start(self.mode, {**box, self.variable: (self.value, self.value), **one})

    def middle(self, box: Box) -> list[Fraction]:
        """The state in the middle of a box, as the record has it."""
        centre = self.start(box).front.centre
        return [Fraction(middle(centre[v]), self.space.one) for v in self.ends]

    def _pieces(self, tree: Json, box: Box) -> Iterator[Lap]:
        spend(100)
        if "split" not in tree:
            yield self._lap(tree["steps"], box)
            return
        low, high = box[tree["split"]]
        half = (low + high) / 2
        yield from self._pieces(tree["low"], {**box, tree["split"]: (low, half)})
        yield from self._pieces(tree["high"], {**box, tree["split"]: (half, high)})

    def _lap(self, steps: list[Json], box: Box) -> Lap:
        """All runs from a piece stay where they may be, and cross the plane in the last step."""
        here, stays, last = self.start(box), list[Stay](), list[Stay]()
        for step in steps:
            last = self.record.steps(here, {}, step)
            here, stays = last[-1].after, [*stays, *last]
        if not all(self._keeps(s.states, HALVINGS) for s in stays):
            raise Beyond("a recorded lap does not certainly keep its domain and the declared ranges")
        return self._ended(self._crossed(last))

    def _keeps(self, states: Mapping[str, Model], depth: int) -> bool:
        spend(20)
        if holds(self.kept, self.field.tape.values(places(self.kept), states, self.space)) is True:
            return True
        half = self.space.one >> 1
        parts = (during(self.space, states, start, half) for start in (0, half))
        return depth > 0 and all(self._keeps(p, depth - 1) for p in parts)

    def _crossed(self, stays: list[Stay]) -> Crossing:
        """Where all runs cross the plane: from one side at `since` to the other at the end, at a certain speed."""
        for stay, sign in product(stays, (1, -1)):
            found = crossed(self.field, self.border, sign, stay.states, stay.h)
            if found is not None:
                before = during(self.space, stay.states, found.since, 0)
                if sign_at(self.field.tape, self.border, before, self.space) == -sign:
                    return found
        raise Beyond("a recorded lap does not certainly end on its section")

    def _ended(self, found: Crossing) -> Lap:
        """The derivative of the return: with the flow f, `Phi - f (row of v in Phi) / (f of v)`."""
        space, states, field = self.space, found.states, self.field
        values = field.tape.values(field.rates, states, space)
        rates = {v: values[r] for v, r in zip(field.names, field.rates, strict=True)}
        slower = inverse(space, rates[self.variable])
        later = {c: space.mul(states[derived(self.variable, c)], slower) for c in self.by}
        slopes = [[add(states[derived(v, c)], space.mul(rates[v], later[c]), -1) for c in self.by] for v in self.ends]
        ends = [states[v] for v in self.ends]
        if any(i for m in ends for i in m.parts):
            raise Beyond("the end of a lap that still depends on time")
        centre = [Model({0: {0: middle(m)}}, m.radius) for m in ends]
        return Lap(self._bounds(states["time"]), [*map(self._bounds, ends)], [[*map(self._bounds, r)] for r in slopes],
                   [*map(self._bounds, centre)])  # fmt: skip

    def _bounds(self, m: Model) -> Ends:
        low, high = bounds(m)
        return Fraction(low, self.space.one), Fraction(high, self.space.one)

    def exactly(self, e: Json, box: Box) -> bool:
        """Does a conjunction of comparisons of polynomials hold on a box of the plane, by exact intervals?

        Raises Beyond where it is none.
        """
        f, sides = self.field.tape.truth(e), {**box, self.variable: (self.value, self.value)}
        if isinstance(f, bool):
            raise Refused("a section that is empty, or everything")
        found = f[1:] if f[0] == "and" else (f,)
        if any(g[0] in ("and", "or") for g in found):
            raise Beyond("a section that is no conjunction of comparisons")
        return all(self._holds(op, place, sides) for op, place in found)

    def _holds(self, op: str, place: int, sides: Box) -> bool:
        ends = self.field.tape.exactly(place, sides)
        if ends is None:
            raise Beyond("a section beside other than polynomials")
        low, high = ends
        least = {"==": low == high == 0, "<=": high <= 0, "<": high < 0, ">=": low >= 0, ">": low > 0}
        return least.get(op, low > 0 or high < 0)
