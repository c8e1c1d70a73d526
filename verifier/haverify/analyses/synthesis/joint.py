"""Barriers of several modes: a polynomial for each, at most -1 at starts, at least 1 at unsafe states.

Along flows `p' <= rate * p`; at a jump the polynomial of the mode entered is at most `share` times that of the mode
left. All of it is linear in the coefficients, so one semidefinite program asks for all modes; what comes out is only a
guess.

Source              S. Prajna, A. Jadbabaie, "Safety verification of hybrid systems using barrier certificates", 2004
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction

from haverify.analyses.synthesis.barriers import MOST_ENTRIES, Shape, cones_of, rounded
from haverify.analyses.synthesis.integrals import derivative
from haverify.analyses.synthesis.samples import branches
from haverify.analyses.synthesis.system import Hybrid
from haverify.maths.polynomial import Polynomial, constant, variable
from haverify.obligations.formula import Formula, Literal, negation
from haverify.solvers.positivity import semidefinite
from haverify.solvers.positivity.ansatz import Ansatz, Cone, Free, monomials
from haverify.text.record import record

MOST_CASES = 4


@record
class JointShape:
    """The shape of each barrier, and the share of the barrier before a jump that the one after it may have."""

    shape: Shape
    share: Fraction


SHAPES = tuple(
    JointShape(Shape(d, d + 2, rate), Fraction(share))
    for d in (2, 4)
    for share in (1, 0)
    for rate in (Fraction(0), Fraction(-1), Fraction(1), Fraction(-1, 10))
)
Frame = dict[str, tuple[Fraction, Fraction]]
Asked = tuple[Polynomial, Sequence[Literal], int, dict[tuple[str, Polynomial], Polynomial]]


def joint_barrier(
    hybrid: Hybrid, kept: dict[str, list[Literal]], frame: Frame, shape: JointShape, seconds: float
) -> dict[str, Polynomial] | None:
    """A polynomial for each mode; `frame`: a middle and a size for each name, in which the program is stated."""
    there = {v: variable(v).scaled(size) + constant(middle) for v, (middle, size) in frame.items()}
    back = {v: (variable(v) - constant(middle)).scaled(1 / size) for v, (middle, size) in frame.items()}
    names = tuple(sorted({v for s in hybrid.systems.values() for v in s.field if v != "time"}))
    basis = [m.substitute(back) for m in monomials(names, shape.shape.degree)]
    coefficients: dict[tuple[str, Polynomial], Polynomial] = {
        (m, b): constant(0) for m in hybrid.systems for b in basis
    }
    target = constant(0)
    cones: list[Cone | Free] = []
    for k, (wanted, premises, kind, part) in enumerate(_asked(hybrid, kept, shape, basis)):
        tag = variable(f"?{k}")
        target += wanted * tag
        for key, poly in part.items():
            coefficients[key] += poly.substitute(there) * tag
        asked = tuple(sorted({v for q in premises for v in q.polynomial.variables} | set(names)))
        put = [Literal(q.op, q.polynomial.substitute(there)) for q in premises]
        cones += cones_of(k, tag, put, asked, shape.shape, is_flow=kind >= 2)
    free = [Free(("p", *key), poly) for key, poly in coefficients.items()]
    only = [c for c in cones if isinstance(c, Cone)]
    if sum(len(c.basis) * (len(c.basis) + 1) // 2 for c in only) > MOST_ENTRIES:
        return None
    ansatz = Ansatz(target, (*free, *(c for c in cones if isinstance(c, Free))), tuple(only))
    numbers = semidefinite.approximate(ansatz, seconds)
    if numbers is None:
        return None
    found = {m: [(b, numbers.get(("p", m, b), 0.0)) for b in basis] for m in hybrid.systems}
    largest = max(abs(c) for terms in found.values() for _, c in terms)
    polys = {m: rounded(terms, {}, largest) for m, terms in found.items()}
    return {m: p for m, p in polys.items() if p is not None} if all(p is not None for p in polys.values()) else None


def _asked(
    hybrid: Hybrid, kept: dict[str, list[Literal]], shape: JointShape, basis: Sequence[Polynomial]
) -> Iterator[Asked]:
    """`wanted + sum coefficient * part` has to be at most 0 where the premises hold."""
    for m, s in hybrid.systems.items():
        for start in s.starts:
            for case in branches([*start.entries], MOST_CASES):
                yield constant(1), case, 0, {(m, b): b for b in basis}
        known: list[Formula] = [*s.common.entries, *kept[m]]
        for case in branches([*known, negation(s.goal)], MOST_CASES):
            yield constant(1), case, 1, {(m, b): -b for b in basis}
        for case in branches(known, 1):
            flow = {(m, b): derivative(b, s.field) - b.scaled(shape.shape.rate) for b in basis}
            yield constant(0), case, 2, flow
    for j in hybrid.jumps:
        for case in branches([*j.known.entries, *kept[j.source]], MOST_CASES):
            part = {(j.target, b): b.substitute(j.landing) for b in basis}
            for b in basis:
                part[j.source, b] = part.get((j.source, b), constant(0)) - b.scaled(shape.share)
            yield constant(0), case, 3, part
