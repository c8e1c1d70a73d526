"""Polynomials in one variable with integer coefficients, lowest power first: what sign questions come down to."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import gcd, lcm

Integers = tuple[int, ...]


def integers(coefficients: Sequence[Fraction]) -> tuple[Integers, Fraction]:
    """`(c, q)` with `p = q * c`, `q > 0`, coprime integers `c` and no leading zero; `((), 1)` for the zero
    polynomial."""
    common = lcm(*(c.denominator for c in coefficients)) if coefficients else 1
    whole = [c.numerator * (common // c.denominator) for c in coefficients]
    while whole and not whole[-1]:
        whole.pop()
    if not whole:
        return (), Fraction(1)
    factor = gcd(*whole)
    return tuple(c // factor for c in whole), Fraction(factor, common)


def primitive(p: Sequence[int]) -> Integers:
    """The polynomial without leading zeros, divided by the greatest common divisor of its coefficients."""
    whole = list(p)
    while whole and not whole[-1]:
        whole.pop()
    factor = gcd(*whole) if whole else 1
    return tuple(c // factor for c in whole)


def scaled_value(p: Integers, x: Fraction) -> int:
    """`p(x) * d^n` for `x` with denominator `d` and `p` of degree n: an integer with the sign of `p(x)`."""
    if not p:
        return 0
    a, d = x.numerator, x.denominator
    total, power = p[-1], 1
    for c in reversed(p[:-1]):
        power *= d
        total = total * a + c * power
    return total


def sign_at(p: Integers, x: Fraction) -> int:
    """-1, 0 or 1."""
    v = scaled_value(p, x)
    return (v > 0) - (v < 0)


def value(p: Integers, x: Fraction) -> Fraction:
    """`p(x)`."""
    return Fraction(scaled_value(p, x), x.denominator ** (len(p) - 1)) if p else Fraction(0)


def derivative(p: Integers) -> Integers:
    """The derivative, coefficients as they come."""
    return tuple(i * c for i, c in enumerate(p))[1:]


def product(p: Integers, q: Integers) -> Integers:
    """The product."""
    if not p or not q:
        return ()
    result = [0] * (len(p) + len(q) - 1)
    for i, a in enumerate(p):
        if a:
            for j, b in enumerate(q):
                result[i + j] += a * b
    return tuple(result)


def greatest_common_divisor(p: Integers, q: Integers) -> Integers:
    """The primitive greatest common divisor, by pseudo-remainders."""
    p, q = primitive(p), primitive(q)
    while q:
        p, q = q, primitive(_pseudo_remainder(p, q))
    return p


def quotient(p: Integers, q: Integers) -> Integers:
    """The primitive quotient of `p` by a divisor `q`."""
    rest = [Fraction(c) for c in p]
    result = [Fraction(0)] * (len(p) - len(q) + 1)
    for k in reversed(range(len(result))):
        factor = rest[k + len(q) - 1] / q[-1]
        result[k] = factor
        for j, c in enumerate(q):
            rest[k + j] -= factor * c
    return integers(result)[0]


def square_free(p: Integers) -> Integers:
    """The polynomial with the same roots, each simple."""
    divisor = greatest_common_divisor(p, derivative(p))
    return primitive(p) if len(divisor) <= 1 else quotient(p, divisor)


def _pseudo_remainder(p: Integers, q: Integers) -> list[int]:
    """A multiple, by a power of the leading coefficient of `q`, of the remainder of `p` by `q`."""
    rest, lead = list(p), q[-1]
    while len(rest) >= len(q):
        head, shift = rest[-1], len(rest) - len(q)
        rest = [c * lead for c in rest]
        for j, c in enumerate(q):
            rest[shift + j] -= head * c
        rest.pop()
        while rest and not rest[-1]:
            rest.pop()
    return rest
