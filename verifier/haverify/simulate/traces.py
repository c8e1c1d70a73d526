"""Runs as lists of numbers for drawings and for JSON."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from typing import Any

from haverify.simulate.model import SLOPE, SimulatedAutomaton
from haverify.simulate.run import SimulatedRun
from haverify.text.record import record

Slope = tuple[float, float, float, float]  # a place and the direction there
Places = Sequence[tuple[float, float]]

MOST = 6  # quantities drawn where none are asked for


@record
class Trace:
    """A stay in a mode: instants and the values of each quantity."""

    mode: str
    times: list[float]
    values: list[list[float]]


def columns(model: SimulatedAutomaton) -> list[str]:
    """The names of what can be drawn: variables, lets, inputs."""
    own = [v.name for v in model.automaton.vars]
    return [*own, *(o.name for o in model.outputs), *(i.name for i in model.inputs)]


def drawn_by_default(model: SimulatedAutomaton) -> list[str]:
    """The real variables and lets, a few of them; clocks last."""
    own = [v.name for v in model.automaton.vars if v.type == "real"]
    lets = [o.name for o in model.outputs if o.type == "real"]
    return [*own, *lets][:MOST] if len(own) > 1 or not lets else [*lets, *own][:MOST]


def traces(run: SimulatedRun, names: Sequence[str], times: Sequence[float]) -> list[Trace]:
    """A run by stays."""
    model = run.model
    every = columns(model)
    count = len(model.automaton.vars)
    places = [every.index(n) for n in names]
    found = []
    for (_, mode), rows in groupby(run.rows(times), key=lambda r: (r[2], r[1])):
        listed = [(t, [*s[:count], *o, *(s[model.places[i.name]] for i in model.inputs)]) for t, _, _, s, o in rows]
        values = [[v[p] for _, v in listed] for p in places]
        found.append(Trace(model.automaton.modes[mode].name, [t for t, _ in listed], values))
    return found


def slopes(
    model: SimulatedAutomaton,
    run: SimulatedRun,
    mode: int,
    names: tuple[str, str],
    places: Sequence[tuple[float, float]],
) -> list[tuple[float, float, float, float]]:
    """The direction of the flow of a mode at some places, everything else as at the start of a run."""
    found = []
    x, y = (model.places[n] for n in names)
    for a, b in places:
        state = list(run.draw.state)
        state[x], state[y] = a, b
        rates = model.kernel.slopes(mode, state)
        found.append((a, b, rates[x], rates[y]))
    return found


def as_json(run: SimulatedRun, times: Sequence[float]) -> dict[str, Any]:
    """A run as a JSON value: what was drawn, how it ended, jumps, and every quantity by stays."""
    model = run.model
    names = columns(model)
    start = {n: x for n, x in zip(model.names, run.draw.state, strict=True) if not n.startswith(SLOPE)}
    jumps = [
        {"time": t, "edge": model.automaton.edges[e].name, "before": _named(model, a), "after": _named(model, b)}
        for t, e, a, b in run.jumps
    ]
    stays = [
        {"mode": s.mode, "time": s.times, **{n: [_number(x) for x in v] for n, v in zip(names, s.values, strict=True)}}
        for s in traces(run, names, times)
    ]
    end = {"how": run.end, "time": run.time, "mode": model.automaton.modes[run.mode].name, "told": run.told()}
    if run.end == "zeno":
        end["limit"] = run.limit
    mode = model.automaton.modes[run.draw.mode].name
    return {"mode": mode, "start": start, "end": end, "jumps": jumps, "stays": stays}


def _named(model: SimulatedAutomaton, state: Sequence[float]) -> dict[str, float | None]:
    return {v.name: _number(x) for v, x in zip(model.automaton.vars, state, strict=False)}


def _number(x: float) -> float | None:
    return x if x == x and abs(x) != float("inf") else None
