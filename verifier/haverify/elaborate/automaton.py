"""An automaton: its modes and edges written out, defaults filled in, schedules and samples expanded."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any

from haverify.elaborate import arithmetic as A
from haverify.elaborate.context import Context, Lost, NeedsMode
from haverify.elaborate.declare import Entries, constant, declare, enum_with, function, input_, param, variable
from haverify.elaborate.definedness import check_automaton, missing_outputs
from haverify.elaborate.expressions import Env, boolean, family_enum, of_type, range_in
from haverify.elaborate.naming import own_names
from haverify.elaborate.outputs import ModeScope, bound_output, enter_lets
from haverify.elaborate.paths import edges_at, target_mode
from haverify.elaborate.resets import placed, resets, state_variable
from haverify.elaborate.sample import Clock, clock_of, sample_edge
from haverify.elaborate.schedule import Slot, edge_name, slots
from haverify.elaborate.scope import Members, Scope, Symbol
from haverify.model.expression import TRUE, Expr
from haverify.model.hybrid import (
    Constant,
    Edge,
    FlowLine,
    HybridAutomaton,
    Init,
    Input,
    Mode,
    Output,
    Param,
    Priority,
    Variable,
)
from haverify.model.unit import SECOND
from haverify.syntax import tree as t
from haverify.text.record import field, holder, record, replace


@holder
class Machine:
    """An automaton or system with its scope; `model` is None when it has errors."""

    name: str
    scope: Scope
    modes: list[ModeScope] = field(default_factory=list)
    model: Any = None
    invariants: list[t.Item] = field(default_factory=list)
    base: Any = None
    missing: dict[str, frozenset[str]] = field(default_factory=dict)


@record
class Replacement:
    """A declaration of an instance; its right side stands in `env`, or in the automaton itself."""

    item: t.Item
    env: Env | None


Given = Sequence[Replacement]


@holder
class _Work:
    """One automaton being elaborated; `is_good` until an element has an error."""

    machine: Machine
    env: Env
    entries: Entries
    lets: Entries
    items: Sequence[t.Item]
    clocks: list[Clock] = field(default_factory=list)
    slots: list[Slot] = field(default_factory=list)
    is_good: bool = True
    has_flows: bool = True

    @property
    def ctx(self) -> Context:
        return self.env.ctx

    def bodies(self, kind: Any) -> Iterator[Any]:
        """The members of one kind."""
        return (i.body for i in self.items if isinstance(i.body, kind))


def elaborate_automaton(
    env: Env, name: str, items: Sequence[t.Item], doc: str, span: Any, given: Given = ()
) -> Machine:
    """The automaton `name`; `given` are declarations that replace those of the same name, with where they stand."""
    scope = Scope(f"automaton {name}", env.scope, is_machine=True)
    machine = Machine(name, scope)
    inner = replace(env, scope=scope)
    name_of = own_names(env.ctx, name)
    work = _Work(machine, inner, Entries(inner, name_of), Entries(inner, name_of), items)
    try:
        _enter_given(work, given)
        replaced = {_declared_name(g.item) for g in given}
        _declare_all(work, [i for i in items if _declared_name(i) not in replaced or isinstance(i.body, t.Let)])
    except Lost:
        work.is_good = False
    machine.invariants = [i for i in items if isinstance(i.body, t.Invariant)]
    machine.model = _model(work, doc, span)
    return machine


def _declared_name(item: t.Item) -> str | None:
    return item.body.declared.name if isinstance(item.body, t.Const | t.Param | t.Input | t.Let) else None


def _enter_given(work: _Work, given: Given) -> None:
    """Enter what an instance rebinds; a constant that only depends on such is kept where the automaton reads it."""
    for g in given:
        body = g.item.body
        if isinstance(body, t.Let):
            bound_output(work.lets, body, g.env)
            continue
        entries = replace(work.entries, env=work.env, place=g.env)
        before = len(entries.symbols)
        declare_member(entries, g.item)
        if g.env is None:
            work.entries.optional.update(entries.symbols[before:])


def _declare_all(work: _Work, items: Sequence[t.Item]) -> None:
    for item in items:
        _guarded(work, lambda item=item: declare_member(work.entries, item))
    for sample in work.bodies(t.Sample):
        _guarded(work, lambda sample=sample: work.clocks.append(clock_of(work.entries, sample)))
    for item in items:
        if isinstance(item.body, t.Mode):
            _guarded(work, lambda item=item: _enter_mode(work, item.body))
    _name_modes(work)
    enter_lets(work.lets, items, work.machine.modes)
    _enter_edges(work, items)


def _guarded(work: _Work, act: Any) -> Any:
    """The result of `act`; an error in it makes the automaton one without meaning."""
    try:
        return act()
    except Lost:
        work.is_good = False
        return None
    except NeedsMode as need:
        work.is_good = False
        name = need.symbol.name
        work.ctx.report("HA002", f"'{name}' has a value only inside a mode of its family", need.symbol.span)
        return None


def declare_member(entries: Entries, item: t.Item) -> None:
    """Enter a constant, param, input, variable or function."""
    body = item.body
    if isinstance(body, t.Const):
        declare(entries, body.declared, "const", constant(item, body))
    elif isinstance(body, t.Param):
        declare(entries, body.declared, "param", param(body))
    elif isinstance(body, t.Input):
        declare(entries, body.declared, "input", input_(body))
    elif isinstance(body, t.Function):
        function(entries, body)
    elif isinstance(body, t.Var):
        for name in body.names:
            declare(entries, name, "var", variable(body))


# ---- modes ----------------------------------------------------------------------


def _enter_mode(work: _Work, decl: t.Mode) -> None:
    head, scope = decl.declared, work.machine.scope
    if head.family is None and head.index is None:
        symbol = Symbol("mode", head.name, head.span)
        if work.ctx.define(scope.modes, head.name, symbol, "mode"):
            work.machine.modes.append(
                ModeScope(head.name, decl, Scope(scope.label, scope, is_local=True), span=head.span)
            )
        else:
            work.is_good = False
        return
    enum = family_enum(work.env, head.family.of) if head.family else enum_with(work.env, head, scope.modes)
    members = _mode_family(work, head, enum)
    for value in enum.values if head.family else (str(head.index),):
        local = Scope(scope.label, scope, is_local=True)
        if head.family is not None:
            local = scope.bind({head.family.name: work.ctx.value(enum, value)})
            _enter_parameter(work, head.family, enum)
        mode = ModeScope(
            f"{head.name}[{value}]", decl, local, head.family.name if head.family else None, span=head.span
        )
        members.by_value[value] = Symbol("mode", mode.name, head.span)
        work.machine.modes.append(mode)


def _mode_family(work: _Work, head: t.Declared, enum: Any) -> Members:
    old = work.machine.scope.modes.get(head.name)
    if old is not None and old.kind == "family" and head.index is not None and head.index not in old.payload.by_value:
        members: Members = old.payload
        return members
    members = Members(enum)
    symbol = Symbol("family", head.name, head.span, payload=members)
    if not work.ctx.define(work.machine.scope.modes, head.name, symbol, "mode"):
        raise Lost
    return members


def _enter_parameter(work: _Work, family: t.Family, enum: Any) -> None:
    names = work.machine.scope.names
    if family.name not in names:
        names[family.name] = Symbol("modeparam", family.name, family.span, type=enum.name, payload=enum)


def _name_modes(work: _Work) -> None:
    """Call a mode of a family by its value alone where no other mode has that name."""
    scope = work.machine.scope
    short: dict[str, list[ModeScope]] = {}
    for mode in work.machine.modes:
        short.setdefault(_short(mode.name), []).append(mode)
    for name, modes in short.items():
        if len(modes) == 1 and modes[0].name != name:
            family, value = modes[0].name[:-1].split("[", 1)
            symbol = scope.modes[family].payload.by_value[value]
            if name not in scope.modes:
                scope.modes[name] = symbol
                if name[0].isalpha() or name[0] == "_":
                    modes[0].name = symbol.name = name


def _short(name: str) -> str:
    return name[:-1].split("[", 1)[1] if name.endswith("]") else name


# ---- edges ----------------------------------------------------------------------


def _enter_edges(work: _Work, items: Sequence[t.Item]) -> None:
    """Enter all edge names; several modes may share one."""
    for slot in _guarded(work, lambda: _all_slots(work)) or ():
        work.slots.append(slot)
        if slot.edge is not None:
            work.machine.scope.edges.setdefault(slot.edge.name, Symbol("edge", slot.edge.name, slot.edge.span))
    heads = [e.declared for e in work.bodies(t.Edge) if e.declared]
    heads += [
        i.body.declared
        for m in work.bodies(t.Mode)
        for i in m.members
        if isinstance(i.body, t.Edge) and i.body.declared
    ]
    for head in heads:
        _guarded(work, lambda head=head: _enter_edge(work, head))
    for clock in work.clocks:
        work.machine.scope.edges.setdefault(clock.name, Symbol("edge", clock.name, clock.span))


def _all_slots(work: _Work) -> list[Slot]:
    return [slot for schedule in work.bodies(t.Schedule) for slot in slots(work.env, schedule)]


def _enter_edge(work: _Work, head: t.Declared) -> None:
    table = work.machine.scope.edges
    if head.family is None and head.index is None:
        table.setdefault(head.name, Symbol("edge", head.name, head.span))
        return
    enum = family_enum(work.env, head.family.of) if head.family else enum_with(work.env, head, table)
    symbol = table.setdefault(head.name, Symbol("family", head.name, head.span, payload=Members(enum)))
    for value in enum.values if head.family else (str(head.index),):
        symbol.payload.by_value.setdefault(value, Symbol("edge", f"{head.name}[{value}]", head.span))


def _edges(work: _Work) -> Iterator[Edge]:
    """All edges in the order of the text; samples come last."""
    schedules = list(work.bodies(t.Schedule))
    for item in work.items:
        body = item.body
        if isinstance(body, t.Mode):
            for mode in [m for m in work.machine.modes if m.decl is body]:
                for inner in body.members:
                    if isinstance(inner.body, t.Edge):
                        yield from _guarded(work, lambda: list(_edge(work, inner.body, mode))) or ()  # noqa: B023
        elif isinstance(body, t.Edge):
            yield from _guarded(work, lambda: list(_outer_edge(work, body))) or ()  # noqa: B023
        elif isinstance(body, t.Schedule) and body is schedules[0]:
            yield from (s.edge for s in work.slots if s.edge is not None)
    for clock in work.clocks:
        for mode in work.machine.modes:
            made = _guarded(work, lambda: sample_edge(_in_mode(work, mode), clock, mode.name))  # noqa: B023
            if made is not None:
                yield made


def _outer_edge(work: _Work, edge: t.Edge) -> Iterator[Edge]:
    if edge.source is None:
        work.ctx.fail("HA002", "an edge outside a mode needs a source: `A -> B`", edge.span)
    for symbol in target_mode(work.env, edge.source):
        mode = next(m for m in work.machine.modes if m.name == symbol.name)
        yield from _edge(work, edge, mode)


def _edge(work: _Work, edge: t.Edge, mode: ModeScope) -> Iterator[Edge]:
    family = edge.declared.family if edge.declared else None
    env = _in_mode(work, mode)
    values = family_enum(env, family.of).values if family else ("",)
    for value, place in zip(values, placed(env, family), strict=True):
        targets = target_mode(place, edge.target)
        if len(targets) != 1:
            work.ctx.fail("HA105", f"'{edge.target.name}' is a family of modes: write an index", edge.target.span)
        name = _edge_label(edge, value) or edge_name(mode.name, targets[0].name)
        guard = boolean(place, edge.guard) if edge.guard else TRUE
        yield Edge(name, mode.name, targets[0].name, edge.urgent, guard, resets(place, edge.assignments), edge.span)


def _edge_label(edge: t.Edge, value: str) -> str:
    if edge.declared is None:
        return ""
    value = value or edge.declared.index or ""
    return f"{edge.declared.name}[{value}]" if value else edge.declared.name


def _in_mode(work: _Work, mode: ModeScope) -> Env:
    return replace(work.env, scope=mode.scope)


# ---- flows and domains ----------------------------------------------------------


def _flow_lines(env: Env, flow: t.Flow) -> dict[str, FlowLine]:
    found: dict[str, FlowLine] = {}
    for line in flow.lines:
        for place in placed(env, line.family):
            made = _flow_line(place, line)
            if made.var in found:
                env.ctx.fail("HA004", f"the flow of '{made.var}' is given twice", line.span)
            found[made.var] = made
    return found


def _flow_line(env: Env, line: t.Derivative) -> FlowLine:
    symbol = state_variable(env, line.target, "give a flow for")
    if symbol.type != "real":
        env.ctx.fail("HA105", f"'{symbol.name}' is discrete: it changes in jumps only and takes no flow", line.span)
    unit = symbol.unit / SECOND if symbol.unit is not None else None
    what = f"the flow of {symbol.name}"
    if line.is_set:
        return FlowLine(symbol.name, range_in(env, line.value, unit, what), line.span)
    return FlowLine(symbol.name, of_type(env, line.value, "real", unit, what, "HA103"), line.span)


class _Defaults:
    """The automaton's own flow lines: elaborated once where they do not depend on the mode."""

    def __init__(self, work: _Work) -> None:
        self.work = work
        self.shared: dict[int, dict[str, FlowLine]] = {}

    def of(self, mode: ModeScope) -> dict[str, FlowLine]:
        """The lines for a mode."""
        found: dict[str, FlowLine] = {}
        for flow in self.work.bodies(t.Flow):
            for line in flow.lines:
                found.update(self._line(line, mode))
        return found

    def _line(self, line: t.Derivative, mode: ModeScope) -> dict[str, FlowLine]:
        if id(line) in self.shared:
            return self.shared[id(line)]
        single = t.Flow((line,), line.span)
        try:
            found = _flow_lines(self.work.env, single)
        except NeedsMode:
            return _flow_lines(_in_mode(self.work, mode), single)
        except Lost:
            self.shared[id(line)] = {}
            self.work.is_good = False
            return {}
        self.shared[id(line)] = found
        return found


