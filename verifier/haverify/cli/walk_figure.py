"""The figure of a fit: recorded samples as dots, held-out ones in another colour, the curves of the spec."""

from __future__ import annotations

from haverify.fitting.curve import Curve
from haverify.fitting.walk import Walk
from haverify.recordings.cycles import Cycle
from haverify.recordings.phases import PHASES
from haverify.recordings.recording import told
from haverify.report.figures.overlay import Pane, Series, overlay
from haverify.report.figures.strides import Orbit, orbits, sticks
from haverify.report.figures.svg import Point
from haverify.report.html.style import standalone

_MOST = 2000  # samples that are drawn for each joint


def walk_figure(walk: Walk, stem: str) -> str:
    """A pane for each joint, left leg to the left."""
    at = walk.knots.at
    bands = [(name, float(a), float(b)) for name, a, b in zip(PHASES, at, at[1:], strict=False)]
    panes = [_pane(walk, c) for c in walk.curves]
    names = ["recorded", "fitted", *(["held out"] if walk.held_out else [])]
    return standalone(overlay(panes, names, bands, "time since heel strike [s]", f"Walk {stem}"))


def orbit_figure(walk: Walk, stem: str) -> str:
    """Angle against velocity of each joint: closed, since the curves are."""
    import numpy as np

    t = np.linspace(0, float(walk.knots.period), 361)[:-1]
    found = [Orbit(told(c.joint), tuple(zip(c.at(t).tolist(), c.at(t, 1).tolist(), strict=True))) for c in walk.curves]
    return standalone(orbits(found, f"Orbits of walk {stem}"))


def stick_figure(walk: Walk, stem: str) -> str:
    """Both legs at tenths of the cycle."""
    import numpy as np

    shares = np.linspace(0, 1, 11)
    t = np.minimum(shares * float(walk.knots.period), float(walk.knots.period) * (1 - 1e-9))
    angles = {c.joint: c.at(t).tolist() for c in walk.curves}
    poses = [{j: angles[j][k] for j in angles} for k in range(len(t))]
    return standalone(sticks(poses, [f"{s:.0%}" for s in shares], f"Sticks of walk {stem}"))


def _pane(walk: Walk, c: Curve) -> Pane:
    import numpy as np

    series = [_dots(walk.training, c, 0)]
    if walk.held_out:
        series.append(_dots(walk.held_out, c, 2))
    t = np.linspace(0, float(walk.knots.period) * (1 - 1e-9), 401)
    curve = Series(tuple(zip(t.tolist(), c.at(t).tolist(), strict=True)), 1)
    low, high = _band(walk, c.joint)
    return Pane(
        f"{told(c.joint)} [deg]", (*series, curve) if len(series[0].points) > 300 else (curve, *series), low, high
    )


def _band(walk: Walk, joint: str) -> tuple[tuple[Point, ...], tuple[Point, ...]]:
    """The lower and the upper edge of the band of 95 %, where there is one."""
    t = [k / 100 * float(walk.knots.period) for k in range(101)]
    for b in walk.bands:
        if b.joint == joint:
            return tuple(zip(t, b.low.tolist(), strict=True)), tuple(zip(t, b.high.tolist(), strict=True))
    return (), ()


def _dots(cycles: tuple[Cycle, ...], c: Curve, kind: int) -> Series:
    period = float(c.knots.period)
    points = [(s * period, a) for cycle in cycles for s, a in zip(*cycle.near[c.joint], strict=True)]
    return Series(tuple(points[:: max(1, len(points) // _MOST)]), kind, True)
