"""Equations of the starts that the flow keeps together: the largest space of their combinations closed under it."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from haverify.analyses.synthesis.integrals import Field, derivative
from haverify.maths.elimination import kernel
from haverify.maths.polynomial import Monomial, Polynomial, total
from haverify.obligations.premises import whole
from haverify.solvers.positivity.ansatz import monomials

MOST_UNKNOWNS = 1500


def kept_together(equations: Sequence[Polynomial], field: Field) -> list[Polynomial]:
    """Independent combinations (with numbers) of the equations, whose derivatives are in the ideal of all of them.

    Multipliers are searched up to the degree at which the derivatives need them; the result is the largest such space.
    """
    space = list(equations)
    while space:
        smaller = _step(space, field)
        if smaller is None:
            return []
        if len(smaller) == len(space):
            return [whole(p) for p in space]
        space = smaller
    return []


def _step(space: Sequence[Polynomial], field: Field) -> list[Polynomial] | None:
    """The combinations whose derivatives are in the ideal of the space; None where that is too large a question."""
    rates = [derivative(p, field) for p in space]
    names = tuple(sorted({v for p in (*space, *rates) for v in p.variables}))
    degree = max((r.total_degree() for r in rates), default=0)
    columns = list(rates)
    for p in space:
        columns += [m * p for m in monomials(names, max(0, degree - p.total_degree()))]
    if len(columns) > MOST_UNKNOWNS:
        return None
    rows: dict[Monomial, dict[int, Fraction]] = {}
    for k, column in enumerate(columns):
        for m, c in column.terms.items():
            rows.setdefault(m, {})[k] = c
    found = kernel(rows.values(), len(columns))
    heads = [{k: c for k, c in v.items() if k < len(space)} for v in found]
    return [total(space[k].scaled(c) for k, c in v.items()) for v in _independent(heads, len(space))]


def _independent(vectors: Sequence[dict[int, Fraction]], size: int) -> list[dict[int, Fraction]]:
    """A basis of what the vectors span: what is orthogonal to what is orthogonal to them."""
    across = kernel(vectors, size)
    return kernel(across, size)
