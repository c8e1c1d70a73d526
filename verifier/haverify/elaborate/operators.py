"""Numbers, truth values and cells as they are written, and what operators make of them."""

from __future__ import annotations

from haverify.elaborate import arithmetic as A
from haverify.elaborate.reading import Env, boolean, exact, reads, real, type_phrase, typed
from haverify.elaborate.scope import Typed
from haverify.elaborate.units import to_unit, unit_phrase
from haverify.maths.exact import fits
from haverify.model.expression import Expr, number
from haverify.model.unit import Unit, coherent, power
from haverify.syntax import tree as t
from haverify.text.span import Span


@reads(t.Number)
def _number(env: Env, node: t.Number, expect: str | None) -> Typed:
    if not fits(node.value):
        env.ctx.fail("HA105", "this number is too large: exact numbers have at most 4,200 digits", node.span)
    unit = env.ctx.unit(node.unit, node.span) if node.unit else env.ctx.one
    return Typed(number(node.value, unit, node.span), "real")


@reads(t.Truth)
def _truth(env: Env, node: t.Truth, expect: str | None) -> Typed:
    return Typed(A.truth(node.value, node.span), "bool")


@reads(t.Bits)
def _bits(env: Env, node: t.Bits, expect: str | None) -> Typed:
    return _cell(env, node, expect)


@reads(t.Pair)
def _tuple(env: Env, node: t.Pair, expect: str | None) -> Typed:
    return _cell(env, node, expect)


def _cell(env: Env, node: t.Bits | t.Pair, expect: str | None) -> Typed:
    """A constant cell, where a cell is expected."""
    symbol = env.scope.lookup(expect.removeprefix("cell ")) if expect and expect.startswith("cell ") else None
    if symbol is None:
        env.ctx.fail("HA105", "bits or a pair stand for a cell only where a cell is expected", node.span)
    from haverify.elaborate.cells import bits_of

    bits = bits_of(env.ctx, env.ctx.use(symbol, node.span).payload, node)
    return Typed(Expr("cell", (symbol.name, bits), None, node.span), f"cell {symbol.name}")


@reads(t.Unary)
def _unary(env: Env, node: t.Unary, expect: str | None) -> Typed:
    if node.op == "not":
        return Typed(A.negation(boolean(env, node.operand), node.span), "bool")
    return Typed(A.negate(real(env, node.operand), node.span), "real")


@reads(t.Binary)
def _binary(env: Env, node: t.Binary, expect: str | None) -> Typed:
    if node.op in ("and", "or"):
        return _connective(env, node)
    if node.op == "implies":
        return Typed(_implies(env, node), "bool")
    if node.op == "^":
        return Typed(_power(env, node), "real")
    if node.op == "+-":
        env.ctx.fail("HA105", "`c +- d` is a set, not a number; use it after `in`", node.span)
    terms = _spine(node, ("+", "-") if node.op in ("+", "-") else ("*", "/"))
    values = [(op, real(env, e)) for op, e in terms]
    if node.op in ("+", "-"):
        return Typed(_sum(env, values, [e for _, e in terms], node.span), "real")
    return Typed(exact(env, node.span, lambda: A.product(values, _unit_of_product(values), node.span)), "real")


def _spine(node: t.Binary, ops: tuple[str, ...]) -> list[tuple[str, t.Expr]]:
    """The operands of a left-nested chain with their operators; the first has the first operator of `ops`."""
    found: list[tuple[str, t.Expr]] = []
    at: t.Expr = node
    while isinstance(at, t.Binary) and at.op in ops:
        found.append((at.op, at.right))
        at = at.left
    found.append((ops[0], at))
    found.reverse()
    return found


