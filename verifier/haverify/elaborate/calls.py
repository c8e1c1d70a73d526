"""Calls: built-in functions, functions of the file (written out), polynomial tables, interpolated tables, networks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction

from haverify.elaborate import arithmetic as A
from haverify.elaborate.expressions import (
    Env,
    Found,
    boolean,
    cells_of,
    denote,
    exact,
    family_enum,
    of_type,
    real,
    source_name,
    typed,
)
from haverify.elaborate.limits import check_size, spend
from haverify.elaborate.scope import Cases, Row, Scope, Symbol, Typed
from haverify.elaborate.selection import mapped
from haverify.elaborate.units import angle, plain, to_unit
from haverify.model.expression import Expr, number
from haverify.model.unit import RADIAN, SECOND, Unit, coherent, power
from haverify.syntax import tree as t
from haverify.text.record import replace
from haverify.text.span import Span

_APPLIED = ("column", "net", "fuzzyout", "relation", "cellword", "fuzzyword")
_ANGLE = ("sin", "cos", "tan")
_INVERSE = ("asin", "acos", "atan")
_PLAIN = ("sinh", "cosh", "tanh", "exp", "log")
_BUILTIN = (
    *_ANGLE, *_INVERSE, *_PLAIN, "atan2", "abs", "sqrt", "min", "max", "clamp", "sum", "all", "any", "at", "jump",
    "pre", "der", "defined", "unique_rule", "related", "covered", "max_firing", "strength", "next",
)  # fmt: skip


def call(env: Env, node: t.Call, expect: str | None) -> Found:
    """The value of a call."""
    if isinstance(node.function, t.Name):
        symbol = env.scope.lookup(node.function.id)
        if symbol is None:
            return _builtin(env, node, node.function.id)
    return _call_of(env, denote(env, node.function), node)


def _call_of(env: Env, callee: Found, node: t.Call) -> Found:
    if isinstance(callee, Cases):
        return mapped(env.ctx, callee, lambda f: _call_of(env, f, node), node.span)
    if isinstance(callee, Row):
        return _polynomial(env, callee, node)
    if isinstance(callee, Symbol) and callee.kind == "fn":
        return _inline(env, callee, node)
    if isinstance(callee, Symbol) and callee.kind in _APPLIED:
        from haverify.elaborate.applications import apply

        return apply(env, callee, node)
    return env.ctx.fail("HA105", f"'{source_name(node.function)}' is not a function", node.span)


def arguments(env: Env, node: t.Call, count: int | None, name: str) -> list[t.Expr]:
    """The positional arguments; their number is checked where `count` is given."""
    found = [a.value for a in node.arguments if a.name is None and a.family is None]
    if len(found) != len(node.arguments) or (count is not None and len(found) != count):
        few = f"{count} argument" + ("" if count == 1 else "s")
        env.ctx.fail("HA105", f"{name}() takes {few if count is not None else 'plain arguments'}", node.span)
    return found


# ---- functions of the file ------------------------------------------------------


def _inline(env: Env, symbol: Symbol, node: t.Call) -> Typed:
    """The body of a function with its formals replaced; a function in its own body is HA008."""
    function, scope, busy = symbol.payload
    if busy:
        symbol.state = "lost"
        env.ctx.fail("HA008", f"function '{symbol.name}' calls itself", node.span)
    given = _matched(env, function, node)
    values = {}
    for formal, value in zip(function.formals, given, strict=True):
        values[formal.name] = _actual(env, formal, value, scope)
    symbol.payload = (function, scope, True)
    try:
        inner = replace(env, scope=scope.bind(values))
        result = _result(inner, function)
        check_size(env.ctx, result.expr, node.span)
        return result
    finally:
        symbol.payload = (function, scope, False)


def _matched(env: Env, function: t.Function, node: t.Call) -> list[t.Expr]:
    names = [f.name for f in function.formals]
    positional = [a.value for a in node.arguments if a.name is None]
    by_name = {a.name: a.value for a in node.arguments if a.name is not None}
    wanted = names[len(positional) :]
    if len(positional) > len(names) or set(by_name) != set(wanted) or any(a.family for a in node.arguments):
        env.ctx.fail("HA105", f"{function.name}({', '.join(names)}) takes {len(names)} arguments", node.span)
    return positional + [by_name[n] for n in wanted]


def _actual(env: Env, formal: t.Formal, value: t.Expr, scope: Scope) -> Typed:
    if formal.type is None:
        return typed(env, value)
    type_, unit = declared_type(replace(env, scope=scope), formal.type)
    return Typed(of_type(env, value, type_, unit, f"argument '{formal.name}'"), type_)


def _result(env: Env, function: t.Function) -> Typed:
    if function.type is None:
        return typed(env, function.value)
    type_, unit = declared_type(env, function.type)
    return Typed(of_type(env, function.value, type_, unit, f"function '{function.name}'"), type_)


def declared_type(env: Env, type_: t.Type) -> tuple[str, Unit | None]:
    """The type and unit that `: u`, `: bool`, `: Enum` or `: Cell` declares."""
    ctx = env.ctx
    if type_.text == "bool":
        return "bool", None
    symbol = env.scope.lookup(type_.text)
    if symbol is not None and symbol.kind == "enum":
        ctx.use(symbol, type_.span)
        return symbol.payload.name, ctx.one if symbol.payload.low is not None else None
    if symbol is not None and symbol.kind == "cell":
        ctx.use(symbol, type_.span)
        return f"cell {symbol.name}", None
    return "real", ctx.unit(type_.text, type_.span)


# ---- polynomial tables ----------------------------------------------------------


def _polynomial(env: Env, row: Row, node: t.Call) -> Typed:
    table = row.table
    if table.poly is None or len(row.keys) < len(table.keys):
        env.ctx.fail("HA105", f"table {table.name} is not called like this", node.span)
    (argument,) = arguments(env, node, 1, table.name)
    x = to_unit(env.ctx, real(env, argument), table.argument, f"the argument of {table.name}", argument.span)
    symbols = cells_of(env, row, node.span)
    terms = [_monomial(env, symbols[c], x, e) for c, e in table.poly[row.keys]]
    return Typed(exact(env, node.span, lambda: A.total(terms, table.result, node.span)), "real")


def _monomial(env: Env, cell: Symbol, x: Expr, exponent: int) -> tuple[str, Expr]:
    cell = env.ctx.use(cell, None)
    c = Expr(cell.kind, (cell.name,), cell.unit, cell.span)
    if exponent == 0:
        return "+", c
    unit = power(x.unit, exponent) if x.unit is not None else None
    p = x if exponent == 1 else A.raised(x, number(exponent, env.ctx.one, x.span), unit, x.span)
    whole = c.unit * unit if c.unit is not None and unit is not None else None
    return "+", A.product([("*", c), ("*", p)], whole, x.span)


# ---- built-in functions ---------------------------------------------------------


def _builtin(env: Env, node: t.Call, name: str) -> Typed:
    if any(a.family for a in node.arguments):
        return _aggregate(env, node, name)
    if name in _ANGLE or name in _INVERSE or name in _PLAIN:
        return Typed(_elementary(env, node, name), "real")
    found = _SPECIAL.get(name)
    if found is not None:
        return found(env, node)
    if name in _BUILTIN:
        from haverify.elaborate.applications import special

        return special(env, node, name)
    return env.ctx.unknown("function", name, env.scope.label, node.function.span, (*_BUILTIN, *env.scope.visible()))


def _elementary(env: Env, node: t.Call, name: str) -> Expr:
    (argument,) = arguments(env, node, 1, name)
    e = real(env, argument)
    e = angle(env.ctx, e, name, argument.span) if name in _ANGLE else plain(env.ctx, e, f"{name}()", argument.span)
    unit = RADIAN if name in _INVERSE and not env.ctx.unitless else env.ctx.one
    return Expr(name, (e,), unit, node.span)


def _abs(env: Env, node: t.Call) -> Typed:
    (argument,) = arguments(env, node, 1, "abs")
    e = real(env, argument)
    value = A.literal(e)
    if value is not None:
        return Typed(number(abs(value), e.unit, node.span), "real")
    return Typed(Expr("abs", (e,), e.unit, node.span), "real")


def _sqrt(env: Env, node: t.Call) -> Typed:
    (argument,) = arguments(env, node, 1, "sqrt")
    e = real(env, argument)
    unit = e.unit
    if unit is not None and any(n % 2 for _, n in unit.factors):
        unit = coherent(unit)
        e = to_unit(env.ctx, e, unit, "", node.span)
    half = power(unit, Fraction(1, 2)) if unit is not None else None
    return Typed(Expr("sqrt", (e,), half, node.span), "real")


def _atan2(env: Env, node: t.Call) -> Typed:
    y, x = (real(env, a) for a in arguments(env, node, 2, "atan2"))
    x = to_unit(env.ctx, x, y.unit, "atan2()", node.span)
    return Typed(Expr("atan2", (y, x), None if env.ctx.unitless else RADIAN, node.span), "real")


def _clamp(env: Env, node: t.Call) -> Typed:
    arguments(env, node, 3, "clamp")
    return _same_unit(env, node, "clamp")


def _extreme(name: str) -> Callable[[Env, t.Call], Typed]:
    return lambda env, node: _same_unit(env, node, name)


def _same_unit(env: Env, node: t.Call, name: str) -> Typed:
    given = arguments(env, node, None, name)
    if not given:
        env.ctx.fail("HA105", f"{name}() takes at least one argument", node.span)
    values = [real(env, a) for a in given]
    rest = [
        to_unit(env.ctx, e, values[0].unit, f"{name}()", a.span) for e, a in zip(values[1:], given[1:], strict=True)
    ]
    return Typed(_one_of(name, [values[0], *rest], node.span), "real")


def _one_of(name: str, values: Sequence[Expr], span: Span) -> Expr:
    return values[0] if len(values) == 1 else Expr(name, tuple(values), values[0].unit, span)


def _aggregate(env: Env, node: t.Call, name: str) -> Typed:
    """`sum(e for i in I)` and the like, written out."""
    if len(node.arguments) != 1 or name not in ("sum", "min", "max", "all", "any"):
        env.ctx.fail("HA105", f"`for` belongs in sum, min, max, all, any with one argument, not in {name}()", node.span)
    family = node.arguments[0].family
    assert family is not None
    enum = family_enum(env, family.of)
    spend(env.ctx, len(enum.values), node.span)
    places = [env.bind(**{family.name: env.ctx.value(enum, v)}) for v in enum.values]
    body = node.arguments[0].value
    if name in ("all", "any"):
        join = A.every if name == "all" else A.some
        return Typed(join([boolean(p, body) for p in places], node.span), "bool")
    values = [real(p, body) for p in places]
    values = [values[0], *(to_unit(env.ctx, e, values[0].unit, f"{name}()", body.span) for e in values[1:])]
    if name != "sum":
        return Typed(_one_of(name, values, node.span), "real")
    if len(values) == 1:
        return Typed(values[0], "real")
    return Typed(exact(env, node.span, lambda: A.total([("+", v) for v in values], values[0].unit, node.span)), "real")


# ---- about the instant ----------------------------------------------------------


def _at(env: Env, node: t.Call) -> Typed:
    (argument,) = arguments(env, node, 1, "at")
    from haverify.elaborate.paths import modes_at

    return Typed(A.some([Expr("at", (m,), None, node.span) for m in modes_at(env, argument)], node.span), "bool")


def _jump(env: Env, node: t.Call) -> Typed:
    (argument,) = arguments(env, node, 1, "jump")
    _claims_only(env, "jump", node.span)
    from haverify.elaborate.paths import edges_at

    return Typed(A.some([Expr("jump", (m,), None, node.span) for m in edges_at(env, argument)], node.span), "bool")


def _pre(env: Env, node: t.Call) -> Typed:
    (argument,) = arguments(env, node, 1, "pre")
    _claims_only(env, "pre", node.span)
    value = typed(env, argument)
    return Typed(Expr("pre", (value.expr,), value.expr.unit, node.span), value.type)


def _der(env: Env, node: t.Call) -> Typed:
    (argument,) = arguments(env, node, 1, "der")
    _claims_only(env, "der", node.span)
    e = real(env, argument)
    unit = e.unit / SECOND if e.unit is not None else None
    return Typed(Expr("der", (e,), unit, node.span), "real")


def _claims_only(env: Env, name: str, span: Span) -> None:
    if not env.is_claim:
        env.ctx.fail("HA105", f"{name}() has a meaning in claims only", span)


_SPECIAL: dict[str, Callable[[Env, t.Call], Typed]] = {
    "abs": _abs, "sqrt": _sqrt, "atan2": _atan2, "clamp": _clamp, "min": _extreme("min"), "max": _extreme("max"),
    "at": _at, "jump": _jump, "pre": _pre, "der": _der,
}  # fmt: skip
