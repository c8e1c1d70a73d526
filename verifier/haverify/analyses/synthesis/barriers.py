"""Barrier certificates: a polynomial between starts and unsafe states that grows at most exponentially.

Sought is p with `p <= -1` at the starts, `p >= 1` at unsafe states and `p' <= rate * p` in the domain, each as an
identity with sums of squares, all of them in one semidefinite program. What comes out is rounded and only a guess.

Source              H. Kong, F. He, X. Song, W. Hung, M. Gu, "Exponential-condition-based barrier certificate
                    generation for safety verification of hybrid systems", 2013
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from haverify.analyses.synthesis.integrals import Field, derivative
from haverify.maths.polynomial import Polynomial, constant, total, variable
from haverify.obligations.formula import Literal
from haverify.solvers.positivity import semidefinite
from haverify.solvers.positivity.ansatz import Ansatz, Cone, Free, monomials
from haverify.solvers.positivity.levels import MOST_PREMISES, Question, degree_in
from haverify.solvers.positivity.refute import coordinates
from haverify.text.record import record

BARRIER = -2
MOST_ENTRIES = 12000


@record
class Shape:
    """The degree of a barrier and of the identities about it, and the rate of its growth."""

    degree: int
    multipliers: int
    rate: Fraction


def barrier(
    domain: Sequence[Literal],
    start: Sequence[Literal],
    unsafe: Sequence[Literal],
    field: Field,
    names: tuple[str, ...],
    shape: Shape,
    seconds: float,
) -> Polynomial | None:
    """A polynomial that may be above 0 at all unsafe states and not where runs from the starts come to."""
    known = (*domain, *start, *unsafe)
    there, back = coordinates(Question(known, tuple(range(len(known))), total(variable(v) for v in names)))
    moved = {v: (field[v].substitute(there)).scaled(1 / there[v].terms[((v, 1),)]) for v in names if v in field}
    core = _core(names, moved)
    basis = monomials(core, shape.degree)
    if len(basis) > 300:
        return None
    tags = [variable(f"?{k}") for k in range(3)]
    unknowns = []
    for m in basis:
        flow = m.scaled(shape.rate) - derivative(m, moved)
        unknowns.append(Free((BARRIER, m), m * tags[0] - m * tags[1] - flow * tags[2]))
    cones = []
    for k, (tag, premises) in enumerate(zip(tags, (start, unsafe, domain), strict=True)):
        cones += cones_of(k, tag, [_moved(q, there) for q in premises], core, shape, is_flow=k == 2)
    free = [*unknowns, *(c for c in cones if isinstance(c, Free))]
    only = [c for c in cones if isinstance(c, Cone)]
    size = sum(len(c.basis) * (len(c.basis) + 1) // 2 for c in only)
    if size > MOST_ENTRIES:
        return None
    target = tags[0] + tags[1] + tags[2].scaled(Fraction(1, 1000))
    numbers = semidefinite.approximate(Ansatz(target, tuple(free), tuple(only)), seconds)
    if numbers is None:
        return None
    return rounded([(m, numbers.get((BARRIER, m), 0.0)) for m in basis], back)


def trap(
    domain: Sequence[Literal], field: Field, names: tuple[str, ...], rate: Fraction, seconds: float
) -> Polynomial | None:
    """A positive definite quadratic polynomial that decreases where it is large: `p' <= c - rate * p` for some c."""
    there, back = coordinates(Question(tuple(domain), tuple(range(len(domain))), total(variable(v) for v in names)))
    moved = {v: (field[v].substitute(there)).scaled(1 / there[v].terms[((v, 1),)]) for v in names if v in field}
    core = _core(names, moved)
    basis = monomials(core, 2)[1:]
    size, flow = variable("?0"), variable("?1")
    unknowns = [Free((BARRIER, m), -(m * size) + (derivative(m, moved) + m.scaled(rate)) * flow) for m in basis]
    unknowns += [Free((BARRIER, constant(1)), -flow), Free((BARRIER - 1, constant(1)), -size)]
    top = max([2, *(degree_in(derivative(m, moved), set(core)) for m in basis)])
    shape = Shape(2, top, rate)
    cones = [
        *cones_of(0, size, [], core, shape, is_flow=False),
        *cones_of(2, flow, [_moved(q, there) for q in domain], core, shape, is_flow=True),
    ]
    wanted = total(variable(v) * variable(v) for v in core) * size
    free, only = [f for f in cones if isinstance(f, Free)], [c for c in cones if isinstance(c, Cone)]
    if len(basis) > 100 or sum(len(c.basis) ** 2 for c in only) > 2 * MOST_ENTRIES:
        return None
    numbers = semidefinite.approximate(Ansatz(wanted, (*unknowns, *free), tuple(only)), seconds)
    return None if numbers is None else rounded([(m, numbers.get((BARRIER, m), 0.0)) for m in basis], back)


def rounded(found: Sequence[tuple[Polynomial, float]], back: Field, largest: float = 0.0) -> Polynomial | None:
    """The sum with coefficients rounded to 12 bits of the largest one (of several sums), in the system's names."""
    largest = largest or max(abs(c) for _, c in found)
    if not largest > 1e-9:
        return None
    return total(m.scaled(Fraction(round(c / largest * 2**12), 2**12)) for m, c in found).substitute(back)


def _core(names: tuple[str, ...], field: Field) -> tuple[str, ...]:
    """The names that move, where the others occur in the rates at most once; else all names."""
    fixed = {v for v in names if v not in field or not field[v].whole}
    rates = [field[v] for v in names if v in field]
    if any(degree_in(p, fixed) > 1 for p in rates) or len(fixed) == len(names):
        return names
    return tuple(v for v in names if v not in fixed)


def _moved(q: Literal, there: dict[str, Polynomial]) -> Literal:
    return Literal(q.op, q.polynomial.substitute(there))


def cones_of(
    k: int, tag: Polynomial, premises: Sequence[Literal], names: tuple[str, ...], shape: Shape, *, is_flow: bool
) -> list[Cone | Free]:
    """Sums of squares times premises, and multiples of equations, in identity k."""
    degree = shape.multipliers if is_flow else max([shape.degree, *(q.polynomial.total_degree() for q in premises)])
    degree += degree % 2
    found: list[Cone | Free] = [Cone((k,), tag, tuple(monomials(names, degree // 2)))]
    bounds = [-q.polynomial for q in premises if q.op in ("<", "<=") and q.polynomial.variables]
    for i, p in enumerate(_squeezed(bounds, names)):
        room = degree - degree_in(p, set(names))
        if room >= 0:
            found.append(Cone((k, i), p * tag * constant(_size(p)), tuple(monomials(names, room // 2))))
    for i, q in enumerate(premises):
        if q.op == "==":
            room = max(degree - degree_in(q.polynomial, set(names)), 0)
            found += [Free((k, -i - 1, m), m * q.polynomial * tag) for m in monomials(names, room)]
    return found


def _squeezed(bounds: Sequence[Polynomial], names: tuple[str, ...]) -> list[Polynomial]:
    """Polynomials that are at least 0; two that bound a quantity of `names` from both sides become their product."""
    found = []
    left = list(dict.fromkeys(bounds))[-MOST_PREMISES:]
    while left:
        p = left.pop(0)
        other = next((q for q in left if ((p + q).constant or 0) > 0), None)
        if other is not None and p.total_degree() == 1 and set(p.variables) <= set(names):
            left.remove(other)
            found.append(p * other)
        else:
            found.append(p)
    return found


def _size(p: Polynomial) -> Fraction:
    return 1 / max(map(abs, p.terms.values()))
