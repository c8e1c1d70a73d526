"""Bounded STL in three values on dwells whose lengths are known within bounds (S21).

A place on a timeline is (dwell, x, side): just before (side 0) or after (1) the instant x of that dwell. Sets of
instants are lists of disjoint [place, place) in order; a signal is (where it must hold, where it may hold).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from fractions import Fraction
from itertools import accumulate, pairwise
from typing import Any, NamedTuple

from hacheck.expressions import nodes
from hacheck.rational import Beyond, Refused, spend

Json = Any
Place = tuple[int, Fraction, int]
Set = list[tuple[Place, Place]]
Signal = tuple[Set, Set]
Read = Callable[[Json], Signal]
ZERO = Fraction(0)
TEMPORAL = {"globally": 3, "eventually": 3, "until": 4}


class Dwell(NamedTuple):
    """How long a dwell lasts, from `low` to `high`, and the clock when it begins."""

    low: Fraction
    high: Fraction
    first: Fraction
    last: Fraction


class Timeline:
    """Dwells one after the other, and operations on sets of their instants."""

    def __init__(self, dwells: list[Dwell], rate: tuple[Fraction, Fraction]) -> None:
        self.dwells, self.rate, self.end = dwells, rate, (len(dwells), ZERO, 0)
        self.lows, self.highs = (
            [ZERO, *accumulate(ends)] for ends in ([d.low for d in dwells], [d.high for d in dwells])
        )
        self.all: Set = [((0, ZERO, 0), self.end)]

    def place(self, i: int, x: Fraction, side: int) -> Place:
        """A place; behind the last instant of a dwell is before the first of the next."""
        return (i, x, side) if (x, side) < (self.dwells[i].high, 1) else (i + 1, ZERO, 0)

    def union(self, a: Set) -> Set:
        """The union of intervals in any order."""
        out: Set = []
        spend(4 * len(a) + 1)
        for low, high in sorted(x for x in a if x[0] < x[1]):
            if out and low <= out[-1][1]:
                out[-1] = (out[-1][0], max(out[-1][1], high))
            else:
                out.append((low, high))
        return out

    def rest(self, a: Set) -> Set:
        """The complement."""
        cuts = [(0, ZERO, 0), *(p for x in a for p in x), self.end]
        return self.union(list(zip(cuts[::2], cuts[1::2], strict=True)))

    def common(self, a: Set, b: Set) -> Set:
        """The intersection."""
        out, i, j = Set(), 0, 0
        while i < len(a) and j < len(b):
            spend(3)
            low, high = max(a[i][0], b[j][0]), min(a[i][1], b[j][1])
            out += [(low, high)] if low < high else []
            i, j = (i + 1, j) if a[i][1] <= b[j][1] else (i, j + 1)
        return out

    def least(self, i: int, j: int) -> Fraction:
        """The least time from the beginning of dwell i to that of j."""
        return max(self.lows[j] - self.lows[i], self.dwells[j].first - self.dwells[i].last)

    def most(self, i: int, j: int) -> Fraction:
        """The greatest time from the beginning of dwell i to that of j."""
        return min(self.highs[j] - self.highs[i], self.dwells[j].last - self.dwells[i].first)

    def before(
        self, span: tuple[Place, Place], a: Fraction, b: Fraction, sure: bool, need: int
    ) -> Iterator[tuple[Place, Place]]:
        """Where some instant of a span lies in the window [a, b], surely or perhaps; none of them after the span."""
        (j, x, side), (k, y, edge) = span
        if (y, edge) == (ZERO, 0):
            k, y, edge = k - 1, self.dwells[k - 1].high, 1
        reached = (x, side) < (self.dwells[j].low, 1)  # the run surely gets to the span
        ending = min((y, edge), (self.dwells[k].low, 1)) if sure else (y, edge)
        for i in range(min(k, need), -1, -1):
            spend(10)
            low, high = (ZERO, 0), (self.dwells[i].high, 1)
            if i < j and (x + self.least(i + 1, j), side) >= (b, 1):
                return
            if i <= j and not (sure and not reached):
                low = x + (self.most if sure else self.least)(i, j) - b, side
            elif i <= j:
                low, high = (x, side), high if i == j else (ZERO, 0)
            if not sure:
                high = min(high, (y + self.most(i, k) - a, edge))
            elif i == k:
                high = min(high, (y, edge) if a == 0 else (ending[0] - a, ending[1]))
            elif (ending[0] + self.least(i + 1, k), ending[1]) <= (a, 0):
                high = min(high, (ending[0] + self.least(i, k) - a, ending[1]))
            low = max(low, (ZERO, 0))
            if low < high:
                yield self.place(i, *low), self.place(i, *high)

    def until(self, x: Signal, y: Signal, a: Fraction, b: Fraction, need: int) -> Signal:
        """`x until[a, b] y`: what x is at the instant where y holds does not matter."""
        out = []
        for sure in (True, False):
            from_, goals = (x[0], y[0]) if sure else (self.loose(x[1]), y[1])
            low_rate, high_rate = self.rate[::-1] if sure else self.rate
            found = list(goals) if a == 0 else []
            for chain in from_:
                low, (i, q, _) = chain
                behind = self.place(i, q, 1) if i < len(self.dwells) else self.end
                for goal in self.common(goals, [(low, behind)]):
                    for span in [goal] if sure else self.pieces(goal):
                        seen = self.union(list(self.before(span, a * low_rate, b * high_rate, sure, need)))
                        found += self.common(seen, [chain])
            out.append(self.union(found))
        return out[0], out[1]

    def pieces(self, span: tuple[Place, Place]) -> Set:
        """A span cut where dwells meet."""
        (j, _, _), (k, y, edge) = span
        cuts = [span[0], *((i, ZERO, 0) for i in range(j + 1, k + ((y, edge) > (ZERO, 0)))), span[1]]
        return list(pairwise(cuts))

    def loose(self, a: Set) -> Set:
        """A set and all instants that a run which leaves early does not have."""
        return self.union(a + [(self.place(i, d.low, 1), (i + 1, ZERO, 0)) for i, d in enumerate(self.dwells)])

    def value(self, e: Json, read: Read, time: Callable[[Json], Fraction], limit: Fraction = ZERO) -> Signal:
        """Where a formula must and where it may hold, at instants up to a limit."""
        spend(10)
        if not temporal(e):
            return read(e)
        if e[0] in TEMPORAL:
            a, b = window(e, time)
            need = max(i for i in range(len(self.dwells)) if self.least(0, i) <= limit)
            x, *y = (self.value(z, read, time, limit + b * self.rate[1]) for z in e[3:])
            if e[0] == "globally":
                return self.neg(self.until((self.all, self.all), self.neg(x), a, b, need))
            return self.until(x, y[0], a, b, need) if y else self.until((self.all, self.all), x, a, b, need)
        first, *others = (self.value(x, read, time, limit) for x in e[1:])
        if e[0] in ("not", "implies"):
            first = self.neg(first)
        join = self.common if e[0] == "and" else lambda s, t: self.union(s + t)
        for other in others:
            first = join(first[0], other[0]), join(first[1], other[1])
        return first

    def neg(self, x: Signal) -> Signal:
        """`not`."""
        return self.rest(x[1]), self.rest(x[0])


def temporal(e: Json) -> bool:
    """Does it speak of more than one instant?"""
    return any(n[0] in TEMPORAL for n in nodes(e))


def window(e: Json, time: Callable[[Json], Fraction]) -> tuple[Fraction, Fraction]:
    """The window of a temporal operator."""
    if len(e) != TEMPORAL[e[0]] + 1:
        raise Refused(f"`{e[0]}` has a wrong number of operands")
    a, b = time(e[1]), time(e[2])
    if not 0 <= a <= b:
        raise Beyond("a window without an instant, or one that looks back")
    return a, b


def horizon(e: Json, time: Callable[[Json], Fraction]) -> Fraction:
    """How long after an instant a formula still looks."""
    spend(5)
    if not temporal(e):
        return ZERO
    if e[0] not in (*TEMPORAL, "and", "or", "not", "implies"):
        raise Beyond(f"`{e[0]!s:.20}` around a temporal operator")
    below = max(horizon(x, time) for x in e[3 if e[0] in TEMPORAL else 1 :])
    return window(e, time)[1] + below if e[0] in TEMPORAL else below


def atoms(e: Json) -> list[Json]:
    """The largest subformulas without temporal operators, each once, from left to right."""
    if not temporal(e):
        return [e]
    out: list[Json] = []
    for x in e[3 if e[0] in TEMPORAL else 1 :]:
        out += [a for a in atoms(x) if a not in out]
    return out
