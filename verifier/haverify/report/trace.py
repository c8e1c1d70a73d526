"""A run of a system for display: what each part is in, when it changes, and what fires."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from haverify.evidence.network_run import NetworkRun
from haverify.evidence.run import Run
from haverify.maths.digits import rational_text
from haverify.model.hybrid import HybridAutomaton, Variable
from haverify.model.spec import Spec
from haverify.model.system import System
from haverify.report import report
from haverify.report.numbers import decimal
from haverify.report.values import shown
from haverify.report.walk import enclosed


def describe_trace(spec: Spec, system: str, run: NetworkRun, violation: str | None) -> report.Run:
    """The run: the modes of all parts, the interactions between them, the instants and the values.

    The last instant is shown besides, as the end; it is the entry of the last state where the run does not stay there.
    """
    times = [Fraction(0)]
    for m in run.moments:
        times.append(times[-1] + m.dwell)
    variables = dict(_variables(spec, system, ""))
    states = [dict(m.values) for m in run.moments]
    states.append(dict(run.end))
    return report.Run(
        mode_path=[", ".join(f"{part}.{mode}" for part, mode in m.modes) for m in run.moments],
        edges=[m.names[0] for m in run.moments[1:]],
        times=[rational_text(t) for t in times],
        times_decimal=[decimal(t) for t in times],
        states=[{n: rational_text(q) for n, q in s.items()} for s in states],
        states_decimal=[{n: shown(spec, variables[n], q) for n, q in s.items()} for s in states],
        params={},
        units={n: str(v.unit) for n, v in variables.items() if v.unit is not None and str(v.unit) != "1"},
        violation=violation,
    )


def describe_passages(spec: Spec, system: str, run: Run, violation: str | None) -> report.Run:
    """A run of a system with flows: the modes of all parts, and the variables of each under its own name."""
    return enclosed(spec, dict(_variables(spec, system, "")), run, violation)


def _variables(spec: Spec, name: str, prefix: str) -> Iterator[tuple[str, Variable]]:
    """The variables of a system and of its parts, by their full names."""
    model: HybridAutomaton | System | None = next((s for s in spec.systems if s.name == name), None)
    model = model or next(a for a in spec.automata if a.name == name)
    yield from ((prefix + v.name, v) for v in model.vars)
    for p in model.parts if isinstance(model, System) else ():
        yield from _variables(spec, p.of, f"{prefix}{p.name}.")
