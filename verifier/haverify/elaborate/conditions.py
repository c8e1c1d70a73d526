"""What is true or false: comparisons, memberships, quantifiers, temporal operators."""

from __future__ import annotations

from haverify.elaborate import arithmetic as A
from haverify.elaborate.context import NeedsMode
from haverify.elaborate.intervals import interval
from haverify.elaborate.limits import spend
from haverify.elaborate.names import denote, family_enum
from haverify.elaborate.reading import Env, boolean, reads, real, type_phrase, typed
from haverify.elaborate.scope import Symbol, Typed
from haverify.elaborate.units import alike, to_unit
from haverify.elaborate.values import exact_value
from haverify.model.expression import Expr
from haverify.model.unit import SECOND
from haverify.syntax import tree as t
from haverify.text.span import Span


@reads(t.Comparison)
def _comparison(env: Env, node: t.Comparison, expect: str | None) -> Typed:
    try:
        return Typed(_chain(env, node), "bool")
    except NeedsMode as need:
        if env.split is None:
            raise
        return Typed(env.split(env, node, need.symbol), "bool")


def _chain(env: Env, node: t.Comparison) -> Expr:
    if len(node.ops) == 1:
        return _pair(env, node.ops[0], node.operands[0], node.operands[1], node.span)
    parts = []
    for k, op in enumerate(node.ops):
        a, b = node.operands[k], node.operands[k + 1]
        parts.append(_pair(env, op, a, b, a.span.to(b.span)))
    return A.every(parts, node.span)


def _pair(env: Env, op: str, left: t.Expr, right: t.Expr, span: Span) -> Expr:
    if op == "in":
        return _membership(env, left, right, span)
    a, b = _sides(env, left, right)
    ctx = env.ctx
    if ctx.is_number(a.type) and ctx.is_number(b.type):
        x, y = alike(ctx, a.expr, b.expr, span)
        return A.compare("==" if op == "is" else op, x, y, span)
    if a.type != b.type:
        ctx.fail("HA105", f"left side is {type_phrase(ctx, a.type)}, right side is {type_phrase(ctx, b.type)}", span)
    if op not in ("is", "==", "!="):
        ctx.fail("HA105", f"{type_phrase(ctx, a.type)} has no order; compare with 'is'", span)
    return A.compare("!=" if op == "!=" else "==", a.expr, b.expr, span)


def _sides(env: Env, left: t.Expr, right: t.Expr) -> tuple[Typed, Typed]:
    """Both sides; a bare enumeration value takes its type from the other side."""
    if isinstance(left, t.Name) and env.scope.lookup(left.id) is None:
        b = typed(env, right)
        return typed(env, left, b.type if b.type != "real" else None), b
    a = typed(env, left)
    return a, typed(env, right, a.type if a.type != "real" else None)


def _membership(env: Env, left: t.Expr, right: t.Expr, span: Span) -> Expr:
    x = real(env, left)
    found = interval(env, right)
    low_x, low = alike(env.ctx, x, found.range.low, span)
    high_x, high = alike(env.ctx, x, found.range.high, span)
    return A.every([A.compare("<=", low, low_x, span), A.compare("<=", high_x, high, span)], span)


@reads(t.Quantifier)
def _quantifier(env: Env, node: t.Quantifier, expect: str | None) -> Typed:
    found = denote(env, node.of)
    if isinstance(found, Symbol) and found.kind == "cell":
        bound = Typed(Expr("bound", (node.name,), None, node.span), f"cell {found.name}")
        body = boolean(env.bind(**{node.name: bound}), node.body)
        return Typed(Expr(node.kind, (node.name, found.name, body), None, node.span), "bool")
    enum = family_enum(env, node.of)
    count = len(enum.values)
    spend(env.ctx, count * count if node.kind == "unique" else count, node.span)
    parts = [boolean(env.bind(**{node.name: env.ctx.value(enum, v)}), node.body) for v in enum.values]
    return Typed(_quantified(node.kind, parts, node.span), "bool")


def _quantified(kind: str, parts: list[Expr], span: Span) -> Expr:
    if kind == "forall":
        return A.every(parts, span)
    if kind == "exists":
        return A.some(parts, span)
    only = [A.every([p, *(A.negation(q, span) for q in parts if q is not p)], span) for p in parts]
    return A.some(only, span)


def seconds(env: Env, node: t.Expr, what: str) -> Expr:
    """A duration in s."""
    return to_unit(env.ctx, real(env, node), None if env.ctx.unitless else SECOND, what, node.span)


def later(env: Env, node: t.Expr, what: str) -> Expr:
    """A duration in s that is not negative, as far as it is a number: nothing happens before 0 s."""
    e = seconds(env, node, what)
    bare = e.args[2] if e.op == "scale" else e
    value = exact_value(env.ctx, bare) if isinstance(bare, Expr) else None
    if value is not None and value < 0:
        env.ctx.fail("HA105", f"{what} is not negative: runs begin at 0 s", node.span)
    return e


@reads(t.Temporal)
def _temporal(env: Env, node: t.Temporal, expect: str | None) -> Typed:
    _needs_stl(env, node.kind, node.span)
    low, high = later(env, node.low, "a time"), later(env, node.high, "a time")
    return Typed(Expr(node.kind, (low, high, boolean(env, node.body)), None, node.span), "bool")


@reads(t.Until)
def _until(env: Env, node: t.Until, expect: str | None) -> Typed:
    _needs_stl(env, "until", node.span)
    low, high = later(env, node.low, "a time"), later(env, node.high, "a time")
    left, right = boolean(env, node.left), boolean(env, node.right)
    return Typed(Expr("until", (low, high, left, right), None, node.span), "bool")


def _needs_stl(env: Env, word: str, span: Span) -> None:
    if not env.is_stl:
        env.ctx.fail("HA105", f"'{word}[a, b]' belongs in an stl goal: `stl {word}[a, b] ...`", span)
