"""`haverify simulate`: runs of an automaton, as text, tables and drawings."""

from __future__ import annotations

import argparse
import random
import sys
from pathlib import Path

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


def _automaton(spec: Spec, called: argparse.Namespace) -> HybridAutomaton | None:
    """The one that is named, else the first."""
    if called.automaton is None:
        return spec.automata[0] if spec.automata else None
    found = next((a for a in spec.automata if a.name == called.automaton), None)
    if found is None:
        known = ", ".join(f"`{a.name}`" for a in spec.automata) or "none"
        raise UsageError(f"{called.file}: there is no automaton `{called.automaton}` (there is: {known})")
    return found


def _simulated(spec: Spec, automaton: HybridAutomaton, called: argparse.Namespace) -> int:
    from haverify.obligations.translate import OutsideFragmentError
    from haverify.simulate.as_csv import as_csv
    from haverify.simulate.draws import Drawing
    from haverify.simulate.model import SimulatedAutomaton
    from haverify.simulate.run import Settings, followed

    until = float(duration(called.until))
    settings = Settings(until, policy=called.policy, seed=called.seed)
    try:
        model = SimulatedAutomaton(spec, automaton)
        drawing = Drawing(model, until)
        chance = random.Random(called.seed)
        draws = [drawing.nominal() if k == 0 else drawing.random(chance.random) for k in range(called.runs)]
    except OutsideFragmentError as e:
        raise UsageError(f"{called.file}: `{automaton.name}` cannot be run: {e}") from e
    runs = [followed(model, d, settings) for d in draws]
    times = [until * k / called.samples for k in range(called.samples + 1)]
    if called.csv is not None:
        _write(called.csv, as_csv(runs, times))
    else:
        for k, r in enumerate(runs):
            put(f"run {k}: {r.told()}\n")
    return OK


def _write(path: str, text: str) -> None:
    if path == "-":
        put(text)
        return
    try:
        Path(path).write_text(text, encoding="utf-8")
    except OSError as e:
        raise UsageError(f"{path}: cannot be written: {e.strerror}") from e
