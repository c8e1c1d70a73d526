"""`haverify simulate`: runs of an automaton, as text, tables and drawings."""

from __future__ import annotations

import argparse
import json
import random
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from haverify.cli.limits import LAST_SEED, require_svg, within
from haverify.cli.output import put, wants_colour
from haverify.diagnostics.codes import is_meaningless
from haverify.diagnostics.order import settle
from haverify.diagnostics.render import render_all
from haverify.errors import UsageError
from haverify.model.hybrid import HybridAutomaton
from haverify.model.spec import Spec
from haverify.report.exit_codes import NOTHING, OK, UNREADABLE
from haverify.run.examine import read
from haverify.run.settings import duration
from haverify.text.record import replace

if TYPE_CHECKING:
    from haverify.simulate.orbits import Orbit
    from haverify.simulate.run import SimulatedRun
    from haverify.simulate.traces import Trace

MOST = 100_000
DRAWN = 800  # instants of a drawing
BENDS = 12  # instants of each step in a drawing in the plane


def run(called: argparse.Namespace) -> int:
    """Follow the runs that are asked for; exit code 5 where the spec has no automaton, 2 where it cannot be run."""
    spec, sources, found = read(called.file)
    errors = settle(d for d in found if is_meaningless(d))
    if spec is None or errors:
        sys.stderr.write(render_all(errors, sources, wants_colour()))
        return UNREADABLE
    automaton = _automaton(spec, called)
    if automaton is None:
        put("nothing here can be run\n")
        return NOTHING
    return _simulated(spec, automaton, called)


def _automaton(spec: Spec, called: argparse.Namespace) -> str | None:
    """The name of the automaton or system that is asked for, else the first automaton, else the first system."""
    names = [*(a.name for a in spec.automata), *(s.name for s in spec.systems)]
    if called.automaton is None:
        return names[0] if names else None
    if called.automaton not in names:
        known = ", ".join(f"`{n}`" for n in names) or "none"
        raise UsageError(f"{called.file}: there is no automaton `{called.automaton}` (there is: {known})")
    return str(called.automaton)


def _simulated(spec: Spec, name: str, called: argparse.Namespace) -> int:
    from haverify.obligations.translate import OutsideFragmentError
    from haverify.simulate.as_csv import as_csv
    from haverify.simulate.draws import Drawing
    from haverify.simulate.model import SimulatedAutomaton
    from haverify.simulate.run import Settings, followed
    from haverify.simulate.traces import as_json

    within("--runs", called.runs, 1, MOST)
    within("--samples", called.samples, 1, MOST)
    within("--seed", called.seed, 0, LAST_SEED)
    if called.plot not in (None, "-"):
        require_svg(called.plot)
    until = float(duration(called.until))
    try:
        model = SimulatedAutomaton(spec, _put_together(spec, name))
        drawing = Drawing(model, until)
        chance = random.Random(called.seed)
        draws = [drawing.nominal() if k == 0 else drawing.random(chance.random) for k in range(called.runs)]
    except OutsideFragmentError as e:
        systems = [s.name for s in spec.systems if s.name != name]
        other = f"; try -a {systems[0]}" if called.automaton is None and systems else ""
        raise UsageError(f"{called.file}: `{name}` cannot be run: {e}{other}") from e
    seeds = range(called.seed, called.seed + len(draws))
    runs = [
        followed(model, d, Settings(until, policy=called.policy, seed=k)) for d, k in zip(draws, seeds, strict=True)
    ]
    orbit = _orbit(runs[0], name, called) if called.orbit else None
    times = [until * k / called.samples for k in range(called.samples + 1)]
    if called.csv is not None:
        _write(called.csv, as_csv(runs, times))
    if called.mot is not None:
        _write(called.mot, _motion(runs[0], times, called))
    if called.plot is not None:
        _write(called.plot, _drawing(runs, [until * k / DRAWN for k in range(DRAWN + 1)], orbit, called))
    if called.format == "json":
        told = [as_json(r, times) for r in runs]
        if orbit is not None:
            told[0]["orbit"] = orbit.as_json()
        put(json.dumps(told, indent=1) + "\n")
    elif "-" not in (called.csv, called.mot, called.plot):
        for k, r in enumerate(runs):
            put(f"run {k}: {r.told()}\n")
        put(f"orbit: {orbit.told()}\n" if orbit is not None else "")
    return OK


def _orbit(run: SimulatedRun, name: str, called: argparse.Namespace) -> Orbit:
    """The periodic orbit that a run comes to."""
    from haverify.obligations.translate import OutsideFragmentError
    from haverify.simulate.orbits import orbit_of

    try:
        return orbit_of(run)
    except OutsideFragmentError as e:
        raise UsageError(f"{called.file}: no periodic orbit of `{name}`: {e}") from e


