"""Points at which a truth seems to hold, found by trying; floats only guide, what is found is confirmed exactly."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from random import Random
from typing import Any

from haverify.analyses.regions import Node, Truth, holds_at

FEW, MANY = 24, 150
Point = dict[str, Fraction]
_SHARES = (Fraction(0), Fraction(1), Fraction(1, 2))


def sample(truth: Truth, ranges: Mapping[str, tuple[Fraction, Fraction]], tries: int = FEW) -> Point | None:
    """A point of the box at which the truth holds, of a fixed sequence that has the corners and middles first."""
    if isinstance(truth, bool) or not ranges:
        return None
    random, names = Random(1), sorted(ranges)
    for k in range(tries):
        shares = [_share(random, k) for _ in names]
        point = {v: ranges[v][0] + s * (ranges[v][1] - ranges[v][0]) for v, s in zip(names, shares, strict=True)}
        if _Guess({v: float(q) for v, q in point.items()}).truth(truth) and holds_at(truth, point):
            return point
    return None


def _share(random: Random, k: int) -> Fraction:
    """A place between the ends: rough ones first, then finer ones."""
    if k < 16:
        return _SHARES[random.randrange(3)]
    return Fraction(random.randrange(25), 24) if k < 150 else Fraction(random.randrange(361), 360)


class _Guess:
    """Numbers and truths at a point, in floats."""

    def __init__(self, point: Mapping[str, float]) -> None:
        self.point = point
        self.known: dict[int, float] = {}

    def truth(self, t: Truth) -> bool:
        if isinstance(t, bool):
            return t
        if t.op == "le":
            a, b = self.number(t.parts[0]), self.number(t.parts[1])
            return a < b if t.parts[2] else a <= b
        return all(map(self.truth, t.parts)) if t.op == "and" else any(map(self.truth, t.parts))

    def number(self, n: Node) -> float:
        found = self.known.get(id(n))
        if found is None:
            found = self.known[id(n)] = self._value(n.op, n.parts)
        return found

    def _value(self, op: str, parts: Any) -> float:
        if op == "lin":
            return float(parts[0]) + sum(float(q) * self.point[v] for v, q in parts[1])
        if op == "sum":
            return float(parts[0]) + sum(float(q) * self.number(m) for q, m in parts[1])
        if op == "if":
            return self.number(parts[1] if self.truth(parts[0]) else parts[2])
        values = map(self.number, parts)
        return min(values) if op == "min" else max(values)
