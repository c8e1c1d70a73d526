"""`automaton B = A with { k = e; r in R; u = e }`: A with constants, params and inputs rebound."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from haverify.elaborate.automaton import Machine, Replacement, elaborate_automaton
from haverify.elaborate.expressions import Env, denote
from haverify.elaborate.scope import Symbol
from haverify.syntax import tree as t
from haverify.text.record import record


@record
class Base:
    """The text of an automaton and where it stands."""

    decl: t.Automaton
    env: Env
    given: tuple[Replacement, ...]


def elaborate_instance(env: Env, name: str, decl: t.Instance, doc: str) -> Machine:
    """The automaton that an instance is."""
    base = base_of(env, decl.base)
    given = tuple(Replacement(_replacement(env, base, b), env) for b in decl.bindings)
    kept = tuple(g for g in base.given if _name(g.item) not in {_name(n.item) for n in given})
    names = {_name(g.item) for g in (*kept, *given)}
    items = (*kept, *given, *(Replacement(i, None) for i in _dependents(base, names)))
    machine = elaborate_automaton(base.env, name, base.decl.members, doc, decl.name_span, items)
    machine.base = Base(base.decl, base.env, (*kept, *given))
    return machine


def base_of(env: Env, node: t.Expr) -> Base:
    """The automaton that a path names."""
    symbol = denote(env, node)
    if not isinstance(symbol, Symbol) or symbol.kind != "automaton" or symbol.payload.base is None:
        env.ctx.fail("HA105", "an automaton is needed here", node.span)
    found: Base = symbol.payload.base
    return found


def _name(item: t.Item) -> str:
    body: Any = item.body
    return str(body.declared.name)


def _replacement(env: Env, base: Base, binding: t.Binding) -> t.Item:
    """The declaration that a binding puts in place of the one it names."""
    old = _declaration(base, binding.name)
    if old is None:
        known = list(_declarations(base))
        env.ctx.unknown("constant, param or input", binding.name, base.decl.name, binding.span, known)
    declared = t.Declared(binding.name, None, None, binding.span)
    body: t.Decl
    if binding.is_set:
        if isinstance(old, t.Const):
            env.ctx.fail("HA105", f"'{binding.name}' is a constant: bind it with '='", binding.span)
        default = None
        body = t.Param(declared, old.type, binding.value, default, binding.span)
        if isinstance(old, t.Input):
            body = t.Input(declared, old.type, binding.value, old.rate, old.every, binding.span)
    elif isinstance(old, t.Input):
        body = t.Let(declared, old.type, binding.value, binding.span)
    else:
        body = t.Const(declared, old.type, binding.value, binding.span)
    return t.Item((), (), body, binding.span)


def _declarations(base: Base) -> dict[str, t.Const | t.Param | t.Input]:
    found: dict[str, t.Const | t.Param | t.Input] = {}
    for item in (*_top_level(base.env), *base.decl.members):
        if isinstance(item.body, t.Const | t.Param | t.Input):
            found[item.body.declared.name] = item.body
    return found


def _declaration(base: Base, name: str) -> t.Const | t.Param | t.Input | None:
    return _declarations(base).get(name)


def _top_level(env: Env) -> Sequence[t.Item]:
    return env.scope.items


def _dependents(base: Base, names: set[str]) -> Iterator[t.Item]:
    """Top-level constants computed from rebound ones: computed anew in the instance."""
    changed = set(names)
    own = {_name(i) for i in base.decl.members if isinstance(i.body, t.Const | t.Param | t.Input)}
    for _ in range(len(_top_level(base.env))):
        more = [i for i in _top_level(base.env) if _depends(i, changed) and _name(i) not in changed | own]
        if not more:
            return
        changed.update(_name(i) for i in more)
        yield from more


def _depends(item: t.Item, names: set[str]) -> bool:
    return isinstance(item.body, t.Const) and any(n in names for n in mentioned(item.body.value))


def mentioned(node: object) -> Iterator[str]:
    """The bare names in an expression."""
    stack = [node]
    while stack:
        at = stack.pop()
        if isinstance(at, t.Name):
            yield at.id
        elif isinstance(at, tuple):
            stack.extend(at)
        elif hasattr(at, "__slots__") and type(at).__module__ == t.__name__:
            stack.extend(getattr(at, s) for s in at.__slots__)
