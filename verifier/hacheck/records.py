"""Recorded flows: polynomials for each variable, step, and piece of the starts, and what solutions they are near to.

How far solutions are from the polynomials is found here (`tubes.py`); a record says nothing about it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from math import ceil, floor
from typing import Any, NamedTuple

from hacheck.enclosures import HIGHEST, ZERO, Model, Space, Terms, add, bounds, degree, key, norm, widened
from hacheck.rational import Beyond, Refused, spend
from hacheck.scope import Scope
from hacheck.tubes import Field, Front

Json = Any
Ends = tuple[Fraction, Fraction]
GUARD, COARSE_TIME, MOST_MOVING, MOST_BENT, HALVINGS = 16, 4, 16, 64, 6


class Here(NamedTuple):
    """States of a mode at an instant, which may differ from state to state."""

    mode: str
    front: Front
    time: Model


class Stay(NamedTuple):
    """What encloses all solutions during a step, its length, where they are before and after it.

    The length may depend on the set: states of the set go the same ways at paces of their own.
    """

    states: dict[str, Model]
    h: Model
    before: Here
    after: Here


class Record:
    """A file of recorded polynomials: what is common to all its steps."""

    def __init__(self, scope: Scope, data: Json, moving: list[str] | None = None) -> None:
        if (data["schema"], data["automaton"]) != ("haverify.flow/1", scope.automaton["name"]):
            raise Refused("a recorded flow has another schema, or is of another automaton")
        self.scope, self.data, self.moving = scope, data, moving or list(scope.types)
        if len(self.moving) > MOST_MOVING:
            raise Beyond("a recorded flow has many variables")
        self.set = list(data["set"])
        if len(set(self.set)) < len(self.set) or not set(self.set) <= {*self.moving, *scope.ranges}:
            raise Refused("a recorded flow varies what is no variable or param")
        self.monomials = [self._monomial(m) for m in data["monomials"]]
        if len(set(self.monomials)) < len(self.monomials):
            raise Refused("a recorded flow has a monomial twice")
        most = max([degree(m) for m in self.monomials], default=0)
        bits, self.order = whole(data["bits"], 8, 120) + GUARD, whole(data["order"], 1, HIGHEST)
        self.space = Space(bits, self.order, max(most, 1))
        self.coarse = Space(bits, min(COARSE_TIME, self.order), int(len(self.moving) * len(self.set) <= MOST_BENT))
        self._fields: dict[str, Field] = {}
        self._known: dict[tuple[int, ...], tuple[Any, Any]] = {}
        self._starts: dict[tuple[str, tuple[tuple[str, Ends], ...]], Here] = {}

    def once(self, found: Callable[[], Any], *about: Any) -> Any:
        """What is found out about some objects, which are told apart by identity, is found out once."""
        key = tuple(map(id, about))
        if key not in self._known:
            self._known[key] = about, found()  # they are kept, so that their identities are not given away
        return self._known[key][1]

    def _monomial(self, given: Json) -> int:
        if len(given) != len(self.set) or sum(given) > HIGHEST:
            raise Refused("a monomial of a recorded flow is of other variables, or of too high a degree")
        return key(whole(e, 0, HIGHEST) for e in given)

    def unit(self, variable: int) -> int:
        """The monomial that is one set variable."""
        return key([*[0] * variable, 1])

    def field(self, mode: str) -> Field:
        """The flow of a mode."""
        if mode not in self._fields:
            self._fields[mode] = Field(self.scope, mode, self.space, self.coarse)
        return self._fields[mode]

    def params(self, box: Mapping[str, Ends]) -> dict[str, Model]:
        """The params of a piece."""
        return {p: self._side(p, box[p]) for p in self.scope.ranges}

    def start(self, mode: str, box: Mapping[str, Ends]) -> Here:
        """All states of a box, at time 0; for equal boxes the same object."""
        key = mode, tuple(sorted(box.items()))
        if key not in self._starts:
            self._starts[key] = self._start(mode, box)
        return self._starts[key]

    def _start(self, mode: str, box: Mapping[str, Ends]) -> Here:
        sides = {v: self._side(v, box[v]) for v in self.moving}
        centre = {v: Model(m.parts, 0) for v, m in sides.items()}
        return Here(mode, self.field(mode).front(centre, [sides[v].radius for v in self.moving]), ZERO)

    def _side(self, name: str, ends: Ends) -> Model:
        """All values between two: along a set variable of its own, or as a number with an error."""
        one, (low, high) = self.space.one, ends
        least, most = floor(low * one), ceil(high * one)
        most += (most - least) & 1
        centre, half = (least + most) >> 1, (most - least) >> 1
        if name not in self.set:
            return Model({0: {0: centre}}, half)
        return Model({0: {0: centre, self.unit(self.set.index(name)): half}}, 0)

    def landed(self, mode: str, given: Json, states: Mapping[str, Model], time: Model) -> Here:
        """States of a mode near recorded polynomials."""
        centre = {v: Model({0: self._terms(row)}, 0) for v, row in zip(self.moving, given, strict=True)}
        radii = [norm(add(states[v], centre[v], -1)) for v in self.moving]
        return Here(mode, self.field(mode).front(centre, radii), time)

    def steps(self, here: Here, params: Mapping[str, Model], step: Json) -> list[Stay]:
        """A recorded step, in one part or as many halves as it takes to bound its errors."""
        found: list[Stay] = self.once(lambda: self._steps(here, params, step), here, step)
        return found

    def _steps(self, here: Here, params: Mapping[str, Model], step: Json) -> list[Stay]:
        h = Model({0: self._terms(step["h"] if isinstance(step["h"], list) else [step["h"]])}, 0)
        if bounds(h)[0] <= 0:
            raise Refused("a recorded step does not go forwards")
        paths = {v: self._path(c) for v, c in zip(self.moving, step["x"], strict=True)}
        found: list[Stay] = []
        self._follow(here, params, h, paths, found, HALVINGS)
        return found

    def _follow(self, here: Here, params: Mapping[str, Model], h: Model, paths: Mapping[str, Model],
                found: list[Stay], depth: int) -> Here:  # fmt: skip
        """All states from here along some paths (each without its start), at the end."""
        try:
            found.append(self._stay(here, params, h, paths))
            return found[-1].after
        except Beyond:
            if not depth:
                raise
        half = self.space.one >> 1
        for start in (0, half):
            cut = {v: self.space.moved(m, -1, start, half).parts for v, m in paths.items()}
            later = {v: Model({i: t for i, t in parts.items() if i}, 0) for v, parts in cut.items()}
            here = self._follow(here, params, self.space.scaled(h, half), later, found, depth - 1)
        return here

    def _stay(self, here: Here, params: Mapping[str, Model], h: Model, paths: Mapping[str, Model]) -> Stay:
        h = Model(h.parts, 0)
        clock = add(here.time, Model({1: h.parts[0]}, 0))
        env = {**params, "time": clock, **{v: add(here.front.centre[v], m) for v, m in paths.items()}}
        off, front = self.field(here.mode).step(here.front, env, h)
        states = {**env, **{v: widened(env[v], r) for v, r in zip(self.moving, off, strict=True)}}
        return Stay(states, h, here, Here(here.mode, front, add(here.time, h)))

    def _path(self, coefficients: Json) -> Model:
        """The polynomial that begins at 0 and has these coefficients of the powers of t, from the first."""
        if len(coefficients) > self.order:
            raise Refused("a recorded flow has a power of t above its order")
        return Model({i + 1: self._terms(row) for i, row in enumerate(coefficients)}, 0)

    def _terms(self, row: Json) -> Terms:
        if len(row) > len(self.monomials):
            raise Refused("a recorded flow has more coefficients than monomials")
        spend(1 + len(row))
        found = (whole(c, -(10**18), 10**18) << GUARD for c in row)
        return {k: c for k, c in zip(self.monomials, found, strict=False) if c}


def whole(n: Json, low: int, high: int) -> int:
    """An integer of a record."""
    if type(n) is not int or not low <= n <= high:
        raise Refused("a recorded flow has a number that is none, or out of its range")
    return n
