"""A walk as orbits and as sticks: angles against their velocities, and the legs at some instants of the cycle."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from haverify.report.figures import svg
from haverify.report.figures.svg import Point
from haverify.text.record import record

_SIDE, _GAP, _LEFT, _TOP = 190.0, 62.0, 56.0, 26.0
_LINKS = (0.245, 0.246, 0.152)  # thigh, shank, foot as shares of body height
_ACROSS = 960.0


@record
class Orbit:
    """A joint's name, its closed curve of angle (deg) and velocity (deg/s), and where the cycle begins."""

    name: str
    points: tuple[Point, ...]


def orbits(found: Sequence[Orbit], title: str) -> str:
    """The orbits side by side in rows of three: velocity over angle; a dot where the cycle begins."""
    rows = -(-len(found) // 3)
    parts: list[str] = []
    for k, o in enumerate(found):
        parts += _orbit(o, _LEFT + (k % 3) * (_SIDE + _GAP), _TOP + (k // 3) * (_SIDE + _GAP))
    return svg.drawing(3 * (_SIDE + _GAP) + 10, rows * (_SIDE + _GAP) + _TOP, parts, title)


def _orbit(o: Orbit, left: float, top: float) -> list[str]:
    low, high = (tuple(f(p[i] for p in o.points) for i in (0, 1)) for f in (min, max))
    room = tuple((b - a or 1.0) * 0.06 for a, b in zip(low, high, strict=True))

    def at(p: Point) -> Point:
        x, y = ((p[i] - low[i] + room[i]) / (high[i] - low[i] + 2 * room[i]) for i in (0, 1))
        return left + _SIDE * x, top + _SIDE * (1 - y)

    parts = [svg.rect(left, top, _SIDE, _SIDE, "frame"), svg.label(left, top - 6, o.name, "name")]
    for x in svg.ticks(low[0], high[0], 5):
        parts.append(svg.label(at((x, low[1]))[0], top + _SIDE + 14, svg.tick_text(x), "tick", "m"))
    for y in svg.ticks(low[1], high[1], 5):
        parts.append(svg.label(left - 5, at((low[0], y))[1] + 4, svg.tick_text(y), "tick", "e"))
    parts.append(svg.label(left + _SIDE / 2, top + _SIDE + 29, "deg/s over deg", "axis", "m"))
    closed = [at(p) for p in (*o.points, o.points[0])]
    return [*parts, svg.polyline(closed, "curve"), svg.circle(at(o.points[0]), 3.5, "mark")]


def sticks(poses: Sequence[Mapping[str, float]], names: Sequence[str], title: str) -> str:
    """Both legs at some instants, from left to right: `poses` in degrees by joint, `names` below them.

    The right leg is drawn in ink, the left in blue, small enough to stand side by side; the trunk is upright.
    """
    edge, scale = 60.0, 150.0
    step = (_ACROSS - 2 * edge) / max(len(poses) - 1, 1)
    parts = [svg.line((0, 20 + scale * 0.72), (_ACROSS, 20 + scale * 0.72), "grid")]
    for k, (pose, name) in enumerate(zip(poses, names, strict=True)):
        hip = (edge + k * step, 20 + scale * 0.18)
        low = max(max(y for _, y in _leg(pose, side, hip, scale)) for side in "lr")
        down = 20 + scale * 0.72 - low
        hip = (hip[0], hip[1] + down)
        parts.append(svg.polyline([(hip[0], hip[1] - scale * 0.16), hip], "origin"))
        parts += [svg.polyline(_leg(pose, side, hip, scale), kind) for side, kind in (("l", "curve"), ("r", "origin"))]
        parts.append(svg.label(hip[0], 20 + scale * 0.72 + 18, name, "tick", "m"))
    foot = 20 + scale * 0.72 + 40
    for x, kind, name in ((edge, "curve", "left"), (edge + 80, "origin", "right")):
        parts += [svg.line((x, foot - 4), (x + 22, foot - 4), kind), svg.label(x + 27, foot, name)]
    return svg.drawing(_ACROSS, foot + 8, parts, title)


def _leg(pose: Mapping[str, float], side: str, hip: Point, scale: float) -> list[Point]:
    """Hip, knee, ankle, toe; x forward, y down."""
    at, turned, points = hip, 0.0, [hip]
    for joint, length in zip("hka", _LINKS, strict=True):
        turned += pose[side + joint] + (90.0 if joint == "a" else 0.0)
        along = scale * length
        at = (at[0] + along * math.sin(math.radians(turned)), at[1] + along * math.cos(math.radians(turned)))
        points.append(at)
    return points
