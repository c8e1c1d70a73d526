"""Exact points near floats: random ones that satisfy conditions, rounded, with equations solved for some names."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from math import isqrt

from haverify.analyses.synthesis.samples import branches, inside
from haverify.maths.polynomial import Polynomial
from haverify.obligations.formula import Formula, holds

Point = dict[str, Fraction]
DENOMINATORS = (1, 2, 4, 5, 13, 25, 64, 1000, 10**6)
POINTS = 12


def exact_points(entries: Sequence[Formula], names: Sequence[str]) -> Iterator[Point]:
    """Points with rational coordinates at which all entries hold; some of those there are."""
    for literals in branches(entries):
        for point in inside(literals, names, POINTS):
            floats = dict(zip(names, map(float, point), strict=True))
            for denominator in DENOMINATORS:
                rounded = {v: Fraction(round(x * denominator), denominator) for v, x in floats.items()}
                found = _solved([q.polynomial for q in literals if q.op == "=="], rounded)
                if found is not None and all(holds(q, found) for q in literals):
                    yield found
                    break


def _solved(equations: Sequence[Polynomial], rounded: Point) -> Point | None:
    """The point moved onto the equations, most of them solved for a name of their own; None where that fails."""
    left = pivots(equations)
    point = {v: q for v, q in rounded.items() if v not in left}
    while left:
        name = next((v for v, e in left.items() if all(w == v or w in point for w in e.variables)), None)
        if name is None:
            return None
        root = _root(left.pop(name).fix(point), name, rounded[name])
        if root is None:
            return None
        point[name] = root
    return point


def pivots(equations: Sequence[Polynomial]) -> dict[str, Polynomial]:
    """Equations by a name of low degree that is in few of them; an equation without a name of its own is left out."""
    found: dict[str, Polynomial] = {}
    for e in sorted(equations, key=lambda p: len(p.variables)):
        free = [v for v in e.variables if v not in found]
        if free:
            name = min(free, key=lambda v: (e.degree(v), sum(v in o.variables for o in equations), v))
            found[name] = e
    return found


def _root(p: Polynomial, name: str, near: Fraction) -> Fraction | None:
    """The rational zero, next to a number, of a polynomial of degree 1 or 2 in one name."""
    c, b, a, *more = [*p.univariate(), Fraction(0), Fraction(0)][:4]
    if any(more):
        return None
    if not a:
        return -c / b if b else (near if not c else None)
    square = b * b - 4 * a * c
    if square < 0:
        return None
    root = Fraction(isqrt(square.numerator), isqrt(square.denominator))
    if root * root != square:
        return None
    return min(((-b + s * root) / (2 * a) for s in (1, -1)), key=lambda x: abs(x - near))
