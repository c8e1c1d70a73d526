"""Outputs (`let`): valid in all modes, per mode of a family, or given by single modes."""

from __future__ import annotations

from collections.abc import Sequence

from haverify.elaborate.calls import declared_type
from haverify.elaborate.context import NeedsMode
from haverify.elaborate.declare import Entries, declare
from haverify.elaborate.expressions import Env, of_type, type_phrase, typed
from haverify.elaborate.scope import Scope, Symbol
from haverify.elaborate.units import to_unit
from haverify.model.expression import Expr
from haverify.model.hybrid import Output
from haverify.syntax import tree as t
from haverify.text.record import field, holder
from haverify.text.span import Span


@holder
class ModeScope:
    """A mode of an automaton while it is elaborated; `scope` knows the parameter of its family."""

    name: str
    decl: t.Mode
    scope: Scope
    param: str | None = None
    lets: dict[str, Output] = field(default_factory=dict)
    span: Span | None = None


@holder
class Definition:
    """The texts that define one output: for all modes, or for single ones."""

    general: t.Let | None = None
    by_mode: list[tuple[ModeScope, t.Let]] = field(default_factory=list)


def enter_lets(entries: Entries, items: Sequence[t.Item], modes: Sequence[ModeScope]) -> None:
    """Enter the outputs of an automaton; those that modes give are known in the whole automaton."""
    found: dict[str, Definition] = {}
    heads: dict[str, t.Declared] = {}
    for item in items:
        if isinstance(item.body, t.Let):
            _enter(entries, found, heads, item.body, None)
    for mode in modes:
        for item in mode.decl.members:
            if isinstance(item.body, t.Let):
                _enter(entries, found, heads, item.body, mode)
    for key, declared in heads.items():
        _declare(entries, declared, found[key], modes)


def bound_output(entries: Entries, let: t.Let, place: Env | None) -> None:
    """Enter the output that an instance puts in place of an input; its right side stands at `place`."""

    def make(env: Env, symbol: Symbol) -> Output:
        return _output(place or env, symbol, let, False)

    declare(entries, let.declared, "let", make)


def _enter(
    entries: Entries, found: dict[str, Definition], heads: dict[str, t.Declared], let: t.Let, mode: ModeScope | None
) -> None:
    key = let.declared.name if let.declared.index is None else f"{let.declared.name}[{let.declared.index}]"
    definition = found.setdefault(key, Definition())
    heads.setdefault(key, let.declared)
    if mode is None and definition.general is None:
        definition.general = let
    elif mode is not None and not any(m is mode for m, _ in definition.by_mode):
        definition.by_mode.append((mode, let))
    else:
        entries.env.ctx.report("HA004", f"let '{key}' is defined twice", let.declared.span)


def _declare(entries: Entries, declared: t.Declared, definition: Definition, modes: Sequence[ModeScope]) -> None:
    def make(env: Env, symbol: Symbol) -> Output | None:
        return _elaborate(env, symbol, definition, modes)

    declare(entries, declared, "let", make)


def _elaborate(env: Env, symbol: Symbol, definition: Definition, modes: Sequence[ModeScope]) -> Output | None:
    for mode, let in definition.by_mode:
        mode.lets[symbol.name] = _output(_inside(env, mode), symbol, let, bool(mode.lets) or symbol.state == "typed")
        symbol.payload = True
    if definition.general is None:
        return None
    try:
        return _output(env, symbol, definition.general, bool(definition.by_mode))
    except NeedsMode as need:
        _per_mode(env, symbol, definition.general, modes, need.symbol.name)
        return None


def _per_mode(env: Env, symbol: Symbol, let: t.Let, modes: Sequence[ModeScope], param: str) -> None:
    for mode in modes:
        if mode.param == param and symbol.name not in mode.lets:
            mode.lets[symbol.name] = _output(_inside(env, mode), symbol, let, symbol.payload is True)
            symbol.payload = True


def _inside(env: Env, mode: ModeScope) -> Env:
    """`env` with the parameter of the mode's family; local names of `env` stay visible."""
    value = mode.scope.names.get(mode.param) if mode.param else None
    return env if value is None or mode.param is None else env.bind(**{mode.param: value.payload})


def _output(env: Env, symbol: Symbol, let: t.Let, is_known: bool) -> Output:
    """The output of one definition; the first one of several settles type and unit where none is declared."""
    if let.type is not None:
        symbol.type, symbol.unit = declared_type(env, let.type)
        e: Expr = of_type(env, let.value, symbol.type, symbol.unit, f"let {symbol.name}")
    else:
        value = typed(env, let.value)
        if symbol.payload is not True:
            symbol.type, symbol.unit = value.type, value.expr.unit
        elif value.type != symbol.type:
            env.ctx.fail("HA105", f"let {symbol.name} is {type_phrase(env.ctx, symbol.type)} in another mode", let.span)
        e = to_unit(env.ctx, value.expr, symbol.unit, f"let {symbol.name}", let.value.span)
    return Output(symbol.name, symbol.type, symbol.unit, e, let.span)