def _mode(work: _Work, mode: ModeScope, defaults: _Defaults, variables: Sequence[Variable]) -> Mode:
    env = _in_mode(work, mode)
    own: dict[str, FlowLine] = {}
    domain: list[Expr] = []
    for item in mode.decl.members:
        body = item.body
        if isinstance(body, t.Domain):
            domain.append(_guarded(work, lambda: boolean(env, body.condition)) or TRUE)  # noqa: B023
        elif isinstance(body, t.Flow):
            for var, line in (_guarded(work, lambda: _flow_lines(env, body)) or {}).items():  # noqa: B023
                if var in own:
                    work.ctx.report("HA004", f"mode {mode.name} gives the flow of '{var}' twice", line.span)
                    work.is_good = False
                own[var] = line
    domain += [s.domain for s in work.slots if s.mode == mode.name]
    domain += [c.domain for c in work.clocks]
    own = {**defaults.of(mode), **{c.var: c.flow for c in work.clocks}, **own}
    terminal = any(isinstance(i.body, t.Terminal) for i in mode.decl.members)
    flow = _complete(work, mode, own, variables)
    return Mode(mode.name, A.every(domain, mode.span), flow, _mode_lets(work, mode), terminal, mode.decl.span)


def _complete(
    work: _Work, mode: ModeScope, own: dict[str, FlowLine], variables: Sequence[Variable]
) -> tuple[FlowLine, ...]:
    missing = [v.name for v in variables if v.type == "real" and v.name not in own]
    if missing and work.is_good:
        names = ", ".join(f"'{m}'" for m in missing)
        zero = "; ".join(f"{m}' = 0{_rate_unit(variables, m)}" for m in missing)
        work.ctx.report(
            "HA007", f"mode {mode.name} gives no flow for {names}", mode.span, help=f"write `{zero}` if constant"
        )
        work.has_flows = False
    return tuple(own[v.name] for v in variables if v.name in own)


