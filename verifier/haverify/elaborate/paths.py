"""Modes and edges named by paths: `LR`, `Run[LR]`, `left.LR`, `begin[lhip]`."""

from __future__ import annotations

from haverify.elaborate.expressions import Env, denote, index_value, source_name
from haverify.elaborate.scope import Members, Scope, Symbol
from haverify.syntax import tree as t


def modes_at(env: Env, node: t.Expr) -> list[str]:
    """The modes that a path in `at(...)` names; the name of a mode family names all of its modes."""
    return [s.name for s in _resolve(env, node, "modes")]


def edges_at(env: Env, node: t.Expr) -> list[str]:
    """The edges or interactions that a path names; an index left out means all."""
    return [s.name for s in _resolve(env, node, "edges")]


def _resolve(env: Env, node: t.Expr, space: str) -> list[Symbol]:
    while type(node) is t.Paren:
        node = node.inner
    if isinstance(node, t.Index):
        return _indexed(env, node, space)
    scope, name = _scope_of(env, node, space)
    found: Symbol | None = getattr(scope, space).get(name)
    if found is None:
        known = getattr(scope, space)
        env.ctx.unknown(space[:-1], name, scope.label, node.span, known)
    found.used = True
    return list(found.payload.by_value.values()) if found.kind == "family" else [found]


def _indexed(env: Env, node: t.Index, space: str) -> list[Symbol]:
    scope, name = _scope_of(env, node.base, space)
    found: Symbol | None = getattr(scope, space).get(name)
    if found is None or found.kind != "family":
        env.ctx.unknown(f"family of {space}", name, scope.label, node.span, getattr(scope, space))
    members: Members = found.payload
    value = index_value(env, node.index, members.enum, source_name(node.base))
    if not isinstance(value, str) or value not in members.by_value:
        env.ctx.fail("HA009", f"'{source_name(node)}': the index must be a value of {members.enum.name}", node.span)
    found.used = True
    return [members.by_value[value]]


def _scope_of(env: Env, node: t.Expr, space: str) -> tuple[Scope, str]:
    if isinstance(node, t.Name):
        scope = env.scope.machine()
        if scope is None:
            env.ctx.fail("HA105", f"'{node.id}': {space} belong to an automaton; write `on` one", node.span)
        bound = env.scope.local(node.id)
        return scope, node.id if bound is None else str(bound.payload.expr.args[-1])
    if isinstance(node, t.Member):
        base = denote(env, node.base)
        inner = getattr(getattr(base, "payload", None), "scope", None)
        if isinstance(inner, Scope):
            return inner, node.name
    return env.ctx.fail("HA105", f"'{source_name(node)}' does not name one of the {space}", node.span)


def target_mode(env: Env, target: t.Target) -> list[Symbol]:
    """The modes that `-> Mode`, `init Mode` or `in Mode` names."""
    name = t.Name(target.name, target.span)
    return _resolve(env, name if target.index is None else t.Index(name, target.index, target.span), "modes")
