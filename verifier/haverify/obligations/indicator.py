"""Choices among values by variables that are 0 or 1, as polynomials in these: `if on then a else b` is
`on a + (1 - on) b`."""

from __future__ import annotations

from collections.abc import Sequence, Set
from fractions import Fraction

from haverify.maths.polynomial import ONE, Polynomial, constant, total, variable
from haverify.obligations.formula import HOLDS, Formula, Literal
from haverify.obligations.translate import Case

UNIT = constant(1)


def indicator(f: Formula, bits: Set[str]) -> Polynomial | None:
    """1 where the formula holds and 0 elsewhere, if each of its literals reads one of the `bits` alone; else None."""
    if isinstance(f, bool):
        return constant(int(f))
    if isinstance(f, Literal):
        return _of_literal(f, bits)
    product = UNIT
    for m in f.members:
        part = indicator(m, bits)
        if part is None:
            return None
        product = reduced(product * (part if f.is_and else UNIT - part), bits)
    return product if f.is_and else UNIT - product


def _of_literal(f: Literal, bits: Set[str]) -> Polynomial | None:
    names = f.polynomial.variables
    if len(names) != 1 or names[0] not in bits:
        return None
    off, on = (int(HOLDS[f.op](f.polynomial.value({names[0]: Fraction(k)}))) for k in (0, 1))
    return constant(off) + variable(names[0]).scaled(Fraction(on - off))


def chosen(cases: Sequence[Case], bits: Set[str]) -> Polynomial | None:
    """The value that cases give, if `bits` alone choose among polynomials, always exactly one; else None."""
    weights = [indicator(c.condition, bits) for c in cases]
    known = [w for w in weights if w is not None]
    if len(known) < len(cases) or total(known) != UNIT:
        return None
    divisors = [c.denominator.constant for c in cases]
    if any(not d for d in divisors):
        return None
    return total(w * c.numerator.scaled(ONE / d) for w, c, d in zip(known, cases, divisors, strict=True) if d)


def reduced(p: Polynomial, bits: Set[str]) -> Polynomial:
    """The polynomial with powers of bits replaced by the bits themselves: the same values, and one form for them."""
    if all(e == 1 for m in p.whole for v, e in m if v in bits):
        return p
    parts = (Polynomial({tuple((v, 1 if v in bits else e) for v, e in m): c}, p.divisor) for m, c in p.whole.items())
    return total(parts)
