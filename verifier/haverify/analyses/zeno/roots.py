"""Identities for squares: of `x^2 <= y^2` and `y >= 0` follows `x <= y`, and of `-y <= x <= y` follows `x^2 <= y^2`."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from haverify.maths.digits import rational_text
from haverify.maths.polynomial import Polynomial
from haverify.obligations.formula import Formula, Literal, compare, negation
from haverify.obligations.premises import Premises, polynomial_json, primitive, whole
from haverify.text.record import record

Q = Fraction
Json = Any
Term = tuple[Fraction | Polynomial, Sequence[Formula]]  # a number at least 0, or what is to be squared; literals


@record
class Lemma:
    """A literal; the sizes `x`, `y` that it compares, where it follows from squares; or what it is a sum of."""

    formula: Formula
    x: Polynomial | None = None
    y: Polynomial | None = None
    terms: tuple[Term, ...] = ()


def below(x: Polynomial, y: Polynomial) -> Lemma:
    """`x <= y`, from the squares."""
    return Lemma(compare("<=", x - y), x, y)


def squares(x: Polynomial, y: Polynomial) -> Lemma:
    """`x^2 <= y^2`, from both comparisons."""
    return Lemma(compare("<=", x * x - y * y), x, y)


def by_identity(premises: Premises, lemma: Lemma) -> Json | None:
    """Why the premises, the lemma's negation the last of them, have no common point; None where one is missing."""
    x, y = lemma.x, lemma.y
    if lemma.terms:
        return identity(premises, lemma.terms, [negation(lemma.formula)])
    if x is None or y is None:
        return None
    wrong = compare(">", x - y)
    if lemma.formula == compare("<=", x - y):
        square, size = compare("<=", x * x - y * y), compare(">=", y)
        return identity(premises, [(Q(1), [square]), (Q(2), [size, wrong])], [wrong, wrong])
    return identity(premises, [(Q(1), [compare("<=", x - y), compare("<=", -x - y)])], [negation(lemma.formula)])


def identity(premises: Premises, terms: Sequence[Term], strict: Sequence[Formula]) -> Json | None:
    """The proof that `sum c * product of sizes + product of strict ones` is 0, a size being the negated left side."""
    told = [(c, [_place(premises, f) for f in fs]) for c, fs in terms if c != 0]
    last = [_place(premises, f) for f in strict]
    if any(p is None for _, ps in told for p in ps) or any(p is None for p in last):
        return None
    sums = [[_weight(c, ps), [p[0] for p in ps if p]] for c, ps in told]
    return ["psatz", sums, [], [rational_text(_scaled(Q(1), last)), [p[0] for p in last if p]]]


def _weight(c: Fraction | Polynomial, placed: Sequence[tuple[int, Fraction] | None]) -> Json:
    """A number, or a square with one."""
    if isinstance(c, Polynomial):
        return [[rational_text(_scaled(Q(1), placed)), polynomial_json(c)]]
    return rational_text(_scaled(c, placed))


def _scaled(c: Fraction, placed: Sequence[tuple[int, Fraction] | None]) -> Fraction:
    for p in placed:
        c = c * p[1] if p else c
    return c


def _place(premises: Premises, f: Formula) -> tuple[int, Fraction] | None:
    """The place of a literal among premises, and what its primitive polynomial is multiplied by."""
    told = primitive(f)
    if not isinstance(f, Literal) or not isinstance(told, Literal) or told not in premises.entries:
        return None
    m = next(iter(f.polynomial.whole))
    return premises.entries.index(told), f.polynomial.terms[m] / whole(f.polynomial).terms[m]
