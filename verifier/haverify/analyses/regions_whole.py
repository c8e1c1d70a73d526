"""Numbers and regions of a search in whole numbers.

All lines are multiplied by one number that makes their coefficients whole. Ends of a region are in units so small that
they are whole too, and a unit is worth `TINY`: x > 5 begins at 5 units of TINY, plus 1. No sum of such ones comes near
TINY, so strictness is exact while every end is one closed number.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from functools import reduce
from math import gcd, lcm
from operator import or_
from typing import Any

from haverify.analyses.regions import Node, Terms, Truth, combine

Ranges = Mapping[str, tuple[Fraction, Fraction]]
Ends = tuple[int, int]
TINY = 1 << 80
"""Coefficients of sums are far below; `hacheck` takes no such shortcut."""


def line(constant: int, terms: Mapping[int, int]) -> Node:
    """A linear number; its names are bits."""
    kept = tuple(sorted([(v, q) for v, q in terms.items() if q]))
    return Node("lin", (constant, kept), reduce(or_, [v for v, _ in kept], 0))


class Whole:
    """Numbers and truths with whole coefficients and with bits for names."""

    def __init__(self, truth: Truth, names: list[str]) -> None:
        self.bits = {v: 1 << k for k, v in enumerate(names)}
        self.factor = lcm(*{q.denominator for n in _lines(truth) for q in (n.parts[0], *[k for _, k in n.parts[1]])})
        self._needed: dict[Node, int] = {}
        self._made: dict[tuple[Node, int], Node] = {}

    def truth(self, t: Truth) -> Truth:
        """The truth; both sides of a comparison are multiplied by the same number."""
        if isinstance(t, bool):
            return t
        made = self._made.get((t, 0))
        if made is None:
            parts: Any = t.parts
            if t.op == "le":
                times = lcm(*map(self._needs, parts[:2]))
                parts = (self.number(parts[0], times), self.number(parts[1], times), parts[2])
            else:
                parts = tuple(map(self.truth, parts))
            made = self._made[t, 0] = Node(t.op, parts, self._names(t))
        return made

    def number(self, n: Node, times: int) -> Node:
        """A multiple of a number, `times` what its lines are multiplied by."""
        made = self._made.get((n, times))
        if made is None:
            made = self._made[n, times] = self._multiple(n, times)
        return made

    def _multiple(self, n: Node, times: int) -> Node:
        names, k, parts = self._names(n), self.factor * times, n.parts
        if n.op == "lin":
            terms = tuple([(self.bits[v], int(k * q)) for v, q in parts[1]])
            return Node("lin", (int(k * parts[0]), terms), names)
        if n.op == "sum":
            inner = lcm(*[self._needs(m) for _, m in parts[1]])
            made = tuple([(int(q * times / inner), self.number(m, inner)) for q, m in parts[1]])
            return Node("sum", (int(k * parts[0]), made), names)
        if n.op == "if":
            return Node("if", (self.truth(parts[0]), *[self.number(m, times) for m in parts[1:]]), names)
        return Node(n.op, tuple([self.number(m, times) for m in parts]), names)

    def _needs(self, n: Node) -> int:
        """A multiple of its lines' factor that makes a number whole: factors of sums may be fractions."""
        found = self._needed.get(n)
        if found is None:
            if n.op == "sum":
                inner = [self._needs(m) for _, m in n.parts[1]]
                found = lcm(n.parts[0].denominator, *[q.denominator for q, _ in n.parts[1]]) * lcm(*inner)
            else:
                found = 1 if n.op == "lin" else lcm(*map(self._needs, n.parts[1:] if n.op == "if" else n.parts))
            self._needed[n] = found
        return found

    def _names(self, n: Node) -> int:
        return sum([self.bits[v] for v in n.names])


def _lines(truth: Truth) -> Iterator[Node]:
    stack, seen = [truth], set()
    while stack:
        n = stack.pop()
        if isinstance(n, bool) or n in seen:
            continue
        seen.add(n)
        if n.op == "lin":
            yield n
        elif n.op == "sum":
            stack.extend([m for _, m in n.parts[1]])
        else:
            stack.extend(n.parts)


# ---- regions --------------------------------------------------------------------


