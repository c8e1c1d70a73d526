"""Sampled runs with jumps, to be drawn into a flowpipe: each edge is taken as soon as its guard is met."""

from __future__ import annotations

from collections.abc import Callable
from math import isfinite
from typing import Any

from haverify.report.figures.evaluate import Scope, State, Value, scope, with_params
from haverify.report.figures.material import Json, Material, Undrawable
from haverify.report.figures.pipes import Pipe
from haverify.report.figures.sampled import Trail, starts, stepped
from haverify.text.record import record

_STEPS = 160  # of a run, up to the end of what is shown
_HALVINGS = 30
_JUMPS = 40
_HOLDS: dict[str, Callable[[float], bool]] = {
    "<": lambda d: d < 0,
    "<=": lambda d: d <= 0,
    ">": lambda d: d > 0,
    ">=": lambda d: d >= 0,
}


@record
class _Edge:
    """Differences that a guard compares with zero, where it leads, what it sets."""

    guard: tuple[tuple[str, Value], ...]
    target: str
    resets: tuple[tuple[str, Value], ...]

    def is_met(self, before: State, after: State) -> bool:
        """Whether the guard is met at the later of two states; an equation also where it is crossed between them."""
        return all(self._is_crossed(d, before, after) if op == "==" else _HOLDS[op](d(after)) for op, d in self.guard)

    def _is_crossed(self, d: Value, before: State, after: State) -> bool:
        return d(before) * d(after) < 0 or (d(before) != 0 and d(after) == 0)


@record
class _Mode:
    rates: dict[str, Value]
    edges: tuple[_Edge, ...]


def strokes(material: Material, automaton: Json, pipe: Pipe) -> list[Trail]:
    """Runs from some points of the first start, in pieces between jumps; none where one cannot be computed."""
    first = pipe.pieces[0]
    found: list[Trail] = []
    for start in starts(first):
        try:
            modes = {m["name"]: _compiled(material, automaton, m, start) for m in automaton["modes"]}
            found += _run(modes, first.mode, start, pipe.end)
        except (Undrawable, ArithmeticError, ValueError):
            return []
    return found


def _compiled(material: Material, automaton: Json, mode: Json, start: State) -> _Mode:
    s = scope(material, automaton, mode)
    own = with_params(s, {n: repr(x) for n, x in start.items() if n in s.params})
    edges = [e for e in automaton["edges"] if e["source"] == mode["name"]]
    return _Mode({n: own.value(rate) for n, rate in s.rates.items()}, tuple(_edge(own, e) for e in edges))


def _edge(s: Scope, e: Json) -> _Edge:
    if any("to" not in r for r in e["resets"]):
        raise Undrawable  # a choice that a sampled run would have to make
    resets = tuple((str(r["var"]), s.value(r["to"])) for r in e["resets"])
    return _Edge(tuple(_conjuncts(s, e["guard"])), str(e["target"]), resets)


def _conjuncts(s: Scope, guard: Any) -> list[tuple[str, Value]]:
    if isinstance(guard, list) and guard and guard[0] == "and":
        return [c for g in guard[1:] for c in _conjuncts(s, g)]
    if not isinstance(guard, list) or len(guard) != 3 or guard[0] not in (*_HOLDS, "=="):
        raise Undrawable
    return [(str(guard[0]), s.value(["-", guard[1], guard[2]]))]


def _run(modes: dict[str, _Mode], name: str, state: State, end: float) -> list[Trail]:
    found, t, h = list[Trail](), 0.0, end / _STEPS
    while t < end and len(found) < _JUMPS:
        mode, times, states = modes[name], [t], [state]
        edge = None
        while t < end and edge is None:
            after = stepped(mode.rates, states[-1], h)
            edge = next((e for e in mode.edges if e.is_met(states[-1], after)), None)
            dwell = h if edge is None else _instant(mode, edge, states[-1], h)
            t += dwell
            times.append(t)
            states.append(after if edge is None else stepped(mode.rates, states[-1], dwell))
            if not all(map(isfinite, states[-1].values())):
                return found
        found.append(Trail(tuple(times), tuple(states)))
        if edge is not None:
            name, state = edge.target, _landed(edge, states[-1])
    return found


def _instant(mode: _Mode, edge: _Edge, state: State, h: float) -> float:
    """How long until the guard is met, which it is after `h`; a little later rather than earlier."""
    low, high = 0.0, h
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        low, high = (low, middle) if edge.is_met(state, stepped(mode.rates, state, middle)) else (middle, high)
    return high


def _landed(edge: _Edge, state: State) -> State:
    """The state after the jump, on the side of an equation that the flow came to."""
    return {**state, **{n: float(value(state)) for n, value in edge.resets}}
