"""A run as an OpenSim motion file: one row for each of evenly spaced times, angles in degrees."""

from __future__ import annotations

from collections.abc import Sequence

from haverify.model.hybrid import Output, Variable
from haverify.simulate.run import SimulatedRun


def joints(run: SimulatedRun) -> list[Output | Variable]:
    """The quantities in degrees: outputs, else variables."""
    model = run.model
    lets = [o for o in model.outputs if o.unit is not None and o.unit.text == "deg"]
    own = [v for v in model.automaton.vars if v.unit is not None and v.unit.text == "deg"]
    return [*lets, *own]


def as_mot(run: SimulatedRun, times: Sequence[float], name: str) -> str:
    """The motion file; at a jump a row has the value after it."""
    wanted = joints(run)
    model = run.model
    count = len(model.automaton.vars)
    columns = [*(v.name for v in model.automaton.vars), *(o.name for o in model.outputs)]
    places = [columns.index(q.name) for q in wanted]
    rows: dict[float, list[float]] = {}
    asked = set(times)
    for t, _, _, state, outputs in run.rows(times):
        if t in asked:
            values = [*state[:count], *outputs]
            rows[t] = [values[p] for p in places]
    head = [name, "version=1", f"nRows={len(rows)}", f"nColumns={1 + len(wanted)}", "inDegrees=yes", "endheader"]
    titles = "\t".join(["time", *(_plain(q.name) for q in wanted)])
    lines = ["\t".join(f"{x:.10f}" for x in (t, *values)) for t, values in sorted(rows.items())]
    return "\n".join([*head, titles, *lines]) + "\n"


def _plain(name: str) -> str:
    """A column's name without blanks and brackets."""
    return "".join(c if c.isalnum() or c in "_." else "_" for c in name)
