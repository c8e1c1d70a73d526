"""A run walked for display: the modes, instants and states on its way, with exact numbers.

It adds nothing to what makes a run believed: `hacheck` walks every run on its own.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from fractions import Fraction
from operator import ge, gt, le, lt

from haverify.evidence.run import Run, Step
from haverify.maths.digits import rational_text
from haverify.model.expression import Expr
from haverify.model.hybrid import Edge, HybridAutomaton, Input, Mode, Param, Range, Variable
from haverify.model.spec import Spec
from haverify.report import report
from haverify.report.numbers import agreed, decimal
from haverify.report.values import shown
from haverify.text.record import record

State = dict[str, Fraction]


Named = Param | Variable | Input


class _NotExact(Exception):
    """A value on the way is no rational; the run is shown up to there."""


@record
class _Scope:
    """What names mean: values of variables and params, definitions of constants and lets."""

    state: State
    params: State
    definitions: Callable[[str, str], Expr]
    enums: dict[str, tuple[str, ...]]
    time: Fraction


def describe(spec: Spec, automaton: HybridAutomaton, run: Run, violation: str | None) -> report.Run:
    """The run with its modes, edges, instants and states; it ends early where a value is no rational."""
    if run.path:
        own: tuple[Named, ...] = (*spec.inputs, *automaton.inputs, *automaton.params, *automaton.vars)
        return enclosed(spec, {x.name: x for x in own}, run, violation)
    modes, edges, times, states = [run.mode], list[str](), [Fraction(0)], [dict(run.values)]
    try:
        for step in run.steps:
            edge = automaton.edges[step.edge]
            _advance(spec, automaton, run, step.dwell, modes[-1], times, states)
            states[-1] = _after(_scope(spec, automaton, run, modes[-1], times[-1], states[-1]), edge, step, states[-1])
            modes.append(edge.target)
            edges.append(edge.name)
        _advance(spec, automaton, run, run.last, modes[-1], times, states)
    except (_NotExact, ZeroDivisionError, IndexError, KeyError):
        times, states = times[: len(modes)], states[: len(modes)]
    variables = {v.name: v for v in automaton.vars}
    told = [{name: shown(spec, variables[name], q) for name, q in state.items()} for state in states]
    return _shown(modes, edges, times, states, told, run, _units(spec, automaton), violation)


def enclosed(spec: Spec, named: Mapping[str, Named], run: Run, violation: str | None) -> report.Run:
    """A run along flows: its start exactly, what comes later to as many digits as its enclosures agree on.

    `named` has the variables and inputs, and params besides those of the spec.
    """
    modes = [p.mode for p in run.path[:-1]]
    edges = [p.edge for p in run.path[1:-1] if p.edge is not None]
    start, of_run = dict(run.values), dict(run.params)
    told = [{name: shown(spec, v, q) for name, q in start.items() if not isinstance(v := named[name], Param)}]
    told += [{name: agreed(low, high) for name, low, high in p.values} for p in run.path[1:]]
    return report.Run(
        mode_path=modes,
        edges=edges,
        times=["0"],
        times_decimal=["0", *(agreed(*p.time) for p in run.path[1:])],
        states=[{name: rational_text(q) for name, q in start.items()}],
        states_decimal=told,
        params={name: rational_text(q) for name, q in of_run.items()},
        units={n: u for n, u in _known_units([*spec.params, *named.values()]).items() if n in start or n in of_run},
        violation=violation,
    )


def _units(spec: Spec, automaton: HybridAutomaton) -> dict[str, str]:
    """The units of variables and params; plain numbers have none."""
    return _known_units([*spec.params, *automaton.params, *automaton.vars])


def _known_units(named: Iterable[Named]) -> dict[str, str]:
    return {x.name: str(x.unit) for x in named if x.unit is not None and str(x.unit) != "1"}


def _shown(
    modes: list[str],
    edges: list[str],
    times: list[Fraction],
    states: list[State],
    told: list[dict[str, str]],
    run: Run,
    units: dict[str, str],
    violation: str | None,
) -> report.Run:
    return report.Run(
        mode_path=modes,
        edges=edges,
        times=[rational_text(t) for t in times],
        times_decimal=[decimal(t) for t in times],
        states=[{name: rational_text(q) for name, q in state.items()} for state in states],
        states_decimal=told,
        params={name: rational_text(q) for name, q in run.params},
        units={name: unit for name, unit in units.items() if name in states[0] or name in dict(run.params)},
        violation=violation,
    )


def _advance(
    spec: Spec,
    automaton: HybridAutomaton,
    run: Run,
    dwell: Fraction,
    mode: str,
    times: list[Fraction],
    states: list[State],
) -> None:
    """Append the instant and the state after dwelling: every rate is constant along a clock-driven run."""
    scope = _scope(spec, automaton, run, mode, times[-1], states[-1])
    state = dict(states[-1])
    for line in _mode(automaton, mode).flow:
        if isinstance(line.rate, Range):
            raise _NotExact
        state[line.var] += dwell * _value(line.rate, scope)
    times.append(times[-1] + dwell)
    states.append(state)


def _after(scope: _Scope, edge: Edge, step: Step, before: State) -> State:
    chosen = dict(step.values)
    values = {a.var: chosen[a.var] if isinstance(a.to, Range) else _value(a.to, scope) for a in edge.resets}
    return {**before, **values}


def _mode(automaton: HybridAutomaton, name: str) -> Mode:
    return next(m for m in automaton.modes if m.name == name)


def _scope(spec: Spec, automaton: HybridAutomaton, run: Run, mode: str, time: Fraction, state: State) -> _Scope:
    lets = [*automaton.lets, *_mode(automaton, mode).lets]

    def definition(op: str, name: str) -> Expr:
        found = (
            (o.expr for o in reversed(lets) if o.name == name)
            if op == "let"
            else (c.value for c in (*automaton.constants, *spec.constants) if c.name == name)
        )
        value = next(found, None)
        if not isinstance(value, Expr):
            raise _NotExact
        return value

    return _Scope(state, dict(run.params), definition, {e.name: e.values for e in spec.enums}, time)


def _value(e: Expr, scope: _Scope) -> Fraction:
    if e.op == "num":
        return Fraction(e.args[0])  # type: ignore[arg-type]
    if e.op == "time":
        return scope.time
    if e.op == "var":
        return scope.state[e.name]
    if e.op == "param":
        return scope.params[e.name]
    if e.op in ("const", "let"):
        return _value(scope.definitions(e.op, e.name), scope)
    if e.op == "sym":
        return Fraction(scope.enums[str(e.args[0])].index(str(e.args[1])))
    if e.op == "scale" and e.args[1] == 0:
        return Fraction(e.args[0]) * _value(e.children[0], scope)  # type: ignore[arg-type]
    if e.op == "if":
        return _value(e.children[1 if _truth(e.children[0], scope) else 2], scope)
    if e.op in ("true", "false", *_COMPARISONS, *_CONNECTIVES):
        return Fraction(_truth(e, scope))
    if e.op not in _FUNCTIONS:
        raise _NotExact
    return _FUNCTIONS[e.op]([_value(c, scope) for c in e.children])


def _product(factors: Iterable[Fraction]) -> Fraction:
    product = Fraction(1)
    for f in factors:
        product *= f
    return product


def _power(args: list[Fraction]) -> Fraction:
    base, exponent = args
    if exponent.denominator != 1 or abs(exponent) > 1000:
        raise _NotExact
    return base ** int(exponent)


_FUNCTIONS: dict[str, Callable[[list[Fraction]], Fraction]] = {
    "+": lambda v: sum(v, Fraction(0)),
    "-": lambda v: v[0] - v[1],
    "neg": lambda v: -v[0],
    "*": _product,
    "/": lambda v: v[0] / v[1],
    "^": _power,
    "abs": lambda v: abs(v[0]),
    "min": min,
    "max": max,
    "clamp": lambda v: min(max(v[0], v[1]), v[2]),
}

_COMPARISONS: dict[str, Callable[[Fraction, Fraction], bool]] = {
    "<": lt,
    "<=": le,
    ">": gt,
    ">=": ge,
    "==": lambda a, b: a == b,
    "!=": lambda a, b: a != b,
}

_CONNECTIVES: dict[str, Callable[[list[bool]], bool]] = {
    "and": all,
    "or": any,
    "not": lambda v: not v[0],
    "implies": lambda v: not v[0] or v[1],
}


def _truth(e: Expr, scope: _Scope) -> bool:
    if e.op in ("true", "false"):
        return e.op == "true"
    if e.op in _COMPARISONS:
        return _COMPARISONS[e.op](*(_value(c, scope) for c in e.children))
    if e.op in _CONNECTIVES:
        return _CONNECTIVES[e.op]([_truth(c, scope) for c in e.children])
    return bool(_value(e, scope))
