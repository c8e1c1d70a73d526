"""Recordings in a replay: one that is replayed itself, or one that the automaton is compared with."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.recordings.read import SUFFIXES
from haverify.report.figures.robot import Curve, Film, joints
from haverify.robot.comparison import Compared
from haverify.run.recordings import recorded
from haverify.text.record import record
from haverify.text.source import Source


@record
class Angles:
    """A recording in floats, in deg, by the names of the gait's outputs; the file read and what is wrong with it."""

    times: Sequence[float]
    values: Mapping[str, Sequence[float]]
    source: Source | None
    found: list[Diagnostic]


def is_recording(path: str) -> bool:
    """Whether a path names a recording rather than a spec."""
    return path.lower().endswith(SUFFIXES)


def angles_of(path: str, wanted: Sequence[str]) -> Angles:
    """The wanted angles of a recording, each at every instant, or findings."""
    got = recorded([path])
    source = next(iter(got.sources.values()), None)
    if not got.recordings:
        found = list(got.found) or [Diagnostic("HA210", f"{path} holds no joint angles")]
        return Angles((), {}, source, found)
    r = got.recordings[0]
    missing = [name for name in wanted if name not in r.angles or None in r.angles[name]]
    found = [Diagnostic("HA210", f"{path}: the angle {name} is missing, at some instants at least") for name in missing]
    errors = [d for d in got.found if d.code not in ("HA108",)] if not found else []
    if found or len(r.times) < 4:
        found = found or [Diagnostic("HA210", f"{path} has {len(r.times)} samples, too few for a spline")]
        return Angles((), {}, source, [*errors, *found])
    values = {name: r.near[name] for name in wanted}
    return Angles(r.clock, values, source, [])


def comparison_figure(rows: Sequence[Compared]) -> str:
    """The curves of all joints, one below the other."""
    times = [t for t, _ in rows[0].automaton]
    curves = []
    for c in rows:
        others = {
            f"recording, rms {c.fit_rms:.2f}": c.recording,
            f"robot, rms {c.robot_rms:.2f}": c.robot,
        }
        curves.append(Curve(f"{c.output}: automaton", "deg", [v for _, v in c.automaton], c.limits, others))
    blank = [""] * len(times)
    film = Film(times, blank, blank, (), (), (), ((0, 0), (0, 0)), curves)
    return joints(film)
