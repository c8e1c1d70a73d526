"""Runs as tables of text: one line for each instant."""

from __future__ import annotations

from collections.abc import Sequence

from haverify.simulate.model import SimulatedAutomaton
from haverify.simulate.run import SimulatedRun


def columns(model: SimulatedAutomaton) -> list[str]:
    """Names with units: run, time, mode, jumps, variables, lets."""
    named = [*(v.name for v in model.automaton.vars), *(o.name for o in model.outputs)]
    return ["run", "time [s]", "mode", "jumps", *titled(model, named)]


def titled(model: SimulatedAutomaton, names: Sequence[str]) -> list[str]:
    """Names of variables, lets and inputs with their units."""
    units = {o.name: o.unit for o in model.outputs} | {v.name: v.unit for v in model.automaton.vars}
    units |= {i.name: i.unit for i in model.inputs}
    return [f"{n} [{u.text}]" if (u := units[n]) is not None and u.text not in ("", "1") else n for n in names]


def as_csv(runs: Sequence[SimulatedRun], times: Sequence[float]) -> str:
    """Every run at some times and on both sides of its jumps; a let that a mode does not have is left empty."""
    if not runs:
        return ""
    model = runs[0].model
    count = len(model.automaton.vars)
    lines = [",".join(_quoted(c) for c in columns(model))]
    for k, run in enumerate(runs):
        for t, mode, jumps, state, outputs in run.rows(times):
            numbers = [number(x) for x in (*state[:count], *outputs)]
            lines.append(",".join([str(k), number(t), model.automaton.modes[mode].name, str(jumps), *numbers]))
    return "\n".join(lines) + "\n"


def number(x: float) -> str:
    """A float that reads back as it is; one that is no number is empty."""
    if x != x:
        return ""
    return repr(int(x)) if abs(x) < 1e15 and x == int(x) else repr(x)


def _quoted(text: str) -> str:
    return f'"{text}"' if "," in text else text
