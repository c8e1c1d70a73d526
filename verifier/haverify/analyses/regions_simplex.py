"""Is a region empty? The simplex method with exact numbers: a point of the region, or multipliers that show none."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from haverify.analyses.regions import Terms

End = tuple[Fraction, int]
Directions = Mapping[Terms, tuple[End, End]]
"""Ends of directions, the axes first; an end is a number, and 1 just above it, -1 just below it."""
Pair = tuple[Fraction, Fraction]  # a number and a multiple of an infinitely small positive one
Multiplier = tuple[int, Fraction]
"""Which bound (2k: the lower, 2k + 1: the upper one of the k-th direction), how often."""


def _plus(a: Pair, b: Pair, times: Fraction) -> Pair:
    return a[0] + times * b[0], a[1] + times * b[1]


class Tableau:
    """The directions of a region as variables; the axes start nonbasic, other directions are sums of them.

    `rows[i][j]`: how often the nonbasic variable j is in the basic variable i.
    """

    def __init__(self, ends: Directions) -> None:
        directions = list(ends)
        place = {d: k for k, d in enumerate(directions)}
        self.bounds = [_pairs(ends[d]) for d in directions]
        self.rows = {
            place[d]: {place[((v, Fraction(1)),)]: q for v, q in d} for d in directions if len(d) > 1
        }  # an axis is its own direction
        self.values: list[Pair] = [low for low, _ in self.bounds]
        for i, row in self.rows.items():
            self.values[i] = self._sum(row)

    def _sum(self, row: Mapping[int, Fraction]) -> Pair:
        total: Pair = (Fraction(0), Fraction(0))
        for j, q in row.items():
            total = _plus(total, self.values[j], q)
        return total

    def conflict(self) -> list[Multiplier] | None:
        """Multipliers of bounds that contradict each other; None when the values meet all bounds."""
        for k, (low, high) in enumerate(self.bounds):
            if low > high:
                return [(2 * k, Fraction(1)), (2 * k + 1, Fraction(1))]
        while True:
            wrong = next((i for i in sorted(self.rows) if not self._fits(i)), None)
            if wrong is None:
                return None
            is_low = self.values[wrong] < self.bounds[wrong][0]
            entering = next((j for j, q in sorted(self.rows[wrong].items()) if self._moves(j, (q > 0) is is_low)), None)
            if entering is None:
                return self._explain(wrong, is_low)
            self._pivot(wrong, entering, self.bounds[wrong][0 if is_low else 1])

    def _fits(self, i: int) -> bool:
        return self.bounds[i][0] <= self.values[i] <= self.bounds[i][1]

    def _moves(self, j: int, upwards: bool) -> bool:
        return self.values[j] < self.bounds[j][1] if upwards else self.values[j] > self.bounds[j][0]

    def _explain(self, i: int, is_low: bool) -> list[Multiplier]:
        found = [(2 * i + (0 if is_low else 1), Fraction(1))]
        found += [(2 * j + (1 if (q > 0) is is_low else 0), abs(q)) for j, q in sorted(self.rows[i].items())]
        return found

    def _pivot(self, i: int, j: int, target: Pair) -> None:
        """The basic variable i takes its bound and leaves the basis; j enters."""
        row = self.rows.pop(i)
        q = row.pop(j)
        step = _plus(target, self.values[i], Fraction(-1))
        self.values[i] = target
        self.values[j] = _plus(self.values[j], step, 1 / q)
        entered = {i: 1 / q, **{k: -c / q for k, c in row.items()}}
        for k, other in self.rows.items():
            times = other.pop(j, None)
            if times is not None:
                for m, c in entered.items():
                    left = other.get(m, Fraction(0)) + times * c
                    if left:
                        other[m] = left
                    else:
                        other.pop(m, None)
                self.values[k] = self._sum(other)
        self.rows[j] = entered

    def point(self, names: list[Terms]) -> dict[Any, Fraction]:
        """Rational values of the axes, the infinitely small number chosen small enough."""
        small = Fraction(1)
        for (q, e), (low, high) in zip(self.values, self.bounds, strict=True):
            for gap, slope in ((q - low[0], low[1] - e), (high[0] - q, e - high[1])):
                if slope > 0 and gap < slope * small:
                    small = gap / slope
        return {d[0][0]: self.values[k][0] + small * self.values[k][1] for k, d in enumerate(names) if len(d) == 1}


def _pairs(ends: tuple[End, End]) -> tuple[Pair, Pair]:
    (low, above), (high, below) = ends
    return (low, Fraction(above)), (high, Fraction(below))


def solve(ends: Directions) -> dict[Any, Fraction] | list[Multiplier]:
    """A point of the region, or multipliers as a Farkas leaf has them."""
    tableau = Tableau(ends)
    found = tableau.conflict()
    return tableau.point(list(ends)) if found is None else found