def _rate_unit(variables: Sequence[Variable], name: str) -> str:
    unit = next(v.unit for v in variables if v.name == name)
    text = (unit / SECOND).text if unit is not None else "1"
    return "" if text == "1" else f" {text}"


def _mode_lets(work: _Work, mode: ModeScope) -> tuple[Output, ...]:
    order = {s.name: k for k, s in enumerate(work.lets.symbols)}
    return tuple(sorted(mode.lets.values(), key=lambda o: order[o.name]))


# ---- starts, priorities, the whole ----------------------------------------------


def _starts(work: _Work) -> Iterator[Init]:
    for init in work.bodies(t.Init):
        yield from _guarded(work, lambda: list(_init(work, init))) or ()  # noqa: B023


def _init(work: _Work, init: t.Init) -> Iterator[Init]:
    names = [s.name for s in target_mode(work.env, init.mode)] if init.mode else [None]
    for name in names:
        mode = next((m for m in work.machine.modes if m.name == name), None)
        env = _in_mode(work, mode) if mode is not None else work.env
        where = boolean(env, init.where) if init.where else TRUE
        clocks = tuple(c.start for c in work.clocks)
        yield Init(name, where, (*resets(env, init.assignments), *clocks), init.span)


def _priorities(work: _Work) -> Iterator[Priority]:
    for priority in work.bodies(t.Priority):
        yield from _guarded(work, lambda: list(priorities_of(work.env, priority))) or ()  # noqa: B023


