"""Identities with unknown multipliers: `target + free + cones + strict = 0`, linear in what is unknown."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from haverify.maths.polynomial import Monomial, Polynomial, total
from haverify.text.record import record

Key = tuple[Any, ...]
"""What an unknown multiplies: the places of premises; for free ones a place and a monomial."""


@record
class Free:
    """An unknown number times a polynomial; `key` says what it is a coefficient of."""

    key: Key
    poly: Polynomial


@record
class Cone:
    """A sum of squares of combinations of `basis`, times `factor`."""

    key: Key
    factor: Polynomial
    basis: tuple[Polynomial, ...]


@record
class Ansatz:
    """What is sought: numbers for `free`, sums of squares for `cones`, numbers >= 0 with sum 1 for `strict`, if any."""

    target: Polynomial
    free: tuple[Free, ...]
    cones: tuple[Cone, ...]
    strict: tuple[Free, ...] = ()


@record
class Found:
    """A solution: exact, and checked against the ansatz."""

    free: dict[Key, Fraction]
    cones: dict[Key, list[tuple[Fraction, Polynomial]]]
    strict: dict[Key, Fraction]


def monomials(names: tuple[str, ...], degree: int) -> list[Polynomial]:
    """All monomials in the names up to a total degree, by degree."""
    layer = [(0,) * len(names)]
    exponents = list(layer)
    for _ in range(degree):
        layer = sorted({(*e[:i], e[i] + 1, *e[i + 1 :]) for e in layer for i in range(len(names))}, reverse=True)
        exponents += layer
    return [_monomial(names, e) for e in exponents]


def _monomial(names: tuple[str, ...], exponents: tuple[int, ...]) -> Polynomial:
    named: Monomial = tuple((v, e) for v, e in sorted(zip(names, exponents, strict=True)) if e)
    return Polynomial({named: 1})


def error(ansatz: Ansatz, found: Found) -> Polynomial:
    """What is left of the identity; 0 for a solution."""
    parts = [ansatz.target]
    parts += [f.poly.scaled(found.free[f.key]) for f in ansatz.free if f.key in found.free]
    parts += [f.poly.scaled(found.strict[f.key]) for f in ansatz.strict if f.key in found.strict]
    for c in ansatz.cones:
        parts.append(c.factor * total(q * q.scaled(a) for a, q in found.cones.get(c.key, ())))
    return total(parts)
