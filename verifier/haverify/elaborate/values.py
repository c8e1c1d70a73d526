"""Exact values of expressions of constants, where they are rational."""

from __future__ import annotations

from fractions import Fraction

from haverify.elaborate import arithmetic as A
from haverify.elaborate.context import Context
from haverify.model.expression import Expr, number


def exact_value(ctx: Context, e: Expr) -> Fraction | None:
    """The rational that an expression of constants is, or None."""
    try:
        return A.literal(_folded(ctx, e, 0))
    except (A.TooLarge, A.DividedByZero):
        return None


def _folded(ctx: Context, e: Expr, depth: int) -> Expr:
    if e.op == "const" and depth < 50:
        value = ctx.constant_values.get(e.name)
        return _folded(ctx, value, depth + 1) if value is not None else e
    args = [_folded(ctx, a, depth) if isinstance(a, Expr) else a for a in e.args]
    parts = [a for a in args if isinstance(a, Expr)]
    if not parts or len(parts) < len(args) or any(A.literal(p) is None for p in parts):
        return e
    return _arithmetic(e, [A.literal(p) or Fraction(0) for p in parts])


def _arithmetic(e: Expr, values: list[Fraction]) -> Expr:
    if e.op == "neg":
        return number(-values[0])
    if e.op in ("+", "-"):
        return number(values[0] - values[1] if e.op == "-" else sum(values, Fraction(0)))
    if e.op == "*":
        return A.product([("*", number(v)) for v in values], None, None)
    if e.op == "/":
        return A.product([("*", number(values[0])), ("/", number(values[1]))], None, None)
    if e.op == "^":
        return A.raised(number(values[0]), number(values[1]), None, None)
    return e
