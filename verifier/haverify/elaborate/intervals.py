"""Sets of numbers: `[a, b]`, `c +- d`, and names of these."""

from __future__ import annotations

from haverify.elaborate import arithmetic as A
from haverify.elaborate.names import denote
from haverify.elaborate.reading import Env, exact, reads, real
from haverify.elaborate.scope import SetValue, Typed
from haverify.elaborate.units import alike, to_unit
from haverify.model.expression import Expr
from haverify.model.hybrid import Range
from haverify.model.unit import Unit
from haverify.syntax import tree as t
from haverify.text.span import Span


def interval(env: Env, node: t.Expr) -> SetValue:
    """The set that an expression after `in`, `over`, `rate` denotes."""
    while type(node) is t.Paren:
        node = node.inner
    if isinstance(node, t.Interval):
        return _ends(env, real(env, node.low), real(env, node.high), node.span)
    if isinstance(node, t.Binary) and node.op == "+-":
        centre, half = real(env, node.left), real(env, node.right)
        half = to_unit(env.ctx, half, centre.unit, "the half-width", node.right.span)
        low = exact(env, node.span, lambda: A.total([("+", centre), ("-", half)], centre.unit, node.span))
        high = exact(env, node.span, lambda: A.total([("+", centre), ("+", half)], centre.unit, node.span))
        return SetValue(Range(low, high), centre.unit)
    found = denote(env, node) if isinstance(node, t.Name | t.Member | t.Index) else None
    if isinstance(found, SetValue):
        return found
    return env.ctx.fail("HA105", "a set is needed here: `[a, b]` or `c +- d`", node.span)


def _ends(env: Env, low: Expr, high: Expr, span: Span) -> SetValue:
    low, high = alike(env.ctx, low, high, span)
    return SetValue(Range(low, high), low.unit)


def range_in(env: Env, node: t.Expr, unit: Unit | None, what: str) -> Range:
    """The interval of an expression, its ends in `unit`."""
    found = interval(env, node).range
    low = to_unit(env.ctx, found.low, unit, what, node.span)
    high = to_unit(env.ctx, found.high, unit, what, node.span)
    return Range(low, high)


@reads(t.Interval)
def _set(env: Env, node: t.Interval, expect: str | None) -> Typed:
    env.ctx.fail("HA105", "an interval is a set, not a number; use it after `in`", node.span)
