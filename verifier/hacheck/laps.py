"""Laps along a recorded flow and its jumps: all runs from a part of a plane come to it; how that depends on the start.

Between jumps the derivatives by the start follow `Phi' = Df Phi`. An edge is taken where a quantity g of the domain is
0, at an instant that depends on the start: with the reset r and the rates f before, h after it, the derivatives become
`Dr Phi - (Dr f - h) (Dg Phi) / (Dg f)`. On the plane `v = value` they are `Phi - f (Dv Phi) / (Dv f)`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from functools import partial
from itertools import product
from math import ceil, floor
from typing import TYPE_CHECKING, Any, NamedTuple

from hacheck.along import CLOSE, Aim, Along, Landing
from hacheck.crossings import Crossing, crossed, during, rate, sign_at
from hacheck.elementary import inverse
from hacheck.enclosures import ZERO, Model, add, bounds, middle
from hacheck.expressions import nodes
from hacheck.rational import Beyond, Refused, spend
from hacheck.records import Ends, Here, Record, Stay
from hacheck.sections import ONE, Section
from hacheck.tapes import UNKNOWN, holds
from hacheck.variations import VariedRecord, derived, smooth

if TYPE_CHECKING:
    from hacheck.obligations import Question

Json = Any
Box = Mapping[str, Ends]
Touching = list[tuple[int, bool]]


class Lap(NamedTuple):
    """Bounds of the duration, of the end in the section's coordinates, of its derivatives by them, of the middle's end.

    The edges that all runs take, each with the border at which they do.
    """

    time: Ends
    end: list[Ends]
    slopes: list[list[Ends]]
    centre: list[Ends]
    jumps: list[tuple[int, Crossing]]


class Laps(Along):
    """Runs to a section; where they are `varied`, they start on it, and are derived by its coordinates."""

    def __init__(self, question: Question, name: Json, section: Section, varied: bool) -> None:
        self.section, self.by = section, list(section.centre) if varied else []
        super().__init__(question, name)
        if any(n[0] == "time" for n in nodes([self.scope.automaton, question.condition])):
            raise Beyond("a periodic orbit beside the time")
        self.plain = list(self.scope.types)
        tape = self.record.field(section.mode).tape
        self.plane = tape.value(["-", ["var", section.variable], str(section.value)])

    def _aim(self) -> Aim:
        """Nothing is claimed on the way but that runs go on, and come to the end of the record."""
        return Aim(self.q.condition, Fraction(0), Fraction(0), meet=True, lively=True)

    def _is_late(self, time: Model, inclusive: bool = False) -> bool:
        return False

    def _record(self, question: Question, name: Json) -> Record:
        return VariedRecord(self.scope, question.setting.load(name), self.by)

    def whole(self, node: Json, share: Fraction = ONE) -> Lap:
        """The lap of all states of the section at once, made larger or smaller by a factor."""
        return self._lap(node, self._start(share), self._touching(self.section.mode, self.section.box(share)))

    def parted(self, tree: Json, mode: str, box: Box) -> Iterator[Lap]:
        """A way to the section for each piece of a box of a mode."""
        spend(100)
        if "split" not in tree:
            yield self._lap(tree, self.record.start(mode, dict(box)), self._touching(mode, box))
            return
        low, high = box[tree["split"]]
        half = (low + high) / 2
        yield from self.parted(tree["low"], mode, {**box, tree["split"]: (low, half)})
        yield from self.parted(tree["high"], mode, {**box, tree["split"]: (half, high)})

    def _start(self, share: Fraction) -> Here:
        """The states of the section, or of one that is larger; derivatives are its directions."""
        s, record = self.section, self.record
        sides = {s.variable: self._sum(s.value, [])}
        for (v, c), row in zip(s.centre.items(), s.basis, strict=True):
            sides[v] = self._sum(c, [(w, share * q) for w, q in zip(s.centre, row, strict=True)])
            sides |= {derived(v, by): self._sum(q, []) for by, q in zip(s.centre, row, strict=True) if by in self.by}
        sides |= {derived(s.variable, by): ZERO for by in self.by}
        centre = {v: Model(sides[v].parts, 0) for v in record.moving}
        return Here(s.mode, record.field(s.mode).front(centre, [sides[v].radius for v in record.moving]), ZERO)

    def _sum(self, first: Fraction, along: list[tuple[str, Fraction]]) -> Model:
        """A number and multiples of coordinates: of those that the record does not vary, as an error."""
        one, names = self.space.one, self.record.set
        terms, radius = {0: floor(first * one)}, 1
        for v, q in along:
            if v in names:
                terms[self.record.unit(names.index(v))] = floor(q * one)
                radius += 1
            else:
                radius += ceil(abs(q) * one)
        return Model({0: terms}, radius)

    # A lap

    def _lap(self, node: Json, here: Here, touching: Touching) -> Lap:
        """All runs go the same way: each jump is one that they make, and no other is possible."""
        taken: list[tuple[int, Crossing]] = []
        while True:
            steps, jumps = list(self._steps(node, here)), node.get("jumps")
            stays = [stay for step in steps for stay in step]
            self._pass(stays if jumps is None else stays[:-1], touching)
            if jumps is None:
                return self._ended(self._arrived(steps[-1]), taken)
            found, mode = self.border(stays[-1]), stays[-1].before.mode
            self.before(mode, self._states(stays[-1]), found, self._fits)
            (node,) = jumps
            landing = self._made(mode, node["edge"], found)
            taken.append((node["edge"], found))
            here, touching = self.landed(node["edge"], node, found, landing), landing.touching

    def _steps(self, node: Json, here: Here) -> Iterator[list[Stay]]:
        for step in node["steps"]:
            stays = self.record.steps(here, {}, step)
            yield stays
            here = stays[-1].after

    def _states(self, stay: Stay) -> dict[str, Model]:
        return {v: stay.states[v] for v in [*self.plain, "time"]}

    def _pass(self, stays: Sequence[Stay], touching: Touching) -> None:
        """Runs stay in their domain and the declared ranges, and can make no jump."""
        for n, stay in enumerate(stays):
            mode, states = stay.before.mode, self._states(stay)
            known = self._held(mode, states, touching) if not n else UNKNOWN
            self._need(self._close(states, partial(self._fits, mode, known, UNKNOWN), CLOSE), states)

    def _made(self, mode: str, k: Json, found: Crossing) -> Landing:
        """The landing of the only edge that can be taken at a border, which certainly is."""
        r = self.rules(mode)
        values = r.field.tape.values(r.read, found.states, self.space)
        possible = [e for e, g in r.guards.items() if holds(g, values, {found.place: (0, 0)}) is not False]
        if type(k) is not int or possible != [k]:
            raise Beyond("a recorded lap has a jump beside which others are possible, or another one")
        landing = self.landing(k, found)
        if not (self.is_taken(k, found) and landing.domain is True and landing.window is True):
            raise Beyond("a recorded lap does not certainly make its jump")
        return landing

    def landing(self, k: int, found: Crossing) -> Landing:
        """The instant just after an edge, with derivatives."""
        plain = super().landing(k, found)
        return plain._replace(states={**plain.states, **self._salted(k, found, plain.states)})

    def _salted(self, k: int, found: Crossing, after: Mapping[str, Model]) -> dict[str, Model]:
        """The derivatives after an edge; the border must be crossed at a certain speed."""
        edge, space = self.model.edges[k], self.space
        source, target = self.record.field(edge["source"]), self.record.field(edge["target"])
        tape, to = source.tape, {r["var"]: r["to"] for r in edge["resets"]}
        outcome = {v: tape.value(to.get(v, ["var", v])) for v in self.plain}
        gradients = {v: {w: tape.slope(place, w) for w in self.plain} for v, place in outcome.items()}
        across = {w: tape.slope(found.place, w) for w in self.plain}
        speed = rate(source, found.place)
        if speed is None:
            raise Beyond("a border that is not crossed")
        used = [p for row in (*gradients.values(), across) for p in row.values() if p is not None]
        smooth(tape, used)
        values = tape.values([*used, speed, *source.rates], found.states, space)
        rates = {w: values[p] for w, p in zip(self.plain, source.rates, strict=False)}
        new = target.tape.values(target.rates, after, space)
        later = {v: new[p] for v, p in zip(self.plain, target.rates, strict=False)}
        slower, made = inverse(space, values[speed]), {}

        def along(gradient: Mapping[str, int | None], x: Mapping[str, Model]) -> Model:
            return space.sum((values[p], x[w]) for w, p in gradient.items() if p is not None)

        drift = {v: add(along(gradients[v], rates), later[v], -1) for v in self.plain}
        for c in self.by:
            column = {w: found.states[derived(w, c)] for w in self.plain}
            sooner = space.mul(along(across, column), slower)
            for v in self.plain:
                made[derived(v, c)] = add(along(gradients[v], column), space.mul(drift[v], sooner), -1)
        return made

    # Its end

    def _arrived(self, stays: list[Stay]) -> Crossing:
        """Where all runs cross the plane: from one side at `since` to the other at the end, at a certain speed."""
        section = self.section
        if stays[-1].before.mode != section.mode:
            raise Refused("a recorded lap ends in another mode than that of its section")
        field = self.record.field(section.mode)
        for stay, sign in product(stays, (1, -1)):
            try:
                found = crossed(field, self.plane, sign, stay.states, stay.h)
            except Beyond:
                continue
            if found is not None:
                before = during(self.space, stay.states, found.since, 0)
                if sign_at(field.tape, self.plane, before, self.space) == -sign:
                    return found
        raise Beyond("a recorded lap does not certainly end on its section")

    def _ended(self, found: Crossing, taken: list[tuple[int, Crossing]]) -> Lap:
        """The end in coordinates: `back (x - centre)`, and its derivatives, those of x put through it as well."""
        space, states, s, field = self.space, found.states, self.section, self.record.field(self.section.mode)
        values = field.tape.values(field.rates, states, space)
        rates = {v: values[r] for v, r in zip(field.names, field.rates, strict=True)}
        slower = inverse(space, rates[s.variable])
        columns = []
        for c in self.by:
            later = space.mul(states[derived(s.variable, c)], slower)
            columns.append([add(states[derived(v, c)], space.mul(rates[v], later), -1) for v in s.centre])
        end = self._turned([add(states[v], space.number(c), -1) for v, c in s.centre.items()])
        if any(i for m in end for i in m.parts):
            raise Beyond("the end of a lap that still depends on time")
        slopes = [list(row) for row in zip(*map(self._turned, columns), strict=True)]
        centre = [Model({0: {0: middle(m)}}, m.radius) for m in end]
        return Lap(self._bounds(states["time"]), [*map(self._bounds, end)], [[*map(self._bounds, r)] for r in slopes],
                   [*map(self._bounds, centre)], taken)  # fmt: skip

    def _turned(self, x: list[Model]) -> list[Model]:
        numbers = [[self.space.number(q) for q in row] for row in self.section.back]
        return [self.space.sum(zip(row, x, strict=True)) for row in numbers]

    def _bounds(self, m: Model) -> Ends:
        low, high = bounds(m)
        return Fraction(low, self.space.one), Fraction(high, self.space.one)

    # The claim's condition

    def passes(self, lap: Lap, share: Fraction) -> bool:
        """Does the condition hold after one of the jumps of all laps from a share of the section, or on that itself?"""
        small = (self.landing(k, self._near(found, share)).claim for k, found in lap.jumps)
        return any(c is True for c in small) or self._exactly(share)

    def _near(self, found: Crossing, share: Fraction) -> Crossing:
        """The states at a border that come from a share of the section."""
        states, part = found.states, ceil(share * self.space.one)
        for j in range(len(self.record.set)):
            states = {v: self.space.moved(m, j, 0, part) for v, m in states.items()}
        return found._replace(states=states)

    def _exactly(self, share: Fraction) -> bool:
        """Does the condition hold on a share of the section, by exact intervals? It has to be a conjunction."""
        tape, sides = self.record.field(self.section.mode).tape, self.section.box(share)
        f = tape.truth(self.q.condition)
        if isinstance(f, bool):
            return f
        found = f[1:] if f[0] == "and" else (f,)
        return all(g[0] not in ("and", "or") and self._holds(tape.exactly(g[1], sides), g[0]) for g in found)

    def _holds(self, ends: Ends | None, op: str) -> bool:
        if ends is None:
            raise Beyond("a section beside other than polynomials")
        low, high = ends
        least = {"==": low == high == 0, "<=": high <= 0, "<": high < 0, ">=": low >= 0, ">": low > 0}
        return least.get(op, low > 0 or high < 0)
