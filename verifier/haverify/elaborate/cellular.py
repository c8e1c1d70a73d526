"""Cellular automata and relations."""

from __future__ import annotations

from typing import Any

from haverify.elaborate.cells import CellSet, bits_of
from haverify.elaborate.context import Lost
from haverify.elaborate.declare import Entries
from haverify.elaborate.expressions import Env, of_type
from haverify.elaborate.scope import Scope, Symbol, Typed
from haverify.model.cellular import CellularAutomaton, Relation, Rule
from haverify.model.expression import Expr
from haverify.model.spec import EnumType
from haverify.syntax import tree as t
from haverify.text.record import field, holder


@holder
class Subject:
    """What claims on a cellular automaton or a relation may name."""

    scope: Scope
    relation: Relation | None = None
    left_of: dict[str, bool] = field(default_factory=dict)  # enumerations that have, or lack, its left names
    right_of: dict[str, str] = field(default_factory=dict)  # the enumeration of its images, by that of its left names


def enter_cellular(entries: Entries, item: t.Item, decl: t.Cellular) -> None:
    """Enter a cellular automaton and, at once, the name of its cells."""
    env = entries.env
    symbol = Symbol("cellular", entries.name_of(decl.name), decl.name_span, state="pending")
    lines = [line for line in decl.lines if isinstance(line, t.CellLine)]
    if env.ctx.define(env.scope.names, decl.name, symbol, "cellular automaton"):
        entries.symbols.append(symbol)
    if not lines:
        env.ctx.report("HA105", f"{decl.name} does not say what its cells are: `cell C = A ++ B`", decl.name_span)
        symbol.state = "lost"
        return
    cell = _declared_cells(env, lines[0])

    def make() -> None:
        entries.models[symbol] = _automaton(env, symbol, item, decl, env.ctx.use(cell, None).payload)

    symbol.make = make


def _declared_cells(env: Env, line: t.CellLine) -> Symbol:
    """The cells of an automaton; those of another one where the line is the same."""
    old = env.scope.names.get(line.name)
    if old is not None and old.kind == "cell" and old.type == f"{line.first} {line.second}":
        return old
    cell = Symbol("cell", line.name, line.span, f"{line.first} {line.second}", state="pending", used=True)
    cell.make = lambda: _cells(env, cell, line)
    env.ctx.define(env.scope.names, line.name, cell, "cell")
    return cell


def _cells(env: Env, symbol: Symbol, line: t.CellLine) -> None:
    first, second = (_enum(env, name, line) for name in (line.first, line.second))
    if first.name.lower() == second.name.lower():
        told = f"both parts of {symbol.name} would be called '{first.name.lower()}': two enumerations are needed"
        env.ctx.fail("HA105", told, line.span)
    symbol.payload = CellSet(symbol.name, first, second, (line.first, line.second))


def _enum(env: Env, name: str, line: t.CellLine) -> EnumType:
    symbol = env.scope.lookup(name)
    if symbol is None or symbol.kind != "enum":
        env.ctx.unknown("enumeration", name, "", line.span, env.ctx.enums)
    enum: EnumType = env.ctx.use(symbol, line.span).payload
    env.ctx.used_enums.add(enum.name)
    return enum


def _automaton(env: Env, symbol: Symbol, item: t.Item, decl: t.Cellular, cells: CellSet) -> CellularAutomaton:
    scope = Scope(f"cellular automaton {symbol.name}", env.scope, is_machine=True)
    symbol.payload = Subject(scope)
    for word in ("next", "unique_rule"):
        scope.names[word] = Symbol("cellword", word, payload=(symbol.name, cells.name), used=True)
    rules = _rules(env, decl, cells)
    argument, formula = None, None
    for line in decl.lines:
        if isinstance(line, t.NextLine):
            argument = line.name
            bound = Typed(Expr("bound", (line.name,), None, line.span), f"cell {cells.name}")
            formula = of_type(env.bind(**{line.name: bound}), line.value, f"cell {cells.name}", None, "next()")
    return CellularAutomaton(
        symbol.name, cells.name, cells.first.name, cells.second.name, rules, argument, formula, "\n".join(item.docs),
        decl.name_span,
    )  # fmt: skip


def _rules(env: Env, decl: t.Cellular, cells: CellSet) -> tuple[Rule, ...]:
    rules, is_good = [], True
    for line in decl.lines:
        if isinstance(line, t.RuleLine):
            try:
                rules.append(Rule(bits_of(env.ctx, cells, line.left), bits_of(env.ctx, cells, line.right), line.span))
            except Lost:
                is_good = False
    if not is_good:
        raise Lost
    return tuple(rules)


def enter_relation(entries: Entries, item: t.Item, decl: t.Relation) -> None:
    """Enter a relation between names."""
    env = entries.env
    name = entries.name_of(decl.name)
    pairs = tuple((_word(line.left), _word(line.right)) for line in decl.lines)
    is_map = not any(line.is_pair for line in decl.lines)
    spans = tuple(line.span for line in decl.lines)
    model = Relation(name, pairs, is_map, "\n".join(item.docs), decl.name_span, spans)
    scope = Scope(f"relation {name}", env.scope, is_machine=True)
    symbol = Symbol("relation", name, decl.name_span, payload=Subject(scope, model))
    if env.ctx.define(env.scope.names, decl.name, symbol, "relation"):
        entries.symbols.append(symbol)
        entries.models[symbol] = model
    for word in {w for pair in pairs for w in pair}:
        env.ctx.used_values.update((owner, word) for owner in env.ctx.values.get(word, []))


def _word(node: Any) -> str:
    return str(node.id)
