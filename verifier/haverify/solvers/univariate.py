"""Conjunctions of polynomial conditions in one unknown, decided exactly by their signs between and at all roots."""

from __future__ import annotations

from fractions import Fraction

from haverify.maths.sturm import sign_vectors
from haverify.maths.univariate import Integers, integers
from haverify.solvers.answer import Undecided
from haverify.solvers.linear import Infeasible, Row

MAX_DEGREE = 60


def solve(rows: list[Row], name: str) -> dict[str, Fraction] | Infeasible | Undecided:
    """A point of the line where all rows hold, or a contradiction. A solution that is no rational is left undecided."""
    polynomials = [integers(r.poly.univariate())[0] for r in rows]
    if sum(len(p) - 1 for p in polynomials) > MAX_DEGREE:
        return Undecided("the degree of the condition is too high")
    bound = max(_root_bound(p) for p in polynomials)
    is_irrational = False
    for place, signs in sign_vectors(polynomials, -bound, bound):
        if all(_is_met(s, r.relation) for s, r in zip(signs, rows, strict=True)):
            if place.low == place.high:
                return {name: place.low}
            is_irrational = True
    if is_irrational:
        return Undecided("the only solutions are irrational")
    return Infeasible(frozenset(k for r in rows for k in r.origins))


def _is_met(sign: int, relation: str) -> bool:
    return sign == 0 if relation == "==" else sign < 0 or (sign == 0 and relation == "<=")


def _root_bound(p: Integers) -> Fraction:
    """All real roots of `p` lie strictly between -bound and bound."""
    return 2 + max((abs(Fraction(c, p[-1])) for c in p), default=Fraction(0))
