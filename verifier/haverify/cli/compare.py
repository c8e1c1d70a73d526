"""`haverify compare`: recordings and automata beside each other, in one table and one figure."""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from haverify.cli.limits import require_svg
from haverify.cli.output import put, wants_colour
from haverify.diagnostics.codes import is_error, is_meaningless
from haverify.diagnostics.diagnostic import Diagnostic
from haverify.diagnostics.order import settle
from haverify.diagnostics.render import render_all
from haverify.errors import UsageError
from haverify.fitting.compared import Cycled, cycled, distances, shifted, table
from haverify.fitting.posed import Model, apart, opened, paths
from haverify.fitting.walk import Options, walk
from haverify.recordings.phases import PHASES
from haverify.recordings.recording import JOINTS, Forces, told
from haverify.report.exit_codes import OK, UNREADABLE
from haverify.report.figures.overlay import Pane, Series, overlay
from haverify.report.figures.svg import Point
from haverify.report.html.style import standalone
from haverify.run.recordings import recorded
from haverify.text.source import Source

if TYPE_CHECKING:
    from haverify.fitting.posed import Array


def run(called: argparse.Namespace) -> int:
    """Print how far each further walk is from the first; exit code 2 where one cannot be read."""
    if called.plot:
        require_svg(called.plot)
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # small matrices: threads would only wait for one another
    found: list[Diagnostic] = []
    sources: dict[str, Source] = {}
    forces = _forces(called.files)
    walks = [w for f in called.files if (w := _walk(f, called, forces, found, sources)) is not None]
    sys.stderr.write(render_all(found, sources, wants_colour()))
    if any(is_error(d) for d in found):
        return UNREADABLE
    if len(walks) < 2:
        raise UsageError("two walks are needed to compare: recordings, or specs with outputs lh, rh, lk, rk, la, ra")
    model = opened(called.osim) if called.osim else None
    first, shown = walks[0], [walks[0]]
    for other in walks[1:]:
        moved, shift = shifted(first, other)
        shown.append(moved)
        put(table(first, other, shift, distances(first, moved)) + "\n")
    if called.plot:
        _write(Path(called.plot), _figure(shown))
    if model is not None:
        _posed(model, shown, Path(called.plot) if called.plot else None)
    return OK


def _posed(model: Model, walks: list[Cycled], plot: Path | None) -> None:
    """Print how far heels and centre of mass of a model are apart; draw their paths beside the other figure."""
    every = [paths(model, {j: w.angles[j].tolist() for j in JOINTS}) for w in walks]
    for w, other in zip(walks[1:], every[1:], strict=True):
        put(apart(w.name, walks[0].name, model.name, every[0], other) + "\n")
    if plot is not None:
        _write(plot.with_stem(f"{plot.stem}_paths"), _paths_figure(walks, every))


def _paths_figure(walks: list[Cycled], every: list[dict[str, Array]]) -> str:
    panes = []
    for what in every[0]:
        for axis, name in enumerate(("forward", "up")):
            lines = [tuple(enumerate((1000 * path[what][:, axis]).tolist())) for path in every]
            panes.append(Pane(f"{what}, {name} [mm]", tuple(Series(line, k) for k, line in enumerate(lines))))
    title = f"paths of {' and '.join(w.name for w in walks)}, the pelvis at rest"
    return standalone(overlay(panes, [w.name for w in walks], _bands(walks[0]), "share of the cycle [%]", title))


def _forces(files: list[str]) -> tuple[Forces, ...]:
    return recorded(f for f in files if f.lower().endswith((".mot", ".sto"))).forces


def _walk(
    file: str,
    called: argparse.Namespace,
    forces: tuple[Forces, ...],
    found: list[Diagnostic],
    sources: dict[str, Source],
) -> Cycled | None:
    """The walk in a file; None of ground forces, and where findings say why."""
    if file.endswith(".ha"):
        return _automaton(file, called, found, sources)
    read = recorded([file], called.angles or "")
    found += read.found
    sources |= read.sources
    if not read.recordings:
        return None
    made, more = walk(read.recordings, forces, Options((called.leg or "")[:1]))
    found += more
    if made is None:
        return None
    shares = [float(t / made.knots.period) for t in made.knots.at[1:-1]]
    return cycled(made.recordings[0].name, made.cycles, shares)


def _automaton(
    file: str, called: argparse.Namespace, found: list[Diagnostic], sources: dict[str, Source]
) -> Cycled | None:
    """One cycle of the first automaton of a spec that has the six joints as outputs."""
    from haverify.run.cycle import cycle
    from haverify.run.examine import read

    spec, texts, more = read(file)
    errors = settle(d for d in more if is_meaningless(d))
    found += errors
    sources |= texts
    if spec is None or errors:
        return None
    angles, shares, seconds = cycle(file, spec, called.automaton)
    return Cycled(Path(file).stem, angles, {}, shares, seconds)


def _figure(walks: list[Cycled]) -> str:
    """A pane for each joint, the phases of the first walk behind the curves."""
    panes = []
    for j in JOINTS:
        series = [Series(tuple(enumerate(w.angles[j].tolist())), k) for k, w in enumerate(walks)]
        panes.append(Pane(f"{told(j)} [deg]", tuple(series), _edge(walks[0], j, -2), _edge(walks[0], j, 2)))
    title = " and ".join(w.name for w in walks)
    return standalone(overlay(panes, [w.name for w in walks], _bands(walks[0]), "share of the cycle [%]", title))


def _bands(w: Cycled) -> list[tuple[str, float, float]]:
    ends = [0.0, *(100 * s for s in w.shares), 100.0]
    names = PHASES if len(ends) == len(PHASES) + 1 else [str(k + 1) for k in range(len(ends) - 1)]
    return [(n, a, b) for n, a, b in zip(names, ends, ends[1:], strict=False)]


def _edge(w: Cycled, joint: str, deviations: int) -> tuple[Point, ...]:
    """The curve some standard deviations up, where they are known."""
    if joint not in w.sd:
        return ()
    return tuple(enumerate((w.angles[joint] + deviations * w.sd[joint]).tolist()))


def _write(file: Path, text: str) -> None:
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
    except OSError as e:
        raise UsageError(f"{file}: cannot be written: {e.strerror}") from e