class Region:
    """All points with each axis, and each direction, between its ends; `unit` is worth 1, a multiple of TINY.

    Directions are terms with whole coefficients without a common factor, the first of them positive.
    """

    def __init__(self, unit: int, axes: dict[int, Ends], across: dict[Terms, Ends]) -> None:
        self.unit, self.axes, self.across = unit, axes, across

    def enclose(self, constant: int, terms: Terms) -> Ends:
        """The ends of a linear number, from the axes and from its own direction."""
        low = high = constant * self.unit
        axes = self.axes
        for v, q in terms:
            a, b = axes[v]
            if q > 0:
                low += q * a
                high += q * b
            else:
                low += q * b
                high += q * a
        if self.across and len(terms) > 1:
            g, direction = primitive(terms)
            known = self.across.get(direction)
            if known is not None:
                base = constant * self.unit
                a, b = (
                    (base + g * known[0], base + g * known[1]) if g > 0 else (base + g * known[1], base + g * known[0])
                )
                low, high = max(low, a), min(high, b)
        return low, high

    def split(self, terms: Terms, relation: str, at: Fraction) -> tuple[Region, Region]:
        """Where a direction is at most a number (`<=`) or below it (`<`), and the rest."""
        here = self.finer(at.denominator // gcd(at.denominator, self.unit // TINY))
        low, high = here.enclose(0, terms)
        end = int(at * here.unit) - (relation == "<")
        return here._part(terms, low, min(high, end)), here._part(terms, max(low, end + 1), high)

    def _part(self, terms: Terms, low: int, high: int) -> Region:
        if len(terms) > 1:
            return Region(self.unit, self.axes, {**self.across, terms: (low, high)})
        return Region(self.unit, {**self.axes, terms[0][0]: (low, high)}, self.across)

    def finer(self, factor: int) -> Region:
        """The same with a larger unit, if the factor is not 1."""
        if factor == 1:
            return self

        def end(e: int) -> int:
            q, nudge = parted(e)
            return q * factor * TINY + nudge

        axes = {v: (end(a), end(b)) for v, (a, b) in self.axes.items()}
        return Region(self.unit * factor, axes, {d: (end(a), end(b)) for d, (a, b) in self.across.items()})

    def exact(self) -> dict[Terms, tuple[tuple[Fraction, int], tuple[Fraction, int]]]:
        """All directions, the axes first, beginning with coefficient 1; an end is (number, 1 above it or -1 below)."""
        out = {}
        for d, ends in [*((((v, 1),), e) for v, e in self.axes.items()), *self.across.items()]:
            first = d[0][1]
            numbers = [(Fraction(parted(e)[0] * TINY, self.unit * first), _sign(parted(e)[1])) for e in ends]
            out[tuple([(v, Fraction(q, first)) for v, q in d])] = (numbers[0], numbers[1])
        return out


def parted(end: int) -> tuple[int, int]:
    """An end in units of TINY, and what it is above or below that."""
    q = (end + TINY // 2) // TINY
    return q, end - q * TINY


def _sign(n: int) -> int:
    return (n > 0) - (n < 0)


def primitive(terms: Terms) -> tuple[int, Terms]:
    """A factor and a direction whose product the terms are."""
    g = gcd(*[q for _, q in terms])
    if terms[0][1] < 0:
        g = -g
    return g, tuple([(v, q // g) for v, q in terms])


def box(ranges: Ranges, grain: int = 1) -> Region:
    """All points with each name in its closed range; the unit is divisible by the grain."""
    unit = lcm(grain, *[q.denominator for ends in ranges.values() for q in ends]) * TINY
    axes = {1 << k: (int(ranges[v][0] * unit), int(ranges[v][1] * unit)) for k, v in enumerate(sorted(ranges))}
    return Region(unit, axes, {})


def difference(a: Node, b: Node) -> Node:
    """The difference of two numbers."""
    if a.op == b.op == "lin" and not (a.names and b.names):
        terms = a.parts[1] or tuple([(v, -q) for v, q in b.parts[1]])
        return Node("lin", (a.parts[0] - b.parts[0], terms), a.names or b.names)
    return combine([(1, a), (-1, b)], 0, line)
