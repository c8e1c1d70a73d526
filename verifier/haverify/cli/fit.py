"""`haverify fit`: gait recordings to a spec with tables."""

from __future__ import annotations

import argparse
import os
import re
import sys
from fractions import Fraction
from pathlib import Path

from haverify.cli.limits import require_svg
from haverify.cli.output import put, wants_colour
from haverify.diagnostics.codes import is_error
from haverify.diagnostics.render import render_all
from haverify.errors import UnsupportedError, UsageError
from haverify.fitting.bounded import Interval
from haverify.fitting.emit import emit
from haverify.fitting.table import table
from haverify.fitting.walk import Options, Walk, walk
from haverify.report.exit_codes import OK, UNREADABLE
from haverify.run.recordings import recorded


def run(called: argparse.Namespace) -> int:
    """Write the spec and its tables; exit code 2, and nothing written, where a recording cannot be used."""
    if called.plot:
        require_svg(called.plot)
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # small matrices: threads would only wait for one another
    path = Path(called.output)
    stem = path.stem
    if path.suffix != ".ha" or not stem.replace("-", "_").isidentifier():
        raise UsageError(f"{path}: the spec's name is letters, digits and _, and ends in .ha")
    options = _options(called)
    read = recorded(called.files, called.angles or "")
    tried = recorded(called.held_out or [], called.angles or "")
    found = [*read.found, *tried.found]
    made: Walk | None = None
    if not any(is_error(d) for d in found):
        if not read.recordings:
            raise UsageError("no recording among the files: only ground forces")
        try:
            made, more = walk(read.recordings, read.forces, options, tried.recordings)
        except UnsupportedError as e:
            raise UsageError(str(e)) from e
        found += more
    sys.stderr.write(render_all(found, read.sources | tried.sources, wants_colour()))
    if made is None:
        return UNREADABLE
    for name, text in emit(made, stem).items():
        _write(path.parent / name, text)
    if called.plot:
        from haverify.cli.walk_figure import orbit_figure, stick_figure, walk_figure

        drawn = Path(called.plot)
        _write(drawn, walk_figure(made, stem))
        _write(drawn.with_stem(f"{drawn.stem}_orbits"), orbit_figure(made, stem))
        _write(drawn.with_stem(f"{drawn.stem}_sticks"), stick_figure(made, stem))
    put(table(made))
    put(f"{path}: written; try `haverify check {path}`\n")
    return OK


def _options(called: argparse.Namespace) -> Options:
    order = 1 if called.order is None else called.order
    if called.degree is not None and not 2 * order + 1 <= called.degree <= 9:
        raise UsageError(f"--degree {called.degree}: {2 * order + 1} to 9 with --order {order}")
    bounds = dict(_bound(text) for text in called.bound or [])
    return Options(
        (called.leg or "")[:1], order, called.degree, called.events or "zeni", called.outliers or "single", bounds
    )


def _bound(text: str) -> tuple[str, Interval]:
    """`knee=-130..1`, in degrees."""
    m = re.fullmatch(r"(hip|knee|ankle)=(-?\d+(?:\.\d+)?)\.\.(-?\d+(?:\.\d+)?)", text)
    low, high = (Fraction(m[2]), Fraction(m[3])) if m else (Fraction(0), Fraction(0))
    if m is None or high - low < 1:
        raise UsageError(f"--bound {text}: write a joint and an interval of at least 1 deg, such as knee=-130..1")
    return m[1][0], Interval(low, high)


def _write(file: Path, text: str) -> None:
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8", newline="\n")
    except OSError as e:
        raise UsageError(f"{file}: cannot be written: {e.strerror}") from e