def _put_together(spec: Spec, name: str) -> HybridAutomaton:
    """The automaton of this name, or the one that a system is."""
    from haverify.analyses.networks.product import Product
    from haverify.model.core import to_core

    found = next((a for a in spec.automata if a.name == name), None)
    return Product(spec, to_core(spec), name).automaton() if found is None else found


def _motion(run: SimulatedRun, times: list[float], called: argparse.Namespace) -> str:
    from haverify.simulate.as_mot import as_mot, joints

    if not joints(run):
        raise UsageError(f"{called.file}: `{run.model.automaton.name}` has no angle in deg to write")
    return as_mot(run, times, Path(called.file).stem)


def _drawing(runs: list[SimulatedRun], times: list[float], orbit: Orbit | None, called: argparse.Namespace) -> str:
    """The drawing that is asked for, as a file of its own."""
    from haverify.report.figures import simulated
    from haverify.report.html.style import standalone
    from haverify.simulate.as_csv import titled
    from haverify.simulate.traces import columns, drawn_by_default, traces

    model = runs[0].model
    if not any(r.rows(times) for r in runs):
        raise UsageError(f"{called.file}: no run has an instant to draw: {runs[0].told()}")
    names = called.of.split(",") if called.of else drawn_by_default(model)
    unknown = [n for n in names if n not in columns(model)]
    if unknown:
        raise UsageError(f"{called.file}: there is no `{unknown[0]}` to draw (there is: {', '.join(columns(model))})")
    title = f"{model.automaton.name}, {len(runs)} runs" if len(runs) > 1 else f"{model.automaton.name}, a run"
    if called.kind == "modes":
        return standalone(_modes(model.spec, model.automaton, called))
    if called.kind == "series":
        return standalone(simulated.over_time(titled(model, names), [traces(r, names, times) for r in runs], title))
    if len(names) < 2:
        raise UsageError("a drawing in the plane needs two quantities: --of x,y")
    pair = names[0], names[1]
    drawn = [traces(r, pair, _fine(r)) for r in runs]
    arrows = _arrows(runs[0], pair, drawn, called) if called.kind == "field" else []
    closed = [] if orbit is None else traces(orbit.run, pair, [orbit.period * k / DRAWN for k in range(DRAWN + 1)])
    axes = titled(model, pair)[0], titled(model, pair)[1]
    return standalone(simulated.in_plane(axes, drawn, arrows, title, closed))


def _fine(run: SimulatedRun) -> list[float]:
    """Instants that show every bend of a run: some of each of its steps, of very many steps fewer."""
    pieces = [p for p in run.record.pieces() if p[3] > 0]
    each = max(1, min(BENDS, DRAWN * BENDS // max(len(pieces), 1)))
    return [p[2] + p[3] * k / each for p in pieces for k in range(each)]


def _modes(spec: Spec, automaton: HybridAutomaton, called: argparse.Namespace) -> str:
    """The mode graph; of a system, that of all its parts together."""
    from haverify.model.core import to_core
    from haverify.report.figures import graphs
    from haverify.report.figures.material import Undrawable

    [found] = to_core(replace(spec, automata=(automaton,), systems=(), claims=()))["automata"]
    try:
        return graphs.of_automaton(found).svg
    except Undrawable as e:
        count = len(automaton.modes)
        message = f"the mode graph of `{automaton.name}` is not drawn: {count} mode{'' if count == 1 else 's'}"
        raise UsageError(f"{called.file}: {message}, {len(automaton.edges)} edges") from e


def _arrows(
    run: SimulatedRun, pair: tuple[str, str], drawn: list[list[Trace]], called: argparse.Namespace
) -> list[tuple[float, float, float, float]]:
    """The vector field of a mode over what the runs cover."""
    from haverify.simulate.traces import slopes

    modes = [m.name for m in run.model.automaton.modes]
    if called.mode is not None and called.mode not in modes:
        raise UsageError(f"{called.file}: there is no mode `{called.mode}` (there is: {', '.join(modes)})")
    if any(n not in run.model.places for n in pair):
        raise UsageError("a vector field is that of two variables: --of x,y")
    mode = modes.index(called.mode) if called.mode is not None else run.draw.mode
    xs, ys = ([v for trace in drawn for s in trace for v in s.values[k]] for k in (0, 1))
    grid = [(_part(xs, i / 18), _part(ys, j / 14)) for i in range(19) for j in range(15)]
    return slopes(run.model, run, mode, pair, grid)


def _part(values: list[float], share: float) -> float:
    return min(values) + share * (max(values) - min(values))


def _write(path: str, text: str) -> None:
    if path == "-":
        put(text)
        return
    try:
        Path(path).write_text(text, encoding="utf-8")
    except OSError as e:
        raise UsageError(f"{path}: cannot be written: {e.strerror}") from e
