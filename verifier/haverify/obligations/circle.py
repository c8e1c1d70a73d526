"""Formulas freed of `pi`, of which only an enclosure is known: what is then false is false for pi itself."""

from __future__ import annotations

from fractions import Fraction
from math import comb

from haverify.maths.polynomial import Polynomial, constant, total
from haverify.obligations.formula import Formula, Junction, Literal, compare, conjunction, disjunction, negation

NAME = "pi"
Ends = tuple[Fraction, Fraction]


def weaker(f: Formula, ends: Ends) -> Formula:
    """A formula without `pi` that holds wherever `f` does for some value between the ends."""
    if isinstance(f, Junction):
        return (conjunction if f.is_and else disjunction)([weaker(m, ends) for m in f.members])
    if not isinstance(f, Literal) or NAME not in f.polynomial.variables:
        return f
    around = _around(f.polynomial, ends)
    if f.op != "==":
        return disjunction(compare(f.op, p) for p in around)
    return conjunction(disjunction(compare(op, p) for p in around) for op in ("<=", ">="))


def stronger(f: Formula, ends: Ends) -> Formula:
    """A formula without `pi` that holds only where `f` does for every value between the ends."""
    return negation(weaker(negation(f), ends))


def _around(p: Polynomial, ends: Ends) -> list[Polynomial]:
    """Polynomials between whose least and greatest `p` lies: its Bernstein coefficients in `pi`."""
    low, width = ends[0], ends[1] - ends[0]
    parts = p.coefficients(NAME)
    degree = len(parts) - 1
    # p(low + width u) in powers of u
    powers = [
        total(parts[k].scaled(comb(k, i) * low ** (k - i) * width**i) for k in range(i, degree + 1))
        for i in range(degree + 1)
    ]
    zero = constant(0)
    return [
        total([zero, *(powers[i].scaled(Fraction(comb(j, i), comb(degree, i))) for i in range(j + 1))])
        for j in range(degree + 1)
    ]
