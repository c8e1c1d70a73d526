"""Drawings of simulated runs: quantities over time with bands of modes, and orbits in the plane with a vector field."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from haverify.report.figures import svg
from haverify.simulate.traces import Slope, Trace
from haverify.text.record import record

WIDTH, LEFT, RIGHT, TOP, HEIGHT, GAP, FOOT = 680.0, 62.0, 16.0, 42.0, 112.0, 26.0, 42.0
COLOURS = 10
BANDS = 60  # more stays than this are drawn without bands
SQUARE = 470.0
ARROWS = 19


Run = Sequence[Trace]


@record
class Frame:
    """Where numbers stand in a rectangle."""

    left: float
    top: float
    width: float
    height: float
    x: tuple[float, float]
    y: tuple[float, float]

    def at(self, x: float, y: float) -> svg.Point:
        """The place of a pair of numbers."""
        along = (x - self.x[0]) / (self.x[1] - self.x[0])
        up = (y - self.y[0]) / (self.y[1] - self.y[0])
        return self.left + self.width * along, self.top + self.height * (1 - up)


def over_time(names: Sequence[str], runs: Sequence[Run], title: str) -> str:
    """A panel for each quantity; the bands are the modes of the first run."""
    ends = [s.times for run in runs for s in run if s.times]
    low, high = min(t[0] for t in ends), max(t[-1] for t in ends)
    high = high if high > low else low + 1.0
    height = TOP + len(names) * (HEIGHT + GAP) - GAP + FOOT
    parts = _bands(runs[0], (low, high), height - FOOT)
    for k, name in enumerate(names):
        parts += _panel(name, k, runs, (low, high), TOP + k * (HEIGHT + GAP))
    parts += _time_axis((low, high), height - FOOT)
    return svg.drawing(WIDTH, height, parts, title)


def _bands(run: Run, span: tuple[float, float], bottom: float) -> list[str]:
    """The modes of a run as bands, with their names where there is room."""
    scale = (WIDTH - LEFT - RIGHT) / (span[1] - span[0])
    kinds: dict[str, int] = {}
    stays = [s for s in run if s.times and s.times[-1] > s.times[0]]
    if len(stays) > BANDS or len({s.mode for s in stays}) < 2:
        return []
    parts = []
    for s in stays:
        left, width = LEFT + (s.times[0] - span[0]) * scale, (s.times[-1] - s.times[0]) * scale
        kind = kinds.setdefault(s.mode, len(kinds))
        parts.append(svg.rect(left, 2, width, bottom - 2, f"band{kind % 2}"))
        if svg.text_width(s.mode) + 4 <= width:
            parts.append(svg.label(left + width / 2, 16, s.mode, "mode", "m"))
    return parts


def _panel(name: str, k: int, runs: Sequence[Run], span: tuple[float, float], top: float) -> list[str]:
    frame = Frame(LEFT, top, WIDTH - LEFT - RIGHT, HEIGHT, span, _range(runs, k))
    parts = [svg.rect(frame.left, top, frame.width, HEIGHT, "frame"), svg.label(4, top - 8, name, "name")]
    for value in svg.ticks(*frame.y, 5):
        y = frame.at(span[0], value)[1]
        parts.append(svg.line((LEFT, y), (WIDTH - RIGHT, y), "grid"))
        parts.append(svg.label(LEFT - 5, y + 4, svg.tick_text(value), "tick", "e"))
    for number, run in enumerate(runs):
        parts += list(_curves(run, k, frame, f"term t{number % COLOURS}"))
    return parts


def _curves(run: Run, k: int, frame: Frame, kind: str) -> Iterator[str]:
    """One line for each stay, and where a jump moves the quantity a dotted one."""
    last: svg.Point | None = None
    for s in run:
        points = [frame.at(t, v) for t, v in zip(s.times, s.values[k], strict=True) if math.isfinite(v)]
        if not points:
            last = None
            continue
        if last is not None and math.dist(last, points[0]) > 1.5:
            yield svg.line(last, points[0], "jump")
        yield svg.polyline(points, kind)
        last = points[-1]


def _range(runs: Sequence[Run], k: int) -> tuple[float, float]:
    values = [v for run in runs for s in run for v in s.values[k] if math.isfinite(v)]
    low, high = min(values, default=0.0), max(values, default=1.0)
    room = 0.07 * (high - low) or max(abs(high), 1.0) * 0.1
    return low - room, high + room


def _time_axis(span: tuple[float, float], y: float) -> list[str]:
    parts = [svg.label((LEFT + WIDTH - RIGHT) / 2, y + 35, "time [s]", "axis", "m")]
    for value in svg.ticks(*span, 10):
        x = LEFT + (WIDTH - LEFT - RIGHT) * (value - span[0]) / (span[1] - span[0])
        parts.append(svg.line((x, y), (x, y + 4), "tick"))
        parts.append(svg.label(x, y + 17, svg.tick_text(value), "tick", "m"))
    return parts


def in_plane(names: tuple[str, str], runs: Sequence[Run], slopes: Sequence[Slope], title: str, orbit: Run = ()) -> str:
    """Orbits of two quantities; `slopes` are drawn as short arrows of one length, a periodic orbit over faint runs."""
    x = _range([*runs, orbit], 0) if runs else _hull([s[0] for s in slopes])
    y = _range([*runs, orbit], 1) if runs else _hull([s[1] for s in slopes])
    frame = Frame(LEFT, 28.0, SQUARE, SQUARE * 0.8, x, y)
    parts = [svg.rect(frame.left, frame.top, frame.width, frame.height, "frame"), *_axes(frame, names)]
    parts += [p for s in slopes if (p := _arrow(s, frame)) is not None]
    faint = " under" if orbit else ""
    for number, run in enumerate(runs):
        parts += _course(run, frame, f"term t{number % COLOURS}{faint}")
        if run and run[0].times:
            parts.append(svg.circle(frame.at(run[0].values[0][0], run[0].values[1][0]), 3.0, "mark"))
    parts += _course(orbit, frame, "orbit")
    return svg.drawing(LEFT + SQUARE + 20, frame.top + frame.height + 44, parts, title)


def _course(run: Run, frame: Frame, kind: str) -> Iterator[str]:
    """One line for each stay, and a dotted one for each jump that moves the state."""
    last: svg.Point | None = None
    for s in run:
        points = [frame.at(a, b) for a, b in zip(s.values[0], s.values[1], strict=True)]
        if last is not None and math.dist(last, points[0]) > 1.5:
            yield svg.line(last, points[0], "jump")
        yield svg.polyline(points, kind)
        last = points[-1]


def _hull(values: Sequence[float]) -> tuple[float, float]:
    low, high = min(values, default=0.0), max(values, default=1.0)
    return (low, high) if high > low else (low - 1, high + 1)


def _axes(frame: Frame, names: tuple[str, str]) -> list[str]:
    bottom = frame.top + frame.height
    parts = [
        svg.label(frame.left + frame.width / 2, bottom + 36, names[0], "name", "m"),
        svg.label(4, frame.top - 10, names[1], "name"),
    ]
    for value in svg.ticks(*frame.x, 8):
        x, _ = frame.at(value, frame.y[0])
        parts += [svg.line((x, bottom), (x, bottom + 4), "tick"), svg.line((x, frame.top), (x, bottom), "grid")]
        parts.append(svg.label(x, bottom + 17, svg.tick_text(value), "tick", "m"))
    for value in svg.ticks(*frame.y, 8):
        _, y = frame.at(frame.x[0], value)
        parts.append(svg.line((frame.left, y), (frame.left + frame.width, y), "grid"))
        parts.append(svg.label(frame.left - 5, y + 4, svg.tick_text(value), "tick", "e"))
    return parts


def _arrow(slope: Slope, frame: Frame) -> str | None:
    """An arrow of one length on the page; None where there is no direction."""
    x, y, dx, dy = slope
    along, up = dx * frame.width / (frame.x[1] - frame.x[0]), dy * frame.height / (frame.y[1] - frame.y[0])
    length = math.hypot(along, up)
    if not math.isfinite(length) or length == 0:
        return None
    ux, uy = along / length, -up / length
    (a, b), reach = frame.at(x, y), 0.36 * frame.width / ARROWS
    tip, tail = (a + reach * ux, b + reach * uy), (a - reach * ux, b - reach * uy)
    left = (tip[0] - 4 * ux - 2.6 * uy, tip[1] - 4 * uy + 2.6 * ux)
    right = (tip[0] - 4 * ux + 2.6 * uy, tip[1] - 4 * uy - 2.6 * ux)
    return svg.path(["M", *tail, "L", *tip, "M", *left, "L", *tip, "L", *right], "arrow")
