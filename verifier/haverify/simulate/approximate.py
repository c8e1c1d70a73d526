"""Numbers of constant expressions, pi as the float nearest to it: good enough to run a model, never to judge it."""

from __future__ import annotations

import math
from fractions import Fraction

from haverify.model.expression import Expr, number, rebuild
from haverify.model.hybrid import Range
from haverify.obligations.constants import Values
from haverify.obligations.translate import OutsideFragmentError

PI = Fraction(math.pi)


def approximate(values: Values, e: Expr) -> Fraction:
    """The number that an expression in constants stands for.

    Raises
    ------
    OutsideFragmentError    if it reads anything else
    """
    return values.number(_rational(values, e))


def ends_of(values: Values, r: Range, what: str) -> tuple[float, float]:
    """Both ends of a range of constants."""
    low, high = approximate(values, r.low), approximate(values, r.high)
    if low > high:
        raise OutsideFragmentError(f"{what} has no value between {low} and {high}")
    return float(low), float(high)


def _rational(values: Values, e: Expr) -> Expr:
    if e.op == "pi":
        return number(PI)
    if e.op == "scale":
        q, k, inner = e.args
        factor = Fraction(str(q)) * PI ** int(Fraction(str(k)))
        return Expr("*", (number(factor), _rational(values, inner))) if isinstance(inner, Expr) else e
    if e.op == "const" and e.name in values.constants:
        value = values.constants[e.name].value
        return e if isinstance(value, Range) else _rational(values, value)
    return rebuild(e, lambda c: _rational(values, c))
