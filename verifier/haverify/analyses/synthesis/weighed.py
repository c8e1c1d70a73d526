"""Cuts `p <= 0` with `p' = c p - sum of squares of monomials`, c a number that the flow is written with.

For such a c the polynomials for which `c p - p'` has no monomial but squares are a space, found exactly. In it a linear
program looks for one whose squares have no negative weights, and which parts the sampled starts from unsafe states.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import product
from typing import Any

from haverify.analyses.synthesis.candidates import below, closures
from haverify.analyses.synthesis.integrals import Field, derivative
from haverify.analyses.synthesis.samples import branches, compiled, inside
from haverify.analyses.synthesis.search import CHEAP, Search
from haverify.maths.elimination import echelon
from haverify.maths.polynomial import Monomial, Polynomial, total
from haverify.solvers.positivity.ansatz import monomials

LARGEST, MOST_RATES, POINTS = 6, 12, 60
DENOMINATORS = (1, 4, 64, 4096)


def weighed(search: Search) -> None:
    """Quadratic polynomials between starts and unsafe states, for each number c that is tried."""
    for group in closures(search.system.field):
        names = tuple(v for v in group if v in search.system.field)
        if len(names) <= LARGEST and "time" not in names:
            for rate in _rates(search.system.field, names):
                if search.is_over() or any(search.attempt([below(p)], CHEAP) for p in _found(search, names, rate)):
                    return


def _rates(field: Field, names: Sequence[str]) -> list[Fraction]:
    """What each name is damped with, these numbers twice and two of them together; 0."""
    own = [field[v].terms.get(((v, 1),), Fraction(0)) for v in names]
    found = dict.fromkeys([*own, *(2 * q for q in own), *(a + b for a, b in product(own, own)), Fraction(0)])
    return list(found)[:MOST_RATES]


def _found(search: Search, names: Sequence[str], rate: Fraction) -> Iterator[Polynomial]:
    space = _space(search.system.field, names, rate)
    for part in search.open if len(space) > 1 else ():
        for unsafe in branches([*search.premises().entries, part], 4):
            points = inside(unsafe, search.samples.names, POINTS)
            weights = _weights(search, space, rate, points)
            for d in DENOMINATORS if weights is not None else ():
                yield total(p.scaled(Fraction(round(w * d), d)) for p, w in zip(space, weights, strict=True))


def _space(field: Field, names: Sequence[str], rate: Fraction) -> list[Polynomial]:
    """A basis of the quadratic p for which `rate p - p'` has no monomials but squares."""
    basis = monomials(tuple(names), 2)
    rows: dict[Monomial, dict[int, Fraction]] = {}
    for k, m in enumerate(basis):
        for n, c in (m.scaled(rate) - derivative(m, field)).terms.items():
            if any(e % 2 for _, e in n):
                rows.setdefault(n, {})[k] = c
    solved = echelon((row, Fraction(0)) for row in rows.values())
    if solved is None:
        return []
    free = [k for k in range(len(basis)) if k not in solved.rows]
    points = (solved.solution({j: Fraction(1)}) for j in free)
    return [total(basis[k].scaled(q) for k, q in point.items()) for point in points]


def _weights(search: Search, space: Sequence[Polynomial], rate: Fraction, unsafe: Any) -> Any:
    """Weights, up to 1, with which a sum of the space is below 0 at the starts and above at unsafe points."""
    import numpy
    from scipy.optimize import linprog

    if not len(unsafe) or not len(search.samples.starts):
        return None
    names = search.samples.names
    sides = [numpy.stack([compiled(p, names).value(x) for p in space], 1) for x in (search.samples.starts, unsafe)]
    field = search.system.field
    decays = [(p.scaled(rate) - derivative(p, field)).terms for p in space]
    signs = [[-float(d.get(m, 0)) for d in decays] for m in sorted({m for d in decays for m in d})]
    sizes = [numpy.abs(side).max(axis=1, keepdims=True) + 1e-9 for side in sides]
    rows = [sides[0] / sizes[0], -sides[1] / sizes[1], numpy.array(signs).reshape(-1, len(space))]
    table = numpy.vstack([numpy.hstack([r, numpy.full((len(r), 1), float(k < 2))]) for k, r in enumerate(rows)])
    goal = numpy.zeros(len(space) + 1)
    goal[-1] = -1
    done = linprog(goal, table, numpy.zeros(len(table)), bounds=[(-1, 1)] * len(space) + [(0, 1)])
    return done.x[:-1] if done.status == 0 and done.x[-1] > 1e-6 else None
