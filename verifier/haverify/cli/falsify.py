"""`haverify falsify`: a search for runs that violate claims; what is found is refuted once enclosures certify it."""

from __future__ import annotations

import argparse
import json
import sys
from time import process_time
from typing import TYPE_CHECKING, Any

from haverify.cli.limits import LAST_SEED, within
from haverify.cli.output import put, wants_colour
from haverify.diagnostics.codes import is_meaningless
from haverify.diagnostics.order import settle
from haverify.diagnostics.render import render_all
from haverify.model.claim import Claim, Goal
from haverify.model.spec import Spec
from haverify.report.exit_codes import NOTHING, OK, UNDECIDED, UNREADABLE, WRONG, worst
from haverify.run.examine import read
from haverify.run.pipeline import require_known
from haverify.run.settings import duration

if TYPE_CHECKING:
    from haverify.simulate.falsify import Searched
    from haverify.simulate.run import SimulatedRun

MOST = 10_000_000
LONGEST = 10_000_000  # s
UNBOUNDED = 1e300  # the margin of what compares no numbers, or of a run that never has a value
CLEARER = 4.0  # times the margin is asked for where enclosures could not tell


def run(called: argparse.Namespace) -> int:
    """Search for each claim; exit code 0 refuted as expected, 1 refuted otherwise, 3 nothing certain was found."""
    within("--runs", called.runs, 1, MOST)
    within("--seed", called.seed, 0, LAST_SEED)
    within("--seconds", called.seconds, 0, LONGEST)
    spec, sources, found = read(called.file)
    errors = settle(d for d in found if is_meaningless(d))
    if spec is None or errors:
        sys.stderr.write(render_all(errors, sources, wants_colour()))
        return UNREADABLE
    if called.property is not None:
        require_known(called.file, called.property, [c.name for c in spec.claims])
    codes, told = [], []
    for claim in spec.claims:
        if called.property in (None, claim.name, claim.name.split("[")[0]):
            for goal in claim.goals:
                outcome = _goal(spec, claim, goal, called)
                if outcome is not None:
                    told.append(outcome)
                    codes.append(_code(claim, outcome))
                    put(_text(outcome) if called.format == "text" else "")
    if called.format == "json":
        put(json.dumps(told, indent=1) + "\n")
    return worst(codes) if codes else _nothing(called)


def _nothing(called: argparse.Namespace) -> int:
    if called.format == "text":
        put("no claim here can be refuted by a run\n")
    return NOTHING


def _code(claim: Claim, outcome: dict[str, Any]) -> int:
    if outcome["verdict"] != "refuted":
        return UNDECIDED
    return OK if claim.expect is not None and claim.expect.verdict == "refuted" else WRONG


def _goal(spec: Spec, claim: Claim, goal: Goal, called: argparse.Namespace) -> dict[str, Any] | None:
    """What the search says of one goal; None where it is not one for runs."""
    from haverify.analyses.networks.product import Product
    from haverify.model.core import to_core
    from haverify.obligations.translate import OutsideFragmentError
    from haverify.simulate.certify import certified
    from haverify.simulate.falsify import searched, subject

    if goal.kind not in ("always", "reach", "stl"):
        return None
    told: dict[str, Any] = {"claim": claim.name, "goal": goal.kind, "verdict": "unknown"}
    try:
        automaton = next((a for a in spec.automata if a.name == claim.on), None)
        if automaton is None:
            if not any(s.name == claim.on for s in spec.systems):
                return None
            whole = Product(spec, to_core(spec), str(claim.on))
            automaton, number = whole.automaton(), claim.goals.index(goal)
            claim = whole.claim(claim)
            goal = claim.goals[number]
        asked = subject(spec, automaton, claim, goal, float(duration(called.until)), called.policy, called.seed)
        end = process_time() + called.seconds
        found = searched(asked, called.runs, called.seed, end=end)
        if found.run is None:
            return {**told, "runs": found.runs, "reason": _ended(found, "no admissible start was found", called)}
        told |= {"margin": found.margin, "runs": found.runs}
        told |= _drawn(found.run)
        if not found.is_violated:
            return {**told, "reason": _ended(found, "no violation was found", called)}
        enclosed = certified(found.run, claim, goal)
        while enclosed.run is None and enclosed.is_close and found.runs < called.runs:  # a clearer violation, then
            found = searched(asked, called.runs, called.seed, CLEARER * found.margin, end)
            if found.run is None or found.is_stopped:
                break
            enclosed = certified(found.run, claim, goal)
            told |= {"margin": found.margin, "runs": found.runs, **_drawn(found.run)}
    except OutsideFragmentError as e:
        return {**told, "reason": str(e), "runs": 0}
    if enclosed.run is None:
        return {**told, "reason": f"violated in floating point, not certified: {enclosed.reason}"}
    return {**told, "verdict": "refuted"}


def _ended(found: Searched, without: str, called: argparse.Namespace) -> str:
    """Why nothing was found, and whether the time was over before the runs were."""
    return f"{without}; stopped after {called.seconds:g} s of the processor" if found.is_stopped else without


def _drawn(run: SimulatedRun) -> dict[str, Any]:
    """The start of a run and what its inputs do."""
    model, draw = run.model, run.draw
    start = {"mode": model.automaton.modes[draw.mode].name, **dict(zip(model.names, draw.state, strict=True))}
    return {"start": start, "inputs": [[t, model.names[place], value] for t, place, value in draw.writes]}


def _text(told: dict[str, Any]) -> str:
    lines = [f"{told['claim']}: {told['verdict']}"]
    if "reason" in told:
        lines[0] += f" ({told['reason']})"
    if "margin" in told:
        margin = f"least margin {told['margin']:.6g}" if abs(told["margin"]) < UNBOUNDED else "no margin"
        lines.append(f"  {margin} after {told['runs']} runs")
    if told["verdict"] == "refuted" or "violated" in told.get("reason", ""):
        start = ", ".join(f"{k} = {v if isinstance(v, str) else format(v, '.9g')}" for k, v in told["start"].items())
        lines.append(f"  start: {start}")
        lines += [f"  from {t:.6g} s: {name} = {value:.9g}" for t, name, value in told["inputs"]]
    return "\n".join(lines) + "\n"
