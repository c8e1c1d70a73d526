"""Names, members, indices and calls: what a chain of them stands for."""

from __future__ import annotations

from collections.abc import Callable

from haverify.elaborate import arithmetic as A
from haverify.elaborate.context import Lost, NeedsMode
from haverify.elaborate.reading import Env, Found, reads, type_phrase, typed
from haverify.elaborate.scope import Cases, Members, Row, Scope, SetValue, Symbol, Typed
from haverify.elaborate.selection import by_cases, mapped
from haverify.model.expression import Expr
from haverify.model.spec import EnumType
from haverify.model.unit import SECOND
from haverify.syntax import tree as t
from haverify.text.span import Span


@reads(t.Name, t.Member, t.Index, t.Call)
def _postfix(env: Env, node: t.Name | t.Member | t.Index | t.Call, expect: str | None) -> Typed:
    found = denote(env, node, expect)
    if isinstance(found, Typed):
        return found
    if isinstance(found, Row):
        return env.ctx.fail("HA105", f"table {found.table.name} needs {_missing(found)} here", node.span)
    if isinstance(found, SetValue):
        return env.ctx.fail("HA105", "an interval is a set, not a number; use it after `in`", node.span)
    if isinstance(found, Cases):
        return env.ctx.fail(
            "HA105", f"'{source_name(node)}' is no value yet: a column or an argument is missing", node.span
        )
    return env.ctx.fail(
        "HA105", f"'{source_name(node)}' is {_KINDS.get(found.kind, 'no value')}, not a value", node.span
    )


_KINDS = {
    "family": "a family of values: write an index", "automaton": "an automaton", "system": "a system",
    "table": "a table",
    "fn": "a function", "enum": "an enumeration", "part": "a part", "import": "an import", "fuzzy": "a fuzzy system",
    "cellular": "a cellular automaton", "relation": "a relation", "network": "a network", "data": "a table",
}  # fmt: skip


def _missing(row: Row) -> str:
    if len(row.keys) < len(row.table.keys):
        return f"a {row.table.keys[len(row.keys)].name}"
    return "its argument" if row.table.poly is not None else "a column"


def source_name(node: t.Expr) -> str:
    """A name, member or index chain as text."""
    if isinstance(node, t.Name):
        return node.id
    if isinstance(node, t.Member):
        return f"{source_name(node.base)}.{node.name}"
    if isinstance(node, t.Index):
        return f"{source_name(node.base)}[{source_name(node.index)}]"
    if isinstance(node, t.Number):
        return node.text
    return "..."


def denote(env: Env, node: t.Expr, expect: str | None = None) -> Found:
    """What a chain of names, members, indices and calls stands for."""
    while type(node) is t.Paren:
        node = node.inner
    if isinstance(node, t.Name):
        return _name(env, node, expect)
    if isinstance(node, t.Member):
        return _member(env, node)
    if isinstance(node, t.Index):
        return _index(env, node)
    if isinstance(node, t.Call):
        from haverify.elaborate.calls import call

        return call(env, node, expect)
    return typed(env, node, expect)


def _name(env: Env, node: t.Name, expect: str | None) -> Found:
    ctx = env.ctx
    local = env.scope.local(node.id)
    if local is None and expect in ctx.enums and node.id in ctx.enums[expect].values:
        ctx.used_values.add((expect, node.id))
        return ctx.value(ctx.enums[expect], node.id, node.span)
    symbol = local or env.scope.lookup(node.id)
    if symbol is not None:
        return value_of(env, symbol, node.span)
    predefined = _predefined(env, node)
    if predefined is not None:
        return predefined
    return _enum_value(env, node, expect)


