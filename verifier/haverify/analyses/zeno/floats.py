"""Values in floats at corners and inner points of premises: they propose numbers and decide nothing."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import product
from math import cos, exp, inf, isfinite, log, prod, sin, sqrt
from random import Random

from haverify.maths.polynomial import Polynomial
from haverify.obligations.formula import Formula, Junction, Literal, literals
from haverify.obligations.functions import Functions
from haverify.obligations.premises import Premises
from haverify.solvers.positivity.refute import bounds_of

MOST_CORNERS, INNER = 512, 200
ROOM = 1e-9
OPS: dict[str, Callable[[float], float]] = {
    "sin": sin,
    "cos": cos,
    "exp": exp,
    "sqrt": sqrt,
    "log": log,
    "inv": lambda x: 1 / x,
}
Point = dict[str, float]


def value(p: Polynomial, point: Mapping[str, float], functions: Functions) -> float:
    """The value at a point; infinite where it is not defined."""
    try:
        terms = (float(c) * prod(_named(v, point, functions) ** e for v, e in m) for m, c in p.terms.items())
        found = float(sum(terms))
    except (ValueError, ZeroDivisionError, OverflowError, KeyError):
        return inf
    return found if isfinite(found) else inf


def _named(name: str, point: Mapping[str, float], functions: Functions) -> float:
    if name in functions.known:
        op, a = functions.known[name]
        return OPS[op](value(a, point, functions))
    return point[name]


def points(premises: Premises) -> Iterator[Point]:
    """Corners of the box that the premises give, and points inside of it, where these hold as far as floats tell."""
    entries, functions = premises.entries, premises.functions
    read = {v for f in entries for q in literals(f) for v in q.polynomial.variables}
    names = sorted(set(functions.support(read)))
    known = bounds_of(_literals(entries))
    ends = {v: (float(low), float(high)) for v, (low, high) in known.items() if low is not None and high is not None}
    if any(v not in ends for v in names):
        return
    random = Random(7)
    corners = product(*(dict.fromkeys(ends[v]) for v in names)) if 2 ** len(names) <= MOST_CORNERS else ()
    inner = ([random.uniform(*ends[v]) for v in names] for _ in range(INNER))
    for values in (*corners, *inner):
        point = dict(zip(names, values, strict=True))
        if all(_holds(f, point, functions) for f in entries):
            yield point


def _literals(entries: Sequence[Formula]) -> list[Literal]:
    return [f for f in entries if isinstance(f, Literal)]


def _holds(f: Formula, point: Point, functions: Functions) -> bool:
    if isinstance(f, Junction):
        return (all if f.is_and else any)(_holds(m, point, functions) for m in f.members)
    if not isinstance(f, Literal):
        return f
    x = value(f.polynomial, point, functions)
    room = ROOM * max(abs(float(c)) for c in f.polynomial.terms.values())
    return abs(x) <= room if f.op == "==" else x <= room or f.op == "!="
