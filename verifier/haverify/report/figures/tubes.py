"""Drawings of flowpipes: variables over time, and one variable over another; boxes as areas, runs as lines."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from math import hypot

from haverify.report.figures import svg
from haverify.report.figures.pipes import Level, Pair, Piece, Pipe, Step
from haverify.report.figures.sampled import Trail

WIDTH, LEFT, RIGHT, TOP, HEIGHT, GAP, FOOT = 680.0, 58.0, 14.0, 30.0, 120.0, 26.0, 40.0
SIDE = 340.0  # of a portrait

_FINE = 0.75  # pixels up to which neighbouring boxes are drawn as one


def over_time(
    pipe: Pipe, names: Sequence[str], said: dict[str, str], of: Sequence[Level], runs: Sequence[Trail]
) -> str:
    """A panel for each variable; `said` has their names with units."""
    end = pipe.end
    bottom = TOP + len(names) * (HEIGHT + GAP) - GAP

    def x(t: float) -> float:
        return LEFT + (WIDTH - LEFT - RIGHT) * min(t, end) / end

    parts = _legend(pipe)
    for k, name in enumerate(names):
        levels = [level for level in of if level.name == name]
        top = TOP + k * (HEIGHT + GAP)
        parts += _panel(pipe, name, said[name], levels, [(r, x) for r in runs], top)
    for value in svg.ticks(0.0, end, 10):
        parts.append(svg.line((x(value), bottom), (x(value), bottom + 4), "tick"))
        parts.append(svg.label(x(value), bottom + 17, svg.tick_text(value), "tick", "m"))
    parts.append(svg.label((LEFT + WIDTH - RIGHT) / 2, bottom + 34, "t [s]", "axis", "m"))
    return svg.drawing(WIDTH, bottom + FOOT, parts, "the flowpipe over time")


def _legend(pipe: Pipe) -> list[str]:
    """The names of the modes in their colours, where there are several."""
    parts, at = list[str](), LEFT
    for k, mode in enumerate(pipe.modes if len(pipe.modes) > 1 else ()):
        parts.append(svg.label(at, 14, mode, f"said s{k % 10}"))
        at += svg.text_width(mode) + 18
    return parts


def _panel(
    pipe: Pipe, name: str, said: str, levels: Sequence[Level], runs: Sequence[tuple[Trail, svg.Scale]], top: float
) -> list[str]:
    low, high = _room(pipe.range(name), levels)
    y = _scale(low, high, top + HEIGHT, top)

    def x(t: float) -> float:
        return LEFT + (WIDTH - LEFT - RIGHT) * min(t, pipe.end) / pipe.end

    parts = [svg.rect(LEFT, top, WIDTH - LEFT - RIGHT, HEIGHT, "frame"), svg.label(4, top - 8, said, "name")]
    for value in svg.ticks(low, high, 5):
        parts.append(svg.line((LEFT, y(value)), (WIDTH - RIGHT, y(value)), "grid"))
        parts.append(svg.label(LEFT - 5, y(value) + 4, svg.tick_text(value), "tick", "e"))
    for p in pipe.pieces:
        parts.append(svg.path(_area(p, name, x, y), f"tube f{pipe.modes.index(p.mode) % 10}"))
    for run, across in runs:
        points = [(across(t), y(s[name])) for t, s in zip(run.times, run.states, strict=True)]
        parts.append(svg.polyline(_thinned(points), "trail"))
    for level in levels:
        ends = x(level.first), x(pipe.end if level.last is None else min(level.last, pipe.end))
        parts.append(svg.line((ends[0], y(level.value)), (max(ends[1], ends[0] + 4), y(level.value)), level.kind))
    return parts


def _room(shown: Pair, levels: Sequence[Level]) -> Pair:
    """What a panel shows: the boxes, and levels unless these are far away."""
    low, high = shown
    size = max(high - low, 1e-9 * max(abs(low), abs(high)), 1e-300)
    for level in levels:
        if low - 3 * size <= level.value <= high + 3 * size:
            low, high = min(low, level.value), max(high, level.value)
    room = 0.08 * max(high - low, size)
    return low - room, high + room


def _scale(low: float, high: float, first: float, last: float) -> svg.Scale:
    """From values to pixels; what is beyond stays at the rim."""

    def at(value: float) -> float:
        return first + (last - first) * (min(max(value, low), high) - low) / (high - low)

    return at


def _area(p: Piece, name: str, x: svg.Scale, y: svg.Scale) -> list[str | float]:
    """The boxes of a variable over time as one area: its upper rim there, its lower rim back."""
    steps = list(_coarser(rims(p.steps, name), y))
    d: list[str | float] = ["M", x(steps[0][0][0])]
    for k, (time, (_, high)) in enumerate(steps):
        d += [y(high)] if k == 0 else ["V", y(high)]
        d += ["H", x(time[1])]
    for time, (low, _) in reversed(steps):
        d += ["V", y(low), "H", x(time[0])]
    return [*d, "Z"]


def rims(steps: Sequence[Step], name: str) -> list[tuple[Pair, Pair]]:
    """Stretches of time one after the other, each with the least range around all boxes that share it.

    After a jump whose instant is known to lie in a range only, the instants of steps overlap.
    """
    ends = sorted({t for s in steps for t in s.time})
    found = []
    for time in pairwise(ends) if len(ends) > 1 else [(ends[0], ends[0])]:
        boxes = [s.box[name] for s in steps if s.time[0] <= time[0] and time[1] <= s.time[1]]
        if boxes:
            found.append((time, (min(low for low, _ in boxes), max(high for _, high in boxes))))
    return found


def _coarser(steps: Sequence[tuple[Pair, Pair]], y: svg.Scale) -> Iterator[tuple[Pair, Pair]]:
    """Neighbours joined where nobody would see the difference."""
    (time, (low, high)) = steps[0]
    first = low, high
    for (start, end), (a, b) in steps[1:]:
        near = all(abs(y(v) - y(w)) < _FINE for v, w in ((a, low), (b, high), (a, first[0]), (b, first[1])))
        if near:
            time, low, high = (time[0], end), min(low, a), max(high, b)
        else:
            yield time, (low, high)
            time, low, high, first = (start, end), a, b, (a, b)
    yield time, (low, high)


def _thinned(points: Sequence[svg.Point]) -> list[svg.Point]:
    """A line without the points that lie within a fraction of a pixel of it."""
    kept, start = [points[0]], 0
    for k in range(2, len(points)):
        if any(_off(points[start], points[k], p) > 0.3 for p in points[start + 1 : k]):
            kept.append(points[k - 1])
            start = k - 1
    return [*kept, points[-1]]


def _off(a: svg.Point, b: svg.Point, p: svg.Point) -> float:
    """How far a point is from the line through two others."""
    (x, y), (u, v) = (b[0] - a[0], b[1] - a[1]), (p[0] - a[0], p[1] - a[1])
    length = hypot(x, y)
    return abs(x * v - y * u) / length if length > 1e-9 else hypot(u, v)


def portrait(
    pipe: Pipe, pair: tuple[str, str], said: dict[str, str], of: Sequence[Level], runs: Sequence[Trail]
) -> str:
    """The second variable of a pair over the first."""
    levels = {name: [level for level in of if level.name == name] for name in pair}
    (a, b), (c, d) = (_room(pipe.range(name), levels[name]) for name in pair)
    right, bottom = LEFT + 1.5 * SIDE, TOP + SIDE
    x, y = _scale(a, b, LEFT, right), _scale(c, d, bottom, TOP)
    parts = [
        *_legend(pipe),
        svg.rect(LEFT, TOP, right - LEFT, SIDE, "frame"),
        svg.label(4, TOP - 8, said[pair[1]], "name"),
    ]
    parts += _grid((a, b), (c, d), x, y)
    for p in pipe.pieces:
        parts.append(svg.path(list(_boxes(p, pair, x, y)), f"tube f{pipe.modes.index(p.mode) % 10}"))
    for run in runs:
        points = [(x(s[pair[0]]), y(s[pair[1]])) for s in run.states]
        parts.append(svg.polyline(_thinned(points), "trail"))
    parts += [_box(p.start, pair, x, y) for p in pipe.pieces if p.jumps == 0]
    parts += [svg.line((x(v.value), TOP), (x(v.value), bottom), v.kind) for v in levels[pair[0]]]
    parts += [svg.line((LEFT, y(v.value)), (right, y(v.value)), v.kind) for v in levels[pair[1]]]
    parts.append(svg.label((LEFT + right) / 2, bottom + 34, said[pair[0]], "axis", "m"))
    return svg.drawing(WIDTH, bottom + FOOT, parts, f"{pair[1]} over {pair[0]}")


def _grid(across: Pair, up: Pair, x: svg.Scale, y: svg.Scale) -> list[str]:
    parts = []
    for value in svg.ticks(*across, 8):
        parts.append(svg.line((x(value), TOP), (x(value), TOP + SIDE), "grid"))
        parts.append(svg.label(x(value), TOP + SIDE + 17, svg.tick_text(value), "tick", "m"))
    for value in svg.ticks(*up, 7):
        parts.append(svg.line((LEFT, y(value)), (LEFT + 1.5 * SIDE, y(value)), "grid"))
        parts.append(svg.label(LEFT - 5, y(value) + 4, svg.tick_text(value), "tick", "e"))
    return parts


def _boxes(p: Piece, pair: tuple[str, str], x: svg.Scale, y: svg.Scale) -> Iterator[str | float]:
    """The boxes of a piece as one area; a box within the one before it adds nothing."""
    last = (0.0, 0.0, 0.0, 0.0)
    for s in p.steps:
        (a, b), (c, d) = (s.box[name] for name in pair)
        box = x(a), x(b), y(d), y(c)
        if last[0] <= box[0] and box[1] <= last[1] and last[2] <= box[2] and box[3] <= last[3]:
            continue
        last = box
        yield from ("M", box[0], box[2], "H", box[1], "V", box[3], "H", box[0], "Z")


def _box(
    start: dict[str, Pair], pair: tuple[str, str], x: Callable[[float], float], y: Callable[[float], float]
) -> str:
    (a, b), (c, d) = (start[name] for name in pair)
    return svg.rect(x(a), y(d), max(x(b) - x(a), 1.0), max(y(c) - y(d), 1.0), "origin")
