"""Points at which a truth holds or fails, found by trying."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from random import Random
from typing import Any

from haverify.analyses.regions import Node, Truth
from haverify.analyses.regions_whole import Ranges, Region, Whole, box

FEW, MANY = 24, 150
Point = dict[str, Fraction]
_GRAIN = 360  # points are at multiples of this part of a range


def sample(truth: Truth, ranges: Ranges, tries: int = FEW) -> Point | None:
    """A point of the box at which the truth holds, of a fixed sequence that has the corners and middles first."""
    return _found(Whole(truth, sorted(ranges)).truth(truth), ranges, tries, True)


def failing(truth: Truth, ranges: Ranges, tries: int) -> Point | None:
    """A point of the box at which the truth, one of whole numbers, fails."""
    return _found(truth, ranges, tries, False)


def _found(truth: Truth, ranges: Ranges, tries: int, wanted: bool) -> Point | None:
    if isinstance(truth, bool) or not ranges:
        return None
    region = box(ranges, _GRAIN)
    for shares in _shares(len(ranges), tries):
        ends = zip(shares, region.axes.items(), strict=True)
        place = {v: low + (high - low) // _GRAIN * share for share, (v, (low, high)) in ends}
        if _Place(region, place).truth(truth) is wanted:
            return {name: Fraction(q, region.unit) for name, q in zip(sorted(ranges), place.values(), strict=True)}
    return None


def _shares(size: int, tries: int) -> Iterator[list[int]]:
    """Places between the ends: rough ones first, then finer ones."""
    random = Random(1)
    for k in range(tries):
        yield [_share(random, k) for _ in range(size)]


def _share(random: Random, k: int) -> int:
    if k < 16:
        return (0, 360, 180)[random.randrange(3)]
    return 15 * random.randrange(25) if k < 150 else random.randrange(361)


class _Place:
    """Numbers, in units of the region, and truths at a point."""

    def __init__(self, region: Region, at: dict[int, int]) -> None:
        self.unit, self.at = region.unit, at
        self._known: dict[Node, int] = {}

    def truth(self, t: Truth) -> bool:
        if isinstance(t, bool):
            return t
        if t.op == "le":
            a, b, strict = t.parts
            return bool(self.number(a) <= self.number(b) - strict)
        if t.op == "and":
            return all(map(self.truth, t.parts))
        return any(map(self.truth, t.parts))

    def number(self, n: Node) -> int:
        found = self._known.get(n)
        if found is None:
            found = self._known[n] = self._value(n.op, n.parts)
        return found

    def _value(self, op: str, parts: Any) -> int:
        known, value = self._known, 0
        if op in ("min", "max"):
            values = [known[m] if m in known else self.number(m) for m in parts]
            value = min(values) if op == "min" else max(values)
        elif op == "if":
            value = self.number(parts[1] if self.truth(parts[0]) else parts[2])
        elif op == "lin":
            value, at = parts[0] * self.unit, self.at
            for v, q in parts[1]:
                value += q * at[v]
        else:
            value = parts[0] * self.unit
            for q, m in parts[1]:
                value += q * (known[m] if m in known else self.number(m))
        return value
