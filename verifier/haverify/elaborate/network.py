"""Neural networks from files: their inputs and outputs with units."""

from __future__ import annotations

from collections.abc import Iterator

from haverify.diagnostics.diagnostic import Edit, Fix
from haverify.elaborate.calls import declared_type
from haverify.elaborate.context import Lost
from haverify.elaborate.csv import shown_path
from haverify.elaborate.declare import Entries
from haverify.elaborate.expressions import Env, family_enum
from haverify.elaborate.scope import Scope, Symbol
from haverify.model.tables import Network
from haverify.model.unit import Unit
from haverify.syntax import tree as t
from haverify.text.record import holder

Port = tuple[str, Unit | None]


@holder
class NetworkScope:
    """A network in scope: `scope` for `N.output(...)`, `claim_scope` for claims on it."""

    scope: Scope
    claim_scope: Scope


def enter_network(entries: Entries, decl: t.Network, path: str) -> None:
    """Enter a network."""
    env = entries.env
    symbol = Symbol("network", entries.name_of(decl.name), decl.span, state="pending")

    def make() -> None:
        entries.models[symbol] = _network(env, symbol, decl, path)

    symbol.make = make
    if env.ctx.define(env.scope.names, decl.name, symbol, "network"):
        entries.symbols.append(symbol)


def _network(env: Env, symbol: Symbol, decl: t.Network, path: str) -> Network:
    source = env.ctx.files.data.get((path, decl.path))
    if source is None:
        raise Lost
    digest = None
    for line in decl.lines:
        if line.kind == "sha256":
            digest = line.text
            if digest != source.sha256:
                fix = Fix("update the hash", (Edit(line.span, f'sha256 "{source.sha256}"'),), safe=True)
                env.ctx.report("HA215", f"{decl.path} does not match its sha256", line.span, fix=fix)
    inputs, outputs = tuple(_ports(env, decl, "input")), tuple(_ports(env, decl, "output"))
    network = Network(symbol.name, shown_path(env.ctx, source, decl.path), digest, inputs, outputs, decl.span)
    symbol.payload = _scoped(env, network)
    return network


def _ports(env: Env, decl: t.Network, kind: str) -> Iterator[Port]:
    for line in decl.lines:
        if line.kind != kind or line.declared is None:
            continue
        unit = declared_type(env, line.type)[1] if line.type else env.ctx.one
        if line.declared.family is None:
            yield (
                line.declared.name if line.declared.index is None else f"{line.declared.name}[{line.declared.index}]",
                unit,
            )
            continue
        for value in family_enum(env, line.declared.family.of).values:
            yield f"{line.declared.name}[{value}]", unit


def _scoped(env: Env, network: Network) -> NetworkScope:
    inner = Scope(f"network {network.name}", env.scope)
    claims = Scope(f"network {network.name}", env.scope, is_machine=True)
    for name, unit in network.inputs:
        claims.names[name] = Symbol("netinput", name, unit=unit, payload=(network.name, name), used=True)
    for name, unit in network.outputs:
        claims.names[name] = Symbol("netoutput", name, unit=unit, payload=(network.name, name), used=True)
        inner.names[name] = Symbol("net", name, unit=unit, payload=network, used=True)
    return NetworkScope(inner, claims)
