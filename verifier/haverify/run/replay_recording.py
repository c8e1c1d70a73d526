"""Recordings in a replay: one that is replayed itself, or one that the automaton is compared with."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from types import MappingProxyType

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.recordings.read import SUFFIXES
from haverify.report.figures.robot import Curve, Film, joints
from haverify.robot.comparison import Compared
from haverify.robot.mapping import CURVE
from haverify.run.recordings import recorded
from haverify.text.record import record, replace
from haverify.text.source import Source


@record
class Angles:
    """A recording in floats, in deg, by the names of the gait's outputs; the file read and what is wrong with it."""

    times: Sequence[float]
    values: Mapping[str, Sequence[float]]
    source: Source | None
    found: list[Diagnostic]
    notes: Sequence[str] = ()  # what was filled in


def is_recording(path: str) -> bool:
    """Whether a path names a recording rather than a spec."""
    return path.lower().endswith(SUFFIXES)


def angles_of(path: str, wanted: Sequence[str], fill: Mapping[str, Fraction | None] = MappingProxyType({})) -> Angles:
    """The wanted angles of a recording, each at every instant, or findings.

    `fill` says in deg what an angle is where it is missing; None: on a curve through its samples.
    """
    got = recorded([path], absent=fill)
    source = next(iter(got.sources.values()), None)
    if not got.recordings:
        said = "replay also takes a recording without it if the map says what it is, in deg: [missing] la = 0"
        found = [replace(d, notes=(*d.notes, said)) if d.code == "HA224" else d for d in got.found]
        found = found or [Diagnostic("HA210", f"{path} holds no joint angles")]
        return Angles((), {}, source, found)
    r = got.recordings[0]
    if len(r.times) < 4:
        few = Diagnostic("HA210", f"{path} has {len(r.times)} samples, too few for a spline")
        return Angles((), {}, source, [few])
    values, told, found = {}, [], []
    for name in wanted:
        gaps = [k for k, v in enumerate(r.angles[name]) if v is None]
        values[name] = r.near[name]
        if gaps and name in fill and (fill[name] is not None or len(r.times) - len(gaps) >= 4):
            values[name] = _filled(r.clock, r.near[name], gaps, fill[name])
            told.append(_told(name, len(gaps), len(r.times), fill[name]))
        elif gaps:
            found.append(_gap(path, name, gaps, r.clock, list(got.found)))
    if found:
        return Angles((), {}, source, found)
    return Angles(r.clock, values, source, [], told)


def _told(name: str, gaps: int, samples: int, fill: Fraction | None) -> str:
    how = "on a curve through the others" if fill is None else f"taken as {float(fill):g} deg"
    return f"`{name}` is missing at {gaps} of {samples} instants: {how}, as [missing] of the map says"


def _gap(path: str, name: str, gaps: Sequence[int], clock: Sequence[float], found: Sequence[Diagnostic]) -> Diagnostic:
    place = next((d.span for d in found if d.code == "HA222"), None)
    message = (
        f"{path}: the angle `{name}` is missing at {len(gaps)} of {len(clock)} instants, first at {clock[gaps[0]]:g} s"
    )
    if len(clock) - len(gaps) < 4:
        return Diagnostic("HA210", message, place, help=f"say in the map what it is, in deg: [missing] {name} = 0")
    return Diagnostic("HA210", message, place, help=f'say in the map what to take: [missing] {name} = "{CURVE}", or 0')


def _filled(
    clock: Sequence[float], values: Sequence[float], gaps: Sequence[int], fill: Fraction | None
) -> tuple[float, ...]:
    """An angle without gaps; before its first sample and after its last it stays as it is there."""
    if fill is not None:
        return tuple(float(fill) if k in set(gaps) else v for k, v in enumerate(values))
    from scipy.interpolate import CubicSpline

    known = [k for k in range(len(clock)) if k not in set(gaps)]
    curve = CubicSpline([clock[k] for k in known], [values[k] for k in known])
    first, last = clock[known[0]], clock[known[-1]]
    return tuple(float(curve(min(max(t, first), last))) for t in clock)


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
    film = Film(times, rows[0].modes, [""] * len(times), (), (), (), ((0, 0), (0, 0)), curves)
    return joints(film)
