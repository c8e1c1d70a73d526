"""Identities of Positivstellensatz: why some literals have no common point."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import reduce
from operator import mul
from typing import Any

from haverify.maths.polynomial import ONE, Polynomial, constant, total
from haverify.obligations.formula import Literal
from haverify.obligations.premises import polynomial_json
from haverify.text.record import record

Squares = tuple[tuple[Fraction, Polynomial], ...]
"""A sum of numbers (at least 0) times squares of polynomials."""


@record
class Identity:
    """`sum squares * product of g + sum multiplier * p + weight * product of s = 0`, in the words of the premises.

    g is `-p` of a premise `p <= 0` or `p < 0`, p that of an equation, s `-p` of a premise `p < 0` and `p^2` of one
    with `!=`; premises are named by their places.
    """

    cones: tuple[tuple[Squares, tuple[int, ...]], ...]
    ideal: tuple[tuple[int, Polynomial], ...]
    weight: Fraction
    strict: tuple[int, ...]

    def total(self, premises: Sequence[object]) -> Polynomial:
        """The left side, which is to be 0."""
        parts = [total(q.scaled(ONE) * q.scaled(c) for c, q in s) * nonnegative(premises, g) for s, g in self.cones]
        parts += [m * _poly(premises, i) for i, m in self.ideal]
        return total([*parts, positive(premises, self.strict).scaled(self.weight)])

    def proof(self) -> list[Any]:
        """As JSON, in the form of a certificate."""
        cones = [[_sos(s), list(g)] for s, g in self.cones]
        ideal = [[i, polynomial_json(m)] for i, m in self.ideal]
        return ["psatz", cones, ideal, [str(self.weight), list(self.strict)]]


def _sos(s: Squares) -> Any:
    if len(s) == 1 and s[0][1].constant == 1:
        return str(s[0][0])
    return [[str(c), polynomial_json(q)] for c, q in s]


def nonnegative(premises: Sequence[object], places: Sequence[int]) -> Polynomial:
    """The product of what the premises at these places say is at least 0."""
    return reduce(mul, (-_poly(premises, i) for i in places), constant(1))


def positive(premises: Sequence[object], places: Sequence[int]) -> Polynomial:
    """The product of what the premises at these places say is above 0."""
    return reduce(mul, (_above(premises[i]) for i in places), constant(1))


def _above(entry: object) -> Polynomial:
    assert isinstance(entry, Literal)
    return entry.polynomial * entry.polynomial if entry.op == "!=" else -entry.polynomial


def _poly(premises: Sequence[object], place: int) -> Polynomial:
    entry = premises[place]
    assert isinstance(entry, Literal)
    return entry.polynomial