def _enum_value(env: Env, node: t.Name, expect: str | None) -> Found:
    ctx = env.ctx
    owners = ctx.values.get(node.id, [])
    if len(owners) == 1:
        ctx.used_values.add((owners[0], node.id))
        return ctx.value(ctx.enums[owners[0]], node.id, node.span)
    if owners:
        ctx.fail(
            "HA105", f"'{node.id}' is a value of {' and of '.join(owners)}; write {owners[0]}.{node.id}", node.span
        )
    known = list(env.scope.visible()) + list(ctx.values) + list(_PREDEFINED)
    place = env.scope.label
    return ctx.unknown(f"value of {expect} or name" if expect else "name", node.id, place, node.span, known)


_PREDEFINED = {"time", "pi", "jumped", "stuck"}


def _predefined(env: Env, node: t.Name) -> Typed | None:
    if node.id == "time":
        return Typed(Expr("time", (), None if env.ctx.unitless else SECOND, node.span), "real")
    if node.id == "pi":
        return Typed(Expr("pi", (), env.ctx.one, node.span), "real")
    if node.id in ("jumped", "stuck"):
        if not env.is_claim:
            env.ctx.fail("HA105", f"'{node.id}' has a meaning in claims only", node.span)
        return Typed(Expr(node.id, (), None, node.span), "bool")
    return None


def value_of(env: Env, symbol: Symbol, span: Span) -> Found:
    """What a symbol stands for where it is used at `span`."""
    symbol = env.ctx.use(symbol, span)
    if symbol.kind == "value":
        value = symbol.payload
        assert isinstance(value, Typed)
        return Typed(Expr(value.expr.op, value.expr.args, value.expr.unit, span), value.type)
    if symbol.kind in ("const", "param", "input", "var", "let", "netinput", "netoutput", "fuzzyinput"):
        args = symbol.payload if symbol.kind in ("netinput", "netoutput", "fuzzyinput") else (symbol.name,)
        return Typed(Expr(symbol.kind, args, symbol.unit, span), symbol.type)
    if symbol.kind == "set":
        return SetValue(symbol.payload, symbol.unit)
    if symbol.kind == "modeparam":
        raise NeedsMode(symbol)
    if symbol.kind == "table":
        return Row(symbol.payload, ())
    return symbol


def _member(env: Env, node: t.Member) -> Found:
    return _member_of(env, denote(env, node.base), node)


def _member_of(env: Env, base: Found, node: t.Member) -> Found:
    if isinstance(base, Cases):
        return mapped(env.ctx, base, lambda f: _member_of(env, f, node), node.span)
    if isinstance(base, Row):
        return _column(env, base, node)
    if isinstance(base, Typed):
        return _field(env, base, node)
    if isinstance(base, Symbol):
        return _inside(env, base, node)
    return env.ctx.fail("HA105", f"'{source_name(node.base)}' has no members", node.span)


def _inside(env: Env, base: Symbol, node: t.Member) -> Found:
    ctx = env.ctx
    if base.kind == "enum":
        enum: EnumType = base.payload
        if node.name not in enum.values:
            ctx.unknown("value", node.name, enum.name, node.span, enum.values)
        ctx.used_values.add((enum.name, node.name))
        return ctx.value(enum, node.name, node.span)
    scope = getattr(base.payload, "scope", None)
    if not isinstance(scope, Scope):
        ctx.fail(
            "HA105", f"'{source_name(node.base)}' is {_KINDS.get(base.kind, 'no scope')}, it has no members", node.span
        )
    found = scope.names.get(node.name)
    if found is None:
        ctx.unknown("name", node.name, scope.label, node.span, scope.names)
    return value_of(env, found, node.span)


def _field(env: Env, base: Typed, node: t.Member) -> Found:
    kind, _, cell = base.type.partition(" ")
    symbol = env.scope.lookup(cell) if kind == "cell" else None
    if symbol is None or symbol.kind != "cell":
        return env.ctx.fail("HA105", f"{type_phrase(env.ctx, base.type)} has no member '{node.name}'", node.span)
    parts: dict[str, str] = env.ctx.use(symbol, node.span).payload.parts
    if node.name not in parts:
        env.ctx.unknown("part", node.name, cell, node.span, parts)
    enum = parts[node.name]
    return Typed(Expr("field", (base.expr, enum.lower()), None, node.span), enum)


