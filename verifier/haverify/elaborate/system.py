"""Systems: parts side by side, their ports bound, their edges joined by syncs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from haverify.elaborate.automaton import Machine, declare_member, priorities_of
from haverify.elaborate.context import Context, Lost
from haverify.elaborate.declare import Entries, enum_with
from haverify.elaborate.expressions import Env, boolean, denote, family_enum, of_type, range_in, source_name
from haverify.elaborate.loops import port_loops
from haverify.elaborate.naming import own_names
from haverify.elaborate.outputs import enter_lets
from haverify.elaborate.paths import edges_at
from haverify.elaborate.prefixed import prefixed_scope
from haverify.elaborate.resets import bound_text, placed, resets, state_variable
from haverify.elaborate.scope import Members, Scope, Symbol
from haverify.model.expression import TRUE, Expr
from haverify.model.hybrid import Constant, Init, Input, Output, Param, Priority, Variable
from haverify.model.system import Binding, Part, Sync, System
from haverify.model.unit import SECOND
from haverify.syntax import tree as t
from haverify.text.record import field, holder, replace
from haverify.text.span import Span


@holder
class PartScope:
    """A part: the names of its automaton under its own."""

    scope: Scope
    machine: Machine
    decl: t.Part
    place: Env
    name: str


@holder
class _Work:
    env: Env
    entries: Entries
    lets: Entries
    items: Sequence[t.Item]
    parts: list[PartScope] = field(default_factory=list)
    is_good: bool = True

    @property
    def ctx(self) -> Context:
        return self.env.ctx

    def bodies(self, kind: Any) -> Iterator[Any]:
        """The members of one kind."""
        return (i.body for i in self.items if isinstance(i.body, kind))


def elaborate_system(env: Env, name: str, decl: t.System, doc: str) -> Machine:
    """The system that a declaration describes."""
    scope = Scope(f"system {name}", env.scope, is_machine=True)
    inner = replace(env, scope=scope)
    items = decl.members or tuple(_written_out(decl))
    name_of = own_names(env.ctx, name)
    work = _Work(inner, Entries(inner, name_of), Entries(inner, name_of), items)
    machine = Machine(name, scope, invariants=[i for i in items if isinstance(i.body, t.Invariant)])
    for item in items:
        _guarded(work, lambda item=item: declare_member(work.entries, item))
    for part in work.bodies(t.Part):
        _guarded(work, lambda part=part: _enter_part(work, part))
    _guarded(work, lambda: enter_lets(work.lets, items, ()))
    for sync in work.bodies(t.Sync):
        _guarded(work, lambda sync=sync: _enter_sync(work, sync))
    machine.model = _model(work, name, doc, decl.name_span)
    return machine


def _written_out(decl: t.System) -> Iterator[t.Item]:
    """`A || B sync e` as parts A and B and `sync e: A.e, B.e`."""
    names = [source_name(p).split(".")[-1] for p in decl.parts]
    for name, base in zip(names, decl.parts, strict=True):
        yield t.Item((), (), t.Part(t.Declared(name, None, None, base.span), base, (), base.span), base.span)
    for sync in decl.syncs:
        paths = tuple(t.Member(t.Name(n, decl.span), sync, decl.span) for n in names)
        declared = t.Declared(sync, None, None, decl.span)
        yield t.Item((), (), t.Sync(declared, paths, (), None, (), decl.span), decl.span)


def _guarded(work: _Work, act: Any) -> Any:
    try:
        return act()
    except Lost:
        work.is_good = False
        return None


def _define(work: _Work, table: dict[str, Symbol], name: str, symbol: Symbol, what: str) -> None:
    if not work.ctx.define(table, name, symbol, what):
        work.is_good = False


# ---- parts ----------------------------------------------------------------------


def _enter_part(work: _Work, decl: t.Part) -> None:
    outside = replace(work.env, scope=work.env.scope.parent or work.env.scope)
    symbol = denote(outside, decl.base)
    if not isinstance(symbol, Symbol) or symbol.kind not in ("automaton", "system"):
        work.ctx.fail("HA105", f"'{source_name(decl.base)}' is no automaton", decl.base.span)
    machine: Machine = symbol.payload
    head = decl.declared
    names = work.env.scope.names
    if head.family is None and head.index is None:
        _define(work, names, head.name, _part(work, decl, machine, head.name, work.env), "part")
        return
    enum = family_enum(work.env, head.family.of) if head.family else enum_with(work.env, head, names)
    members = _family(work, head, enum)
    places = list(placed(work.env, head.family))
    for value, place in zip(enum.values if head.family else (str(head.index),), places, strict=True):
        members.by_value[value] = _part(work, decl, machine, f"{head.name}[{value}]", place)


def _family(work: _Work, head: t.Declared, enum: Any) -> Members:
    old = work.env.scope.names.get(head.name)
    if old is not None and old.kind == "family" and head.index is not None:
        known: Members = old.payload
        return known
    members = Members(enum)
    work.ctx.define(work.env.scope.names, head.name, Symbol("family", head.name, head.span, payload=members), "part")
    return members


def _part(work: _Work, decl: t.Part, machine: Machine, name: str, place: Env) -> Symbol:
    found = PartScope(prefixed_scope(machine.scope, name), machine, decl, place, name)
    work.parts.append(found)
    return Symbol("part", name, decl.span, payload=found, used=True)


def _bindings(work: _Work, part: PartScope) -> tuple[Binding, ...]:
    found = []
    for b in part.decl.bindings:
        made = _guarded(work, lambda b=b: _binding(work, part, b))
        if made is not None:
            found.append(made)
    bound = {b.name for b in part.decl.bindings}
    written = {s.name: n for n, s in part.machine.scope.names.items()}
    for port in part.machine.model.inputs:
        name = written.get(port.name, port.name)
        if port.range is None and name not in bound and not isinstance(part.machine.model, System):
            work.ctx.report("HA105", f"port '{name}' of part {part.name} is bound to nothing", part.decl.span)
            work.is_good = False
    return tuple(found)


def _binding(work: _Work, part: PartScope, b: t.Binding) -> Binding:
    target = part.machine.scope.lookup(b.name)
    if target is None or target.kind not in ("const", "param", "input", "set"):
        known = [n for n, s in part.scope.names.items() if s.kind in ("const", "param", "input")]
        work.ctx.unknown("constant, param or input", b.name, part.machine.name, b.span, known)
    work.ctx.use(target, b.span)
    what = f"'{b.name}' of {part.machine.name}"
    if b.is_set:
        return Binding(target.name, range_in(part.place, b.value, target.unit, what), b.span)
    return Binding(target.name, of_type(part.place, b.value, target.type, target.unit, what), b.span)


# ---- syncs, flow, start ---------------------------------------------------------


def _enter_sync(work: _Work, sync: t.Sync) -> None:
    head, table = sync.declared, work.env.scope.edges
    if head.family is None and head.index is None:
        _define(work, table, head.name, Symbol("edge", head.name, head.span, used=True), "sync")
        return
    enum = family_enum(work.env, head.family.of) if head.family else enum_with(work.env, head, table)
    symbol = table.setdefault(head.name, Symbol("family", head.name, head.span, payload=Members(enum), used=True))
    for value in enum.values if head.family else (str(head.index),):
        made = Symbol("edge", f"{head.name}[{value}]", head.span, used=True)
        _define(work, symbol.payload.by_value, value, made, "sync")


def _syncs(work: _Work) -> Iterator[Sync]:
    for sync in work.bodies(t.Sync):
        head = sync.declared
        for place in _guarded(work, lambda head=head: list(placed(work.env, head.family))) or ():
            value = head.index or ""
            if head.family is not None:
                value = bound_text(place, head.family.name)
            name = f"{head.name}[{value}]" if value else head.name
            made = _guarded(work, lambda sync=sync, place=place, name=name: _sync(place, sync, name))
            if made is not None:
                yield made


def _sync(env: Env, sync: t.Sync, name: str) -> Sync:
    edges = tuple(_one_edge(env, p) for p in sync.paths)
    listeners = tuple(_one_edge(env, p) for p in sync.listeners)
    guard = boolean(env, sync.guard) if sync.guard else TRUE
    return Sync(name, edges, listeners, guard, resets(env, sync.assignments), bool(listeners), sync.span)


def _one_edge(env: Env, path: t.Expr) -> str:
    found = edges_at(env, path)
    if len(found) != 1:
        env.ctx.fail("HA105", f"'{source_name(path)}' names {len(found)} edges: write an index", path.span)
    return found[0]


def _flow(work: _Work) -> Iterator[tuple[str, Expr]]:
    for flow in work.bodies(t.Flow):
        for line in flow.lines:
            for place in placed(work.env, line.family):
                made = _guarded(work, lambda line=line, place=place: _flow_line(place, line))
                if made is not None:
                    yield made


def _flow_line(env: Env, line: t.Derivative) -> tuple[str, Expr]:
    symbol = state_variable(env, line.target, "give a flow for")
    unit = symbol.unit / SECOND if symbol.unit is not None else None
    if line.is_set:
        env.ctx.fail("HA105", "a system's own variables take no inclusion", line.span)
    return symbol.name, of_type(env, line.value, "real", unit, f"the flow of {symbol.name}", "HA103")


def _check_flow(work: _Work, given: set[str]) -> None:
    missing = [v for v in work.entries.of(Variable) if v.type == "real" and v.name not in given]
    if missing and work.is_good:
        names = ", ".join(f"'{v.name}'" for v in missing)
        work.ctx.report("HA007", f"{work.env.scope.label} gives no flow for {names}", missing[0].span)
        work.is_good = False


def _starts(work: _Work) -> Iterator[Init]:
    for init in work.bodies(t.Init):
        made = _guarded(work, lambda init=init: _init(work.env, init))
        if made is not None:
            yield made


def _init(env: Env, init: t.Init) -> Init:
    if init.mode is not None:
        env.ctx.fail("HA105", "a system has no modes of its own", init.mode.span)
    where = boolean(env, init.where) if init.where else TRUE
    return Init(None, where, resets(env, init.assignments), init.span)


def _priorities(work: _Work) -> Iterator[Priority]:
    for priority in work.bodies(t.Priority):
        yield from _guarded(work, lambda priority=priority: list(priorities_of(work.env, priority))) or ()


def _model(work: _Work, name: str, doc: str, span: Span) -> System | None:
    work.is_good = work.entries.settle() and work.is_good
    work.lets.settle()
    parts = tuple(Part(p.name, p.machine.name, _bindings(work, p), p.decl.span) for p in work.parts)
    syncs, flow, starts = tuple(_syncs(work)), tuple(_flow(work)), tuple(_starts(work))
    priorities = tuple(_priorities(work))
    _check_flow(work, {v for v, _ in flow})
    if work.is_good and port_loops(work.ctx, parts, {p.name: p.machine.model for p in work.parts}):
        work.is_good = False
    if not work.is_good:
        return None
    of = work.entries.of
    return System(
        name, of(Constant), of(Param), of(Input), of(Variable), work.lets.of(Output), starts, parts, syncs, priorities,
        flow, doc, span,
    )  # fmt: skip
