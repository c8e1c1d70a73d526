"""Unit checks and conversions of expressions; conversions become `scale` nodes or are folded into numbers."""

from __future__ import annotations

from haverify.diagnostics.diagnostic import Edit, Fix
from haverify.elaborate.arithmetic import literal, scale
from haverify.elaborate.context import Context
from haverify.model.expression import Expr, number
from haverify.model.unit import ONE, RADIAN, Unit, conversion, differs_by_angle, is_compatible
from haverify.text.span import Span


def unit_phrase(unit: Unit | None) -> str:
    """A unit in a sentence."""
    if unit is None or unit.text == "1":
        return "a plain number"
    return f"in {unit.text}"


def to_unit(ctx: Context, e: Expr, target: Unit | None, what: str, span: Span | None, code: str = "HA101") -> Expr:
    """`e` measured in `target`; HA101 names `what` needed it where that is impossible."""
    if ctx.unitless or e.unit is None or target is None or e.unit is target:
        return e
    factor = conversion(e.unit, target)
    if factor is None and is_bare_zero(e):
        return number(0, target, e.span)
    if factor is None:
        place = span or e.span
        ctx.fail(
            code, f"{what} needs {_needed(target)}, this is {unit_phrase(e.unit)}", place, help=_advice(e.unit, target)
        )
    return scale(factor[0], factor[1], e, target)


def is_bare_zero(e: Expr) -> bool:
    """Whether an expression is `0` without a unit, which is zero in every unit."""
    return e.op == "num" and e.args[0] == 0 and e.unit is ONE


def _needed(unit: Unit) -> str:
    return "a plain number" if unit.text == "1" else f"a quantity in {unit.text}"


def _advice(a: Unit, b: Unit) -> str | None:
    if not differs_by_angle(a, b):
        return None
    return "degrees become a plain number only by dividing by an angle: `/ 1 deg` or `/ 1 rad`"


def alike(ctx: Context, a: Expr, b: Expr, span: Span) -> tuple[Expr, Expr]:
    """Two sides of a comparison in one unit: a number takes the unit of the other side, else the right one converts."""
    if ctx.unitless or a.unit is None or b.unit is None or a.unit is b.unit:
        return a, b
    if is_bare_zero(a):
        return number(0, b.unit, a.span), b
    if not is_compatible(a.unit, b.unit) and not is_bare_zero(b):
        ctx.fail("HA101", f"left side is {unit_phrase(a.unit)}, right side is {unit_phrase(b.unit)}", span,
                 help=_advice(a.unit, b.unit))  # fmt: skip
    if literal(a) is not None and literal(b) is None:
        return to_unit(ctx, a, b.unit, "", span), b
    return a, to_unit(ctx, b, a.unit, "", span)


def angle(ctx: Context, e: Expr, function: str, span: Span) -> Expr:
    """The argument of a trigonometric function in rad."""
    if e.unit is None:
        return e
    if literal(e) is not None and e.unit.text == "1" and literal(e) != 0:
        fix = Fix("write degrees", (Edit(Span(span.path, span.end, span.end), " deg"),))
        ctx.fail("HA102", f"{function}() takes an angle; write the number with deg or rad", span, fix=fix)
    if differs_by_angle(e.unit, RADIAN) and e.unit.without_angle == ONE.without_angle:
        ctx.fail("HA102", f"{function}() takes an angle, this is in {e.unit.text}", span)
    return to_unit(ctx, e, RADIAN, f"{function}()", span)


def plain(ctx: Context, e: Expr, what: str, span: Span) -> Expr:
    """The argument of a function of plain numbers; HA104 for a quantity."""
    return to_unit(ctx, e, None if ctx.unitless else ONE, what, span, "HA104")
