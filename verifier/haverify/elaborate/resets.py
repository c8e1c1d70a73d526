"""Assignments of edges and starts: families written out, right sides in the unit of the variable."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from haverify.diagnostics.diagnostic import Label
from haverify.elaborate.expressions import Env, family_enum, index_value, of_type, range_in
from haverify.elaborate.scope import Members, Symbol
from haverify.model.hybrid import Assign
from haverify.syntax import tree as t


def resets(env: Env, assignments: Sequence[t.Assignment]) -> tuple[Assign, ...]:
    """The assignments in order; two to one variable are HA004."""
    found: dict[str, Assign] = {}
    for a in assignments:
        for place in placed(env, a.family):
            assign = _assign(place, a)
            if assign.var in found:
                first = found[assign.var].span
                labels = (Label(first, "first assigned here"),) if first else ()
                env.ctx.fail("HA004", f"'{assign.var}' is assigned twice in one jump", a.span, labels=labels)
            found[assign.var] = assign
    return tuple(found.values())


def placed(env: Env, family: t.Family | None) -> Iterator[Env]:
    """`env` once, or for each value of a family."""
    if family is None:
        yield env
        return
    enum = family_enum(env, family.of)
    for value in enum.values:
        yield env.bind(**{family.name: env.ctx.value(enum, value)})


def _assign(env: Env, a: t.Assignment) -> Assign:
    symbol = state_variable(env, a.target, "assign to")
    what = f"variable {symbol.name}"
    if a.is_set:
        if not env.ctx.is_number(symbol.type):
            env.ctx.fail("HA105", f"{what} is no number; assign one value with ':='", a.span)
        return Assign(symbol.name, range_in(env, a.value, symbol.unit, what), a.span)
    return Assign(symbol.name, of_type(env, a.value, symbol.type, symbol.unit, what), a.span)


def state_variable(env: Env, target: t.Target, doing: str) -> Symbol:
    """The variable that a target names."""
    symbol = env.scope.lookup(target.name)
    if symbol is None:
        machine = env.scope.machine()
        known = [n for n, s in (machine.names if machine else {}).items() if s.kind in ("var", "family")]
        env.ctx.unknown("variable", target.name, env.scope.label, target.span, known)
    if symbol.kind == "family":
        symbol = _member(env, symbol, target)
    elif target.index is not None:
        env.ctx.fail("HA105", f"'{target.name}' takes no index", target.span)
    used = symbol.used
    symbol = env.ctx.use(symbol, target.span)
    symbol.used = used
    if symbol.kind != "var":
        env.ctx.fail("HA105", f"cannot {doing} '{target.name}': it is no variable of {env.scope.label}", target.span)
    return symbol


def _member(env: Env, symbol: Symbol, target: t.Target) -> Symbol:
    members: Members = symbol.payload
    if target.index is None:
        env.ctx.fail("HA105", f"'{target.name}' is a family: write an index", target.span)
    value = index_value(env, target.index, members.enum, target.name)
    if not isinstance(value, str) or value not in members.by_value:
        env.ctx.fail("HA009", f"'{target.name}': the index must be a known value of {members.enum.name}", target.span)
    return members.by_value[value]


def bound_text(env: Env, name: str) -> str:
    """The value of an enumeration that a local name stands for, as text."""
    return str(env.scope.names[name].payload.expr.args[-1])
