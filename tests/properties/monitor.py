"""Bounded STL on one run by trying every instant that matters: slow, and nothing of the analyses in it.

All numbers of a run and a formula are multiples of some unit u. Between two neighbouring multiples nothing changes, and
a window moved by a multiple of u covers such a gap from its middle or not at all. So instants at the multiples and in
the middles stand for all.
"""

from dataclasses import dataclass
from fractions import Fraction as Q
from math import gcd, lcm

MOST = 240  # instants


@dataclass(frozen=True)
class Stay:
    """A dwell: its mode, clocks (value, slope) when it begins, and the jump that led to it."""

    mode: int
    clocks: dict
    begin: Q
    length: Q
    edge: str | None


@dataclass(frozen=True)
class Point:
    """One instant of a run."""

    stay: Stay
    time: Q
    values: dict
    landed: bool


def unit_of(numbers):
    """The greatest number of which all are multiples."""
    numbers = [n for n in numbers if n]
    whole = lcm(*(n.denominator for n in numbers))
    return Q(gcd(*(int(n * whole) for n in numbers)), whole)


def points(stays, thresholds, windows, horizon):
    """Instants that stand for all instants of a run up to the horizon; None where they are too many."""
    numbers = [Q(1), *windows]
    for s in stays:
        numbers += [s.begin, s.length]
        numbers += [(c - v) / slope for v, slope in s.clocks.values() if slope for c in thresholds]
    half = unit_of(numbers) / 2
    if horizon / half > MOST:
        return None
    found = []
    for s in stays:
        for n in range(int(s.length / half) + 1):
            t = n * half
            if s.begin + t <= horizon:
                values = {v: x + slope * t for v, (x, slope) in s.clocks.items()}
                found.append(Point(s, s.begin + t, values, n == 0 and s.edge is not None))
    return found


def truth(formula, instants):
    """Where a formula holds, instant by instant; a formula is a callable on points or `(operator, ...)`."""
    if callable(formula):
        return [formula(p) for p in instants]
    op = formula[0]
    if op == "not":
        return [not x for x in truth(formula[1], instants)]
    if op in ("and", "or", "implies"):
        a, b = truth(formula[1], instants), truth(formula[2], instants)
        join = {"and": lambda x, y: x and y, "or": lambda x, y: x or y, "implies": lambda x, y: not x or y}[op]
        return [join(x, y) for x, y in zip(a, b, strict=True)]
    low, high = formula[1], formula[2]
    a = truth(formula[3], instants)
    if op == "globally":
        return [all(a[j] for j in seen(instants, i, low, high)) for i in range(len(instants))]
    if op == "eventually":
        return [any(a[j] for j in seen(instants, i, low, high)) for i in range(len(instants))]
    b = truth(formula[4], instants)
    return [reached(a, b, i, set(seen(instants, i, low, high))) for i in range(len(instants))]


def reached(a, b, i, window):
    """Whether b holds somewhere in the window, and a from the i-th instant until just before."""
    for j in range(i, len(a)):
        if j in window and b[j]:
            return True
        if not a[j]:
            return False
    return False


def seen(instants, i, low, high):
    """The instants in the window of the i-th."""
    first, last = instants[i].time + low, instants[i].time + high
    for j in range(i, len(instants)):
        if instants[j].time > last:
            return
        if instants[j].time >= first:
            yield j
