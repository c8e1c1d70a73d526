"""Constants, params, inputs, variables, outputs and functions of a file, an automaton or a system."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from haverify.elaborate.calls import declared_type
from haverify.elaborate.expressions import Env, family_enum, interval, of_type, range_in, seconds, typed
from haverify.elaborate.scope import Members, Symbol
from haverify.model.expression import Expr
from haverify.model.hybrid import Constant, Input, Param, Variable
from haverify.model.spec import EnumType
from haverify.model.unit import SECOND, Unit
from haverify.syntax import tree as t
from haverify.text.record import field, holder
from haverify.text.span import Span


@holder
class Entries:
    """The declarations of one block in order; `models` are what has been elaborated, by symbol.

    `optional` ones count only when something reads them. Right sides stand at `place` where that is another one.
    """

    env: Env
    name_of: Callable[[str], str] = str
    symbols: list[Symbol] = field(default_factory=list)
    models: dict[Symbol, Any] = field(default_factory=dict)
    optional: set[Symbol] = field(default_factory=set)
    place: Env | None = None

    def of(self, kind: type) -> tuple[Any, ...]:
        """The elaborated declarations of one kind, in order."""
        found: list[Any] = []
        for s in self.symbols:
            if s in self.optional and not s.used:
                continue
            model = self.models.get(s)
            found.extend(model if isinstance(model, list) else (model,))
        return tuple(m for m in found if isinstance(m, kind))

    def made(self, kind: str) -> Iterator[Any]:
        """What has been elaborated under symbols of one kind, in order."""
        for s in self.symbols:
            model = self.models.get(s) if s.kind == kind else None
            if model is not None:
                yield from model if isinstance(model, list) else (model,)

    def settle(self) -> bool:
        """Elaborate everything; whether all of it has a meaning."""
        good = [self.env.ctx.settle(s) for s in self.symbols]
        return all(good)


Make = Callable[[Env, Symbol], Any]


def declare(
    entries: Entries, declared: t.Declared, kind: str, make: Make, table: dict[str, Symbol] | None = None
) -> None:
    """Enter a declared name, or all members of its family; `make` gives the model of one."""
    env = entries.env
    table = env.scope.names if table is None else table
    core = entries.name_of(declared.name)
    if declared.family is None and declared.index is None:
        symbol = _pending(entries, env, core, kind, make, declared.span)
        if env.ctx.define(table, declared.name, symbol, kind):
            entries.symbols.append(symbol)
        return
    family = _family(entries, declared, kind, table, core)
    if family is None:
        return
    for value, place in _places(env, declared, family.enum):
        symbol = _pending(entries, place, f"{core}[{value}]", kind, make, declared.span)
        if env.ctx.define(family.by_value, value, symbol, f"{kind} {core}"):
            entries.symbols.append(symbol)


def _pending(entries: Entries, env: Env, name: str, kind: str, make: Make, span: Span) -> Symbol:
    symbol = Symbol(kind, name, span, state="pending")

    def run() -> None:
        entries.models[symbol] = make(entries.place or env, symbol)

    symbol.make = run
    return symbol


def _family(entries: Entries, declared: t.Declared, kind: str, table: dict[str, Symbol], core: str) -> Members | None:
    """The family a name belongs to, made when it is the first of its members."""
    env = entries.env
    if declared.family is not None:
        enum: EnumType | None = family_enum(env, declared.family.of)
    else:
        enum = enum_with(env, declared, table)
    assert enum is not None
    old = table.get(declared.name)
    if old is not None and old.kind == "family" and declared.index is not None:
        members: Members = old.payload
        return members
    members = Members(enum)
    symbol = Symbol("family", core, declared.span, payload=members)
    return members if env.ctx.define(table, declared.name, symbol, kind) else None


def enum_with(env: Env, declared: t.Declared, table: dict[str, Symbol]) -> EnumType:
    """The enumeration whose values are the explicit indices of `name[index]` so far."""
    assert declared.index is not None
    old = table.get(declared.name)
    known: Members | None = old.payload if old is not None and old.kind == "family" else None
    wanted = {declared.index, *(known.by_value if known else ())}
    for owner in env.ctx.values.get(declared.index, []):
        enum = env.ctx.enums[owner]
        if wanted <= set(enum.values):
            if known is not None:
                known.enum = enum
            return enum
    return env.ctx.fail("HA009", f"{declared.name}[{declared.index}]: no enumeration has this value", declared.span)


def _places(env: Env, declared: t.Declared, enum: EnumType) -> Iterator[tuple[str, Env]]:
    if declared.family is None:
        assert declared.index is not None
        yield declared.index, env
        return
    for value in enum.values:
        yield value, env.bind(**{declared.family.name: env.ctx.value(enum, value)})


# ---- the kinds ------------------------------------------------------------------


def constant(item: t.Item, decl: t.Const) -> Make:
    """What `const` declares: one exact value, or a set."""

    def make(env: Env, symbol: Symbol) -> Constant:
        if _is_set(decl.value):
            return _set_constant(env, symbol, decl)
        value = _valued(env, symbol, decl.type, decl.value, "const")
        if not env.scope.machine():
            env.ctx.constant_values[symbol.name] = value
        half = _rounding(env, item, symbol)
        return Constant(symbol.name, symbol.type, symbol.unit, value, half, decl.span)

    return make


def _is_set(node: t.Expr) -> bool:
    while type(node) is t.Paren:
        node = node.inner
    return isinstance(node, t.Interval) or (isinstance(node, t.Binary) and node.op == "+-")


def _set_constant(env: Env, symbol: Symbol, decl: t.Const) -> Constant:
    found = interval(env, decl.value)
    unit = found.unit
    bounds = found.range
    if decl.type is not None:
        unit = declared_type(env, decl.type)[1]
        bounds = range_in(env, decl.value, unit, f"const {symbol.name}")
    symbol.kind, symbol.unit, symbol.payload = "set", unit, bounds
    return Constant(symbol.name, "real", unit, bounds, None, decl.span)


def _valued(env: Env, symbol: Symbol, type_: t.Type | None, value: t.Expr, kind: str) -> Expr:
    """The value of a const or let, whose type and unit are those declared, or its own."""
    if type_ is None:
        found = typed(env, value)
        symbol.type, symbol.unit = found.type, found.expr.unit
        return found.expr
    symbol.type, symbol.unit = declared_type(env, type_)
    return of_type(env, value, symbol.type, symbol.unit, f"{kind} {symbol.name}")


def _rounding(env: Env, item: t.Item, symbol: Symbol) -> Any:
    """The half-width that `@rounding(h)` gives a printed coefficient."""
    for attribute in item.attributes:
        if attribute.name == "rounding" and attribute.arguments:
            value = attribute.arguments[0].value
            if not isinstance(value, str):
                e = of_type(env, value, "real", symbol.unit, "@rounding")
                return e.args[0] if e.op == "num" else None
    return None


def param(decl: t.Param) -> Make:
    """What `param` declares."""

    def make(env: Env, symbol: Symbol) -> Param:
        found = interval(env, decl.range)
        symbol.unit = found.unit
        if decl.type is not None:
            kind, symbol.unit = declared_type(env, decl.type)
            if kind != "real":
                env.ctx.fail("HA105", f"param {symbol.name} is of type {kind}, but a param is a real number", decl.span)
        bounds = range_in(env, decl.range, symbol.unit, f"param {symbol.name}")
        default = None
        if decl.default is not None:
            default = of_type(env, decl.default, "real", symbol.unit, f"default of {symbol.name}")
        return Param(symbol.name, symbol.unit, bounds, default, decl.span)

    return make


def input_(decl: t.Input) -> Make:
    """What `input` declares."""

    def make(env: Env, symbol: Symbol) -> Input:
        symbol.type, symbol.unit = _input_type(env, decl)
        what = f"input {symbol.name}"
        bounds = range_in(env, decl.range, symbol.unit, what) if decl.range else None
        slope = symbol.unit / SECOND if symbol.unit is not None else None
        rate = range_in(env, decl.rate, slope, f"rate of {symbol.name}") if decl.rate else None
        every = seconds(env, decl.every, f"period of {symbol.name}") if decl.every else None
        return Input(symbol.name, symbol.type, symbol.unit, bounds, rate, every, decl.span)

    return make


def _input_type(env: Env, decl: t.Input) -> tuple[str, Unit | None]:
    if decl.type is not None:
        return declared_type(env, decl.type)
    return "real", interval(env, decl.range).unit if decl.range else env.ctx.one


def variable(decl: t.Var) -> Make:
    """What `var` declares, for one of its names."""

    def make(env: Env, symbol: Symbol) -> Variable:
        symbol.type, symbol.unit = ("real", env.ctx.one) if decl.type is None else declared_type(env, decl.type)
        bounds = range_in(env, decl.range, symbol.unit, f"var {symbol.name}") if decl.range else None
        return Variable(symbol.name, symbol.type, symbol.unit, bounds, symbol.span)

    return make


def function(entries: Entries, decl: t.Function) -> None:
    """Enter a function; its body is elaborated at each call."""
    scope = entries.env.scope
    symbol = Symbol("fn", decl.name, decl.span, payload=(decl, scope, False))
    entries.env.ctx.define(scope.names, decl.name, symbol, "function")