def _column(env: Env, row: Row, node: t.Member) -> Found:
    table = row.table
    if len(row.keys) < len(table.keys) or table.is_matrix or table.poly is not None:
        env.ctx.fail("HA105", f"table {table.name} needs {_missing(row)} here", node.span)
    symbols = cells_of(env, row, node.span)
    if node.name not in table.columns:
        env.ctx.unknown("column", node.name, f"table {table.name}", node.span, table.columns)
    return value_of(env, symbols[node.name], node.span)


def cells_of(env: Env, row: Row, span: Span) -> dict[str, Symbol]:
    """The cells of a row of a keyed table; a row that is missing was reported with the table."""
    found = row.table.rows.get(row.keys)
    if not found:
        raise Lost
    return found


def _index(env: Env, node: t.Index) -> Found:
    return _index_of(env, denote(env, node.base), node)


def _index_of(env: Env, base: Found, node: t.Index) -> Found:
    if isinstance(base, Cases):
        return mapped(env.ctx, base, lambda f: _index_of(env, f, node), node.span)
    if isinstance(base, Row) and len(base.keys) < len(base.table.keys):
        enum = base.table.keys[len(base.keys)]
        return _select(env, node, enum, lambda v: _row(env, base, v, node.span))
    if isinstance(base, Symbol) and base.kind == "family":
        members: Members = base.payload
        return _select(env, node, members.enum, lambda v: _element(env, members, v, node))
    return env.ctx.fail("HA105", f"'{source_name(node.base)}' takes no index", node.span)


def _row(env: Env, base: Row, value: str, span: Span) -> Found:
    row = Row(base.table, (*base.keys, value))
    if base.table.is_matrix and len(row.keys) == 2:
        return value_of(env, cells_of(env, row, span)[""], span)
    return row


def _element(env: Env, members: Members, value: str, node: t.Index) -> Found:
    symbol = members.by_value.get(value)
    if symbol is None:
        env.ctx.fail("HA009", f"{source_name(node.base)}[{value}] is not declared", node.span)
    return value_of(env, symbol, node.span)


def _select(env: Env, node: t.Index, enum: EnumType, pick: Callable[[str], Found]) -> Found:
    value = index_value(env, node.index, enum, source_name(node.base))
    if isinstance(value, str):
        return pick(value)
    return by_cases(env.ctx, value, enum, pick, node.span)


def index_value(env: Env, node: t.Expr, enum: EnumType, what: str) -> str | Typed:
    """The value of `enum` that an index is, or the expression that decides it when a run goes on; else HA009."""
    value = typed(env, node, enum.name)
    ctx = env.ctx
    exact_value = A.literal(value.expr)
    if value.expr.op == "sym" and value.type == enum.name:
        return str(value.expr.args[1])
    if exact_value is not None and enum.low is not None and ctx.is_number(value.type):
        text = str(exact_value)
        if text not in enum.values:
            ctx.fail("HA009", f"{what}[{text}]: {enum.name} is {enum.values[0]}..{enum.values[-1]}", node.span)
        return text
    if value.type == enum.name or (enum.low is not None and ctx.is_number(value.type)):
        return value
    return ctx.fail("HA009", f"{what} is indexed by {enum.name}, this is {type_phrase(ctx, value.type)}", node.span)


def family_enum(env: Env, of: t.Expr) -> EnumType:
    """The enumeration that a family or quantifier ranges over."""
    found = denote(env, of)
    if isinstance(found, Symbol) and found.kind == "enum":
        enum: EnumType = found.payload
        env.ctx.used_enums.add(enum.name)
        return enum
    return env.ctx.fail("HA105", f"'{source_name(of)}' is no enumeration", of.span)