def _sum(env: Env, values: list[tuple[str, Expr]], nodes: list[t.Expr], span: Span) -> Expr:
    unit = values[0][1].unit
    terms = [values[0]]
    for (op, e), node in zip(values[1:], nodes[1:], strict=True):
        if env.ctx.unitless:
            terms.append((op, e))
        else:
            terms.append((op, _term(env, e, unit, node)))
    return exact(env, span, lambda: _prefix_sum(terms, unit, span))


def _term(env: Env, e: Expr, unit: Unit | None, node: t.Expr) -> Expr:
    return to_unit(env.ctx, e, unit, f"the sum, whose first term is {unit_phrase(unit)},", node.span)


def _prefix_sum(terms: list[tuple[str, Expr]], unit: Unit | None, span: Span) -> Expr:
    """The sum with its leading numbers made one."""
    k, lead = 1, A.literal(terms[0][1])
    while lead is not None and k < len(terms) and (nxt := A.literal(terms[k][1])) is not None:
        lead = lead + nxt if terms[k][0] == "+" else lead - nxt
        if not fits(lead):
            raise A.TooLarge
        k += 1
    if lead is not None and k > 1:
        terms = [("+", number(lead, unit, span)), *terms[k:]]
    return terms[0][1] if len(terms) == 1 else A.total(terms, unit, span)


def _unit_of_product(values: list[tuple[str, Expr]]) -> Unit | None:
    unit = values[0][1].unit
    for op, e in values[1:]:
        if unit is None or e.unit is None:
            return None
        unit = unit * e.unit if op == "*" else unit / e.unit
    return unit


def _power(env: Env, node: t.Binary) -> Expr:
    base, exponent = real(env, node.left), real(env, node.right)
    exponent = to_unit(env.ctx, exponent, env.ctx.one, "an exponent", node.right.span, "HA104")
    n = A.literal(exponent)
    if n is not None and abs(n) > 1000 and A.literal(base) is None:
        env.ctx.fail("HA105", "this exponent is too large: at most 1000", node.right.span)
    unit = base.unit
    if unit is not None and unit.factors:
        if n is None:
            env.ctx.fail("HA104", f"the exponent of a quantity in {unit.text} must be a number", node.right.span)
        if n.denominator != 1:
            unit = coherent(unit)
            base = to_unit(env.ctx, base, unit, "", node.span)
        unit = power(unit, int(n) if n.denominator == 1 else n) if abs(n) <= 1000 else unit
    return exact(env, node.span, lambda: A.raised(base, exponent, unit, node.span))


def _connective(env: Env, node: t.Binary) -> Typed:
    parts = [boolean(env, e) for _, e in _spine(node, (node.op,))]
    join = A.every if node.op == "and" else A.some
    return Typed(join(parts, node.span), "bool")


def _implies(env: Env, node: t.Binary) -> Expr:
    premises: list[tuple[t.Expr, Span]] = []
    at: t.Expr = node
    while isinstance(at, t.Binary) and at.op == "implies":
        premises.append((at.left, at.span))
        at = at.right
    parts = [(boolean(env, p), span) for p, span in premises]
    result = boolean(env, at)
    for premise, span in reversed(parts):
        result = A.implication(premise, result, span)
    return result


@reads(t.If)
def _if(env: Env, node: t.If, expect: str | None) -> Typed:
    condition = boolean(env, node.condition)
    if condition.op in ("true", "false"):
        return typed(env, node.yes if condition.op == "true" else node.no, expect)
    yes, no = typed(env, node.yes, expect), typed(env, node.no, expect)
    if yes.type != no.type and not (env.ctx.is_number(yes.type) and env.ctx.is_number(no.type)):
        env.ctx.fail(
            "HA105", f"`then` is {type_phrase(env.ctx, yes.type)}, `else` {type_phrase(env.ctx, no.type)}", node.span
        )
    other = to_unit(env.ctx, no.expr, yes.expr.unit, "`else`, like `then`,", node.no.span)
    return Typed(A.choice(condition, yes.expr, other, node.span), yes.type if yes.type == no.type else "real")
