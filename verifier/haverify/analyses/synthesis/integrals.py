"""Polynomials with `p' = c p`: first integrals (c = 0) by linear algebra, others from numerical guesses of c."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import chain
from typing import Any

from haverify.maths.elimination import kernel
from haverify.maths.polynomial import Monomial, Polynomial, constant, total
from haverify.obligations.premises import whole
from haverify.solvers.positivity.ansatz import monomials

Field = dict[str, Polynomial]
MOST_MONOMIALS = 260
LARGEST = 110
NEWTON_STEPS = 40


def eigenpolynomials(field: Field, names: tuple[str, ...], degree: int, cofactor: Polynomial) -> list[Polynomial]:
    """A basis of the polynomials without constant factor up to a degree whose derivative is `cofactor` times them."""
    basis = monomials(names, degree)
    if len(basis) > MOST_MONOMIALS:
        return []
    rows: dict[Monomial, dict[int, Fraction]] = {}
    for k, m in enumerate(basis):
        for n, c in (derivative(m, field) - cofactor * m).terms.items():
            rows.setdefault(n, {})[k] = c
    found = kernel(rows.values(), len(basis))
    polys = [total(basis[k].scaled(c) for k, c in v.items()) for v in found]
    return [whole(p) for p in polys if p.constant is None]


def derivative(poly: Polynomial, field: Field) -> Polynomial:
    """The derivative along a flow; what the field does not name is constant."""
    return total(poly.derivative(v) * field[v] for v in poly.variables if v in field)


def first_integrals(field: Field, names: tuple[str, ...], degree: int) -> list[Polynomial]:
    """A basis of the polynomials up to a degree that are constant along the flow, but constants."""
    return eigenpolynomials(field, names, degree, constant(0))


def darboux_polynomials(
    field: Field, names: tuple[str, ...], degree: int, tries: int
) -> Iterator[tuple[Polynomial, Polynomial]]:
    """Polynomials p up to a degree with their cofactors c, neither constant nor (c = 0) a first integral.

    Newton's method on `p' = c p` from random starts guesses c, whose coefficients are rounded to simple rationals;
    what belongs to it is then exact linear algebra.
    """
    moving = tuple(v for v in names if v in field and field[v].whole)
    top = max((field[v].total_degree() for v in moving), default=0)
    basis = monomials(names, degree)
    factors = monomials(names, max(top - 1, 0))
    if not moving or len(basis) + len(factors) > LARGEST:
        return
    seen: set[Polynomial] = {constant(0)}
    guesses = (
        total(m.scaled(q) for m, q in zip(factors, g, strict=True)) for g in _guesses(field, basis, factors, tries)
    )
    for cofactor in chain(_diagonal(field, moving, degree), guesses):
        if cofactor in seen:
            continue
        seen.add(cofactor)
        for p in eigenpolynomials(field, names, degree, cofactor):
            yield p, cofactor


def _diagonal(field: Field, moving: Sequence[str], degree: int) -> Iterator[Polynomial]:
    """Cofactors of monomials up to a degree, with what each rate has of its own name divided by that name.

    Where p has such a monomial on an edge of its Newton polytope that the field keeps, this is its cofactor.
    """
    own = {v: _divided(field[v], v) for v in moving}
    for m in monomials(tuple(moving), degree)[1:]:
        ((named, _),) = m.whole.items()
        yield total(own[v].scaled(Fraction(e)) for v, e in named)


def _divided(p: Polynomial, v: str) -> Polynomial:
    """The terms of p that v divides, divided by v."""
    found = {}
    for m, c in p.whole.items():
        if any(w == v for w, _ in m):
            found[tuple((w, e - (w == v)) for w, e in m if (w, e) != (v, 1))] = c
    return Polynomial(found, p.divisor)


def _guesses(
    field: Field, basis: Sequence[Polynomial], factors: Sequence[Polynomial], tries: int
) -> Iterator[list[Fraction]]:
    """Coefficients of cofactors, rounded."""
    import numpy

    places: dict[Monomial, int] = {}
    linear = _tensor([derivative(m, field) for m in basis], places)
    products = [_tensor([f * m for m in basis], places) for f in factors]
    size, n, k = len(places), len(basis), len(factors)
    a = _dense(linear, size, n)
    b = numpy.stack([_dense(x, size, n) for x in products])
    random = numpy.random.default_rng(5)
    for _ in range(tries):
        p, c, normal = random.standard_normal(n), random.standard_normal(k) * 2, random.standard_normal(n)
        found = _newton(a, b, p, c, normal)
        if found is None and k:  # once more from the cofactor that fits the first guess best
            found = _newton(a, b, p, numpy.linalg.lstsq((b @ p).T, a @ p, rcond=None)[0], normal)
        if found is not None:
            yield [Fraction(float(c)).limit_denominator(24) for c in found]


def _tensor(polys: Sequence[Polynomial], places: dict[Monomial, int]) -> list[list[tuple[int, float]]]:
    return [[(places.setdefault(m, len(places)), float(c)) for m, c in p.terms.items()] for p in polys]


def _dense(columns: list[list[tuple[int, float]]], size: int, n: int) -> Any:
    import numpy

    found = numpy.zeros((size, n))
    for k, column in enumerate(columns):
        for place, c in column:
            found[place, k] = c
    return found


def _newton(a: Any, b: Any, p: Any, c: Any, normal: Any) -> Any:
    """Cofactor coefficients with `(a - sum c b) p = 0`, p without constant term alone, or None."""
    import numpy

    p = p / (normal @ p)
    damping = 1.0
    error = numpy.inf
    for _ in range(NEWTON_STEPS):
        matrix = a - numpy.tensordot(c, b, 1)
        residual = numpy.concatenate([matrix @ p, [normal @ p - 1]])
        now = float(residual @ residual)
        if now < 1e-20:
            break
        damping = max(damping / 3, 1e-9) if now < error else min(damping * 2, 1e6)
        error = now
        jacobian = numpy.zeros((len(residual), len(p) + len(c)))
        jacobian[:-1, : len(p)] = matrix
        jacobian[:-1, len(p) :] = -(b @ p).T
        jacobian[-1, : len(p)] = normal
        square = jacobian.T @ jacobian
        step = numpy.linalg.solve(square + damping * 1e-2 * numpy.eye(len(square)), -jacobian.T @ residual)
        p, c = p + step[: len(p)], c + step[len(p) :]
        if not numpy.all(numpy.isfinite(p)) or numpy.abs(c).max(initial=0) > 1e4:
            return None
    if error > 1e-10 or numpy.abs(p[1:]).max(initial=0) < 1e-6:
        return None
    return c
