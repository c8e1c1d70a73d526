"""The names of an automaton as its part in a system has them: `part.x`."""

from __future__ import annotations

from haverify.elaborate.scope import Members, Scope, Symbol
from haverify.text.record import holder

_KINDS = ("const", "param", "input", "var", "let", "set", "mode", "edge")


@holder
class Inner:
    """A part of a part."""

    scope: Scope


def prefixed_scope(scope: Scope, prefix: str) -> Scope:
    """The names, modes and edges of `scope`, each under `prefix`."""
    made = Scope(f"part {prefix}")
    for target, source in ((made.names, scope.names), (made.modes, scope.modes), (made.edges, scope.edges)):
        for name, symbol in source.items():
            copy = _prefixed(symbol, prefix)
            if copy is not None:
                target[name] = copy
    return made


def _prefixed(symbol: Symbol, prefix: str) -> Symbol | None:
    name = f"{prefix}.{symbol.name}"
    if symbol.kind in _KINDS:
        return Symbol(
            symbol.kind, name, symbol.span, symbol.type, symbol.unit, symbol.payload, None, symbol.state, True
        )
    if symbol.kind == "family":
        members: Members = symbol.payload
        copies = {v: _prefixed(s, prefix) for v, s in members.by_value.items()}
        inner = Members(members.enum, {v: s for v, s in copies.items() if s is not None})
        return Symbol("family", name, symbol.span, payload=inner)
    if symbol.kind == "part":
        return Symbol("part", name, symbol.span, payload=Inner(prefixed_scope(symbol.payload.scope, prefix)))
    return None
