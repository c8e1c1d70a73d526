"""Values picked by an index that a run decides: one case per value of the enumeration."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from haverify.elaborate import arithmetic as A
from haverify.elaborate.context import Context
from haverify.elaborate.limits import check_cases
from haverify.elaborate.scope import Cases, Typed
from haverify.elaborate.units import to_unit
from haverify.model.spec import EnumType
from haverify.text.span import Span


def by_cases(ctx: Context, index: Typed, enum: EnumType, pick: Callable[[str], Any], span: Span) -> Typed | Cases:
    """`if index == v1 then pick(v1) else if ... else pick(vn)`, or the cases where the picks are no values yet."""
    check_cases(ctx, len(enum.values), span)
    ctx.used_enums.add(enum.name)
    return joined(ctx, Cases(index, enum, {v: pick(v) for v in enum.values}), span)


def mapped(ctx: Context, cases: Cases, change: Callable[[Any], Any], span: Span) -> Typed | Cases:
    """The cases with each option changed."""
    return joined(ctx, Cases(cases.selector, cases.enum, {v: change(f) for v, f in cases.options.items()}), span)


def joined(ctx: Context, cases: Cases, span: Span) -> Typed | Cases:
    """The one expression that the cases are, once each is a value; the last one needs no test."""
    values = [(v, f) for v, f in cases.options.items() if isinstance(f, Typed)]
    if len(values) < len(cases.options):
        return cases
    unit = values[0][1].expr.unit
    result = to_unit(ctx, values[-1][1].expr, unit, "the family", span)
    for v, value in reversed(values[:-1]):
        test = A.compare("==", cases.selector.expr, ctx.value(cases.enum, v, span).expr, span)
        result = A.choice(test, to_unit(ctx, value.expr, unit, "the family", span), result, span)
    return Typed(result, values[0][1].type)