def priorities_of(env: Env, priority: t.Priority) -> Iterator[Priority]:
    """`priority a over b over c when g`; an index left out means all, so families give one priority for each pair."""
    groups = [edges_at(env, p) for p in priority.paths]
    when = boolean(env, priority.guard) if priority.guard else TRUE
    if all(len(g) == 1 for g in groups):
        yield Priority(tuple(g[0] for g in groups), when, priority.span)
        return
    for high, low in pairwise(groups):
        for a in high:
            for b in low:
                yield Priority((a, b), when, priority.span)


def _model(work: _Work, doc: str, span: Any) -> HybridAutomaton | None:
    work.is_good = work.entries.settle() and work.is_good
    _guarded(work, lambda: work.lets.settle())
    variables: list[Variable] = list(work.entries.of(Variable))
    starts = tuple(_starts(work))
    defaults = _Defaults(work)
    modes = tuple(_mode(work, m, defaults, variables) for m in work.machine.modes)
    edges = tuple(_edges(work))
    priorities = tuple(_priorities(work))
    if not starts and work.is_good:
        work.ctx.report("HA307", f"{work.machine.scope.label} has no init line: no run starts", span)
        work.is_good = False
    if not (work.is_good and work.has_flows):
        return None
    of = work.entries.of
    made = HybridAutomaton(
        work.machine.name, of(Constant), of(Param), of(Input), tuple(variables), work.lets.of(Output), starts, modes,
        edges, priorities, doc, span,
    )  # fmt: skip
    work.machine.missing = missing_outputs(made)
    return made if not work.machine.missing or check_automaton(work.ctx, made) else None
