"""Conjunctions of polynomial conditions in one unknown, decided exactly by their signs between and at all roots."""

from __future__ import annotations

from fractions import Fraction

from haverify.maths import bernstein
from haverify.maths.sturm import sign_vectors
from haverify.maths.univariate import Integers, integers, sign_at
from haverify.solvers.answer import Undecided
from haverify.solvers.linear import Infeasible, Row

MAX_DEGREE = 60
MAX_CORE = 12
MOST_HALVINGS = 32


def solve(rows: list[Row], name: str) -> dict[str, Fraction] | Infeasible | Undecided:
    """A point of the line where all rows hold, or a contradiction. A solution that is no rational is left undecided."""
    found = _search(rows)
    if isinstance(found, Fraction):
        return {name: found}
    if isinstance(found, Undecided):
        return found
    return Infeasible(frozenset(k for r in _needed(rows) for k in r.origins))


def _needed(rows: list[Row]) -> list[Row]:
    """Rows that still contradict each other, none of them superfluous."""
    for row in rows if len(rows) <= MAX_CORE else ():
        others = [r for r in rows if r is not row]
        if others and _search(others) is None:
            return _needed(others)
    return rows


def _search(rows: list[Row]) -> Fraction | Undecided | None:
    """A point where the rows hold, None where there is none."""
    polynomials = [integers(r.poly.univariate())[0] for r in rows]
    if sum(len(p) - 1 for p in polynomials) > MAX_DEGREE:
        return Undecided("the degree of the condition is too high")
    low, high = _window(rows, polynomials)
    if low > high:
        return None
    relations = [r.relation for r in rows]
    for x in (low, (low + high) / 2, high):
        if all(_is_met(sign_at(p, x), r) for p, r in zip(polynomials, relations, strict=True)):
            return x
    if low < high:
        is_settled, point = _bisected(polynomials, relations, low, high)
        if is_settled:
            return point
    is_irrational = False
    for piece in sign_vectors(polynomials, low, high):
        if all(_is_met(s, r) for s, r in zip(piece.signs, relations, strict=True)):
            if piece.place.low == piece.place.high:
                return piece.place.low
            is_irrational = True
    return Undecided("the only solutions are irrational") if is_irrational else None


def _window(rows: list[Row], polynomials: list[Integers]) -> tuple[Fraction, Fraction]:
    """An interval outside of which no row changes its sign or a linear row fails."""
    bound = max(_root_bound(p) for p in polynomials)
    low, high = -bound, bound
    for p, row in zip(polynomials, rows, strict=True):
        if len(p) == 2:
            root = Fraction(-p[0], p[1])
            if row.relation == "==" or p[1] < 0:
                low = max(low, root)
            if row.relation == "==" or p[1] > 0:
                high = min(high, root)
    return low, high


def _bisected(
    polynomials: list[Integers], relations: list[str], low: Fraction, high: Fraction
) -> tuple[bool, Fraction | None]:
    """Whether a few halvings of the interval settle the question, and then a point where all rows hold, if any.

    A part is given up where the Bernstein coefficients of a row show that it fails throughout.
    """
    whole = [bernstein.coefficients(p or (0,), low, high)[0] for p in polynomials]
    pending = [(low, high, whole)] if not _fail(whole, relations) else []
    for _ in range(MOST_HALVINGS):
        if not pending:
            return True, None
        a, b, forms = pending.pop(0)
        left, right = zip(*map(bernstein.halves, forms), strict=True)
        middle = (a + b) / 2
        if all(_is_met((v > 0) - (v < 0), r) for (*_, v), r in zip(left, relations, strict=True)):
            return True, middle
        parts = ((a, middle, list(left)), (middle, b, list(right)))
        pending += [part for part in parts if not _fail(part[2], relations)]
    return False, None


def _fail(forms: list[list[int]], relations: list[str]) -> bool:
    """Whether a row fails on the whole interval on which it has these Bernstein coefficients."""
    return any(_fails(min(form), max(form), r) for form, r in zip(forms, relations, strict=True))


def _fails(least: int, greatest: int, relation: str) -> bool:
    return least > 0 or (relation == "<" and least == 0) or (relation == "==" and greatest < 0)


def _is_met(sign: int, relation: str) -> bool:
    return sign == 0 if relation == "==" else sign < 0 or (sign == 0 and relation == "<=")


def _root_bound(p: Integers) -> Fraction:
    """All real roots of `p` lie strictly between -bound and bound."""
    return 2 + max((abs(Fraction(c, p[-1])) for c in p), default=Fraction(0))
