"""Syntax to typed exact expressions: names resolved, units checked, quantifiers over enumerations written out."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from haverify.diagnostics.diagnostic import Severity
from haverify.elaborate import arithmetic as A
from haverify.elaborate.context import Context, Lost, NeedsMode
from haverify.elaborate.limits import spend
from haverify.elaborate.scope import Cases, Members, Row, Scope, SetValue, Symbol, Typed
from haverify.elaborate.selection import by_cases, mapped
from haverify.elaborate.units import alike, to_unit, unit_phrase
from haverify.elaborate.values import exact_value
from haverify.maths.exact import fits
from haverify.model.expression import Expr, number
from haverify.model.hybrid import Range
from haverify.model.spec import EnumType
from haverify.model.unit import SECOND, Unit, coherent, power
from haverify.syntax import tree as t
from haverify.text.record import record, replace
from haverify.text.span import Span


@record
class Env:
    """Where an expression stands: its scope, and what may occur in it besides values.

    `is_claim`: `jump`, `jumped`, `pre`, `der`, `stuck` have a meaning; `is_stl`: temporal operators too.
    `split` makes one expression of its values in the modes of a family, where no mode is given.
    """

    ctx: Context
    scope: Scope
    is_claim: bool = False
    is_stl: bool = False
    split: Callable[[Env, t.Expr, Symbol], Expr] | None = None

    def bind(self, **values: Typed) -> Env:
        """The same place with local names."""
        return replace(self, scope=self.scope.bind(values))


Found = Typed | Symbol | Row | SetValue | Cases


def typed(env: Env, node: t.Expr, expect: str | None = None) -> Typed:
    """The value of an expression; a bare name is first looked for in the enumeration `expect`."""
    while type(node) is t.Paren:
        node = node.inner
    return _HANDLERS[type(node)](env, node, expect)


def real(env: Env, node: t.Expr) -> Expr:
    """The value of an expression that must be a number."""
    e, type_ = typed(env, node)
    if not env.ctx.is_number(type_):
        env.ctx.fail("HA105", f"a number is needed here, this is {type_phrase(env.ctx, type_)}", node.span)
    return e


def boolean(env: Env, node: t.Expr) -> Expr:
    """The value of an expression that must be a truth value."""
    e, type_ = typed(env, node)
    if type_ != "bool":
        env.ctx.fail("HA105", f"a truth value is needed here, this is {type_phrase(env.ctx, type_)}", node.span)
    return e


def of_type(env: Env, node: t.Expr, type_: str, unit: Unit | None, what: str, code: str = "HA101") -> Expr:
    """The value of an expression that must have a type and, if a number, fit a unit."""
    e, found = typed(env, node, type_ if type_ != "real" else None)
    both_numbers = env.ctx.is_number(type_) and env.ctx.is_number(found)
    if found != type_ and not both_numbers:
        env.ctx.fail(
            "HA105", f"{what} is {type_phrase(env.ctx, type_)}, this is {type_phrase(env.ctx, found)}", node.span
        )
    return to_unit(env.ctx, e, unit, what, node.span, code) if both_numbers else e


def type_phrase(ctx: Context, type_: str) -> str:
    """A type in a sentence."""
    if type_ == "real":
        return "a number"
    if type_ == "bool":
        return "a truth value"
    return f"a value of {type_.removeprefix('cell ')}"


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


def exact(env: Env, span: Span, build: Callable[[], Expr]) -> Expr:
    """What `build` gives; a number too large or a division by zero is a finding."""
    try:
        return build()
    except A.TooLarge:
        env.ctx.fail("HA105", "this number is too large: exact numbers have at most 4,200 digits", span)
    except A.DividedByZero:
        env.ctx.fail("HA403", "division by zero: this expression has no value", span, severity=Severity.ERROR)


# ---- literals -------------------------------------------------------------------


def _number(env: Env, node: t.Number, expect: str | None) -> Typed:
    if not fits(node.value):
        env.ctx.fail("HA105", "this number is too large: exact numbers have at most 4,200 digits", node.span)
    unit = env.ctx.unit(node.unit, node.span) if node.unit else env.ctx.one
    return Typed(number(node.value, unit, node.span), "real")


def _truth(env: Env, node: t.Truth, expect: str | None) -> Typed:
    return Typed(A.truth(node.value, node.span), "bool")


def _bits(env: Env, node: t.Bits, expect: str | None) -> Typed:
    return _cell(env, node, expect)


def _cell(env: Env, node: t.Bits | t.Pair, expect: str | None) -> Typed:
    """A constant cell, where a cell is expected."""
    symbol = env.scope.lookup(expect.removeprefix("cell ")) if expect and expect.startswith("cell ") else None
    if symbol is None:
        env.ctx.fail("HA105", "bits or a pair stand for a cell only where a cell is expected", node.span)
    from haverify.elaborate.cells import bits_of

    bits = bits_of(env.ctx, env.ctx.use(symbol, node.span).payload, node)
    return Typed(Expr("cell", (symbol.name, bits), None, node.span), f"cell {symbol.name}")


# ---- names ----------------------------------------------------------------------


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


# ---- indices --------------------------------------------------------------------


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


# ---- operators ------------------------------------------------------------------


def _unary(env: Env, node: t.Unary, expect: str | None) -> Typed:
    if node.op == "not":
        return Typed(A.negation(boolean(env, node.operand), node.span), "bool")
    return Typed(A.negate(real(env, node.operand), node.span), "real")


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


# ---- comparisons ----------------------------------------------------------------


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


# ---- quantifiers and the rest ---------------------------------------------------


def family_enum(env: Env, of: t.Expr) -> EnumType:
    """The enumeration that a family or quantifier ranges over."""
    found = denote(env, of)
    if isinstance(found, Symbol) and found.kind == "enum":
        enum: EnumType = found.payload
        env.ctx.used_enums.add(enum.name)
        return enum
    return env.ctx.fail("HA105", f"'{source_name(of)}' is no enumeration", of.span)


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


def _temporal(env: Env, node: t.Temporal, expect: str | None) -> Typed:
    _needs_stl(env, node.kind, node.span)
    low, high = later(env, node.low, "a time"), later(env, node.high, "a time")
    return Typed(Expr(node.kind, (low, high, boolean(env, node.body)), None, node.span), "bool")


def _until(env: Env, node: t.Until, expect: str | None) -> Typed:
    _needs_stl(env, "until", node.span)
    low, high = later(env, node.low, "a time"), later(env, node.high, "a time")
    left, right = boolean(env, node.left), boolean(env, node.right)
    return Typed(Expr("until", (low, high, left, right), None, node.span), "bool")


def _needs_stl(env: Env, word: str, span: Span) -> None:
    if not env.is_stl:
        env.ctx.fail("HA105", f"'{word}[a, b]' belongs in an stl goal: `stl {word}[a, b] ...`", span)


def _set(env: Env, node: t.Interval, expect: str | None) -> Typed:
    env.ctx.fail("HA105", "an interval is a set, not a number; use it after `in`", node.span)


def _tuple(env: Env, node: t.Pair, expect: str | None) -> Typed:
    return _cell(env, node, expect)


_HANDLERS: dict[type, Callable[[Env, Any, str | None], Typed]] = {
    t.Number: _number, t.Bits: _bits, t.Truth: _truth, t.Name: _postfix, t.Member: _postfix, t.Index: _postfix,
    t.Call: _postfix, t.Unary: _unary, t.Binary: _binary, t.Comparison: _comparison, t.Interval: _set, t.Pair: _tuple,
    t.If: _if, t.Quantifier: _quantifier, t.Temporal: _temporal, t.Until: _until,
}  # fmt: skip
