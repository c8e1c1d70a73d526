"""`haverify replay`: a gait on a robot, with every check that a robotics engineer asks for."""

from __future__ import annotations

import argparse
import sys
from fractions import Fraction
from pathlib import Path

from haverify.cli.output import put, wants_colour
from haverify.diagnostics.order import settle
from haverify.diagnostics.render import render_all
from haverify.errors import UsageError
from haverify.evidence.verdict import Trust
from haverify.maths.exact import parse_decimal
from haverify.report.as_json import facts_as_json
from haverify.report.exit_codes import UNREADABLE
from haverify.report.replay import table
from haverify.report.terminal import closing, summary
from haverify.run.pipeline import Options
from haverify.run.replay import replay
from haverify.run.settings import duration


def run(called: argparse.Namespace) -> int:
    """Print the checks; the exit code follows the rules of `check`."""
    view = Path(called.meshcat) if called.meshcat else None
    done = replay(called.file, called.robot, called.map, _speed(called.speed), _options(called), view)
    if done.facts is None:
        sys.stderr.write(render_all(settle(done.found), done.sources, wants_colour()))
        return UNREADABLE
    if called.format == "json":
        put(facts_as_json(done.facts))
        return done.facts.exit_code
    if called.claims and done.outcome is not None:
        put(summary(done.outcome.report, wants_colour()) + "\n")
    put(table(done.facts) + "\n")
    folder = _options(called).report
    put(closing(done.facts.exit_code, [str(p) for p in (folder and folder / "replay.html", view) if p]))
    return done.facts.exit_code


def _speed(text: str | None) -> Fraction | None:
    if text is None:
        return None
    speed = parse_decimal(text)
    if speed is None or speed <= 0:
        raise UsageError(f"--speed {text}: write a positive number such as 0.5")
    return speed


def _options(called: argparse.Namespace) -> Options:
    stem = f"{Path(called.file).stem}-{Path(called.robot).name}"
    folder = Path(called.report or Path("reports") / stem)
    return Options(
        only=None,
        budget=duration("60s"),
        jobs=1,
        report=None if called.no_report else folder,
        use_cache=not called.no_cache,
        lock=None,
        grade=Trust.ENCLOSED,
    )
