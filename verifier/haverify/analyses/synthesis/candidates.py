"""Polynomials and bounds worth trying as cuts."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from haverify.analyses.synthesis.samples import Samples, compiled, holds
from haverify.analyses.synthesis.system import System
from haverify.maths.polynomial import ZERO, Polynomial, constant, total, variable
from haverify.obligations.formula import Formula, Literal, literals
from haverify.obligations.premises import whole

TALL = 1e4
FIT = 1e-3
TINY = 1e-10  # runs that come to rest are off by as much, in floats


def closures(field: dict[str, Polynomial]) -> list[tuple[str, ...]]:
    """Sets of names whose rates mention no other names, each once, small ones first; the last one has all names."""
    needs = {v: set(p.variables) for v, p in field.items()}
    found = []
    for v in field:
        closed, todo = {v}, [v]
        while todo:
            for w in needs.get(todo.pop(), set()) - closed:
                closed.add(w)
                todo.append(w)
        found.append(tuple(sorted(closed)))
    everything = tuple(sorted(set(field).union(*needs.values()))) if field else ()
    return sorted({*found, everything}, key=lambda c: (len(c), c))


def contents(poly: Polynomial) -> list[Polynomial]:
    """The names that divide a polynomial, and what is left."""
    found = []
    for v in poly.variables:
        low = min(next((e for w, e in m if w == v), 0) for m in poly.whole)
        if low:
            found.append(variable(v))
            poly = Polynomial(
                {tuple((w, e - low * (w == v)) for w, e in m if e - low * (w == v)): c for m, c in poly.whole.items()},
                poly.divisor,
            )
    return [*found, poly] if poly.constant is None else found


def shapes(system: System) -> list[Polynomial]:
    """Polynomials in sight: names, those of starts and goal, factors of rates, sums of squares."""
    found = [variable(v) for v in system.field]
    found += [q.polynomial for q in literals(system.goal)]
    found += [q.polynomial for start in system.starts for e in start.entries for q in literals(e)]
    for p in system.field.values():
        found += contents(p)
    for group in closures(system.field):
        moving = [v for v in group if v in system.field and system.field[v].whole]
        if len(moving) > 1:
            found.append(total(variable(v) * variable(v) for v in moving))
    found += system.sight
    found += [_centred(p) for p in list(found) if p.total_degree() == 1]
    seen: set[Polynomial] = set()
    kept = []
    for p in found:
        bare = whole(p)
        if (
            any(system.field[v].whole for v in bare.variables if v in system.field)
            and bare not in seen
            and -bare not in seen
        ):
            seen.add(bare)
            kept.append(p)
    return kept


def _centred(p: Polynomial) -> Polynomial:
    """Without its constant term, made primitive."""
    return whole(Polynomial({m: c for m, c in p.whole.items() if m}))


def fits(q: Literal, samples: Samples) -> bool:
    """Whether the literal holds in the sampled states, as far as floats can tell."""
    import numpy

    states = samples.states
    states = states[numpy.abs(states).max(axis=1, initial=0) < TALL]
    value = compiled(q.polynomial, samples.names).value(states)
    size = compiled(_absolute(q.polynomial), samples.names).value(numpy.abs(states))
    room = TINY * max(map(float, map(abs, q.polynomial.terms.values())), default=0.0)
    if q.op == "==":
        return bool(numpy.all(abs(value) <= 1e-4 * size + room))
    return q.op == "!=" or bool(numpy.all(value <= FIT * size + room))


def leaves(goal: Formula, samples: Samples) -> bool:
    """Whether a sampled state clearly violates the goal, as far as floats can tell: then there is nothing to search."""
    import numpy

    states = samples.states
    states = states[numpy.abs(states).max(axis=1, initial=0) < TALL]
    return not bool(numpy.all(holds(goal, states, samples.names, FIT)))


def says_nothing(q: Literal, samples: Samples) -> bool:
    """Whether the literal, not strict, holds at points all over the place."""
    import numpy

    random = numpy.random.default_rng(3)
    points = random.standard_normal((400, len(samples.names))) * numpy.repeat([1.0, 10.0, 100.0, 1e4], 100)[:, None]
    return q.op == "<=" and bool(numpy.all(compiled(q.polynomial, samples.names).value(points) <= 0))


def _absolute(p: Polynomial) -> Polynomial:
    return Polynomial({m: abs(c) for m, c in p.whole.items()}, p.divisor)


def extremes(poly: Polynomial, points: Any, names: Sequence[str]) -> tuple[float, float] | None:
    """The least and the greatest value at the points."""
    import numpy

    values = compiled(poly, names).value(points)
    values = values[numpy.isfinite(values)]
    return (float(values.min()), float(values.max())) if len(values) else None


def simple_between(low: float, high: float) -> Fraction:
    """A rational of small denominator in the middle half of an interval."""
    from math import isfinite

    if not (isfinite(low) and isfinite(high)) or high <= low:
        return Fraction(low).limit_denominator(10**6)
    middle, room = (Fraction(low) + Fraction(high)) / 2, (Fraction(high) - Fraction(low)) / 4
    denominator = 1
    while True:
        found = Fraction(round(middle * denominator), denominator)
        if abs(found - middle) <= room:
            return found
        denominator *= 2


def below(poly: Polynomial, bound: Fraction = ZERO, op: str = "<=") -> Literal:
    """`poly <= bound`, primitive."""
    return Literal(op, whole(poly - constant(bound)))
