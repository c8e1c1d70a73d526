"""Panels one above the other over the bands of a clock: curves, bounds, jumps, what is violated and the margins."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from haverify.report.figures import svg
from haverify.report.figures.bands import Band, is_one_axis
from haverify.report.figures.curves import Curve
from haverify.report.figures.quantities import Quantity
from haverify.text.record import record

WIDTH, LEFT, RIGHT, TOP, HEIGHT, GAP, FOOT = 680.0, 58.0, 14.0, 42.0, 112.0, 26.0, 40.0

_OFF_SCALE = 6.0  # a curve so many times higher than what is in order is cut, with its ends said


@record
class Mark:
    """An instant to mark in the band of the first of some modes that holds it, with what to say of it.

    `is_bad` where it is a violation.
    """

    modes: tuple[str, ...]
    at: float
    text: str
    is_bad: bool


@record
class Panel:
    """One quantity, its curves, marks, the modes in which it violates its bounds, jumps (source, target) that do."""

    quantity: Quantity
    curves: Sequence[Curve]
    marks: Sequence[Mark] = ()
    bad: frozenset[str] = frozenset()


@record
class _Axis:
    """Where the bands stand from left to right: each has its own stretch."""

    places: tuple[tuple[Band, float, float], ...]
    is_one: bool

    def x(self, k: int, value: float) -> float:
        band, left, right = self.places[k]
        width = band.high - band.low
        return left + (right - left) * ((value - band.low) / width if width > 0 else 0.5)

    def index(self, band: Band) -> int:
        return next(k for k, (b, _, _) in enumerate(self.places) if b == band)


def draw(panels: Sequence[Panel], bands: Sequence[Band], clock: str, unit: str, title: str) -> str:
    """The drawing of some panels over the same bands."""
    axis = _axis(bands)
    height = TOP + len(panels) * (HEIGHT + GAP) - GAP + FOOT
    parts = _modes(axis, height - FOOT)
    for k, p in enumerate(panels):
        parts += _panel(p, axis, TOP + k * (HEIGHT + GAP))
    parts += _clock(axis, height - FOOT, f"{clock} [{unit}]" if unit not in ("", "1") else clock)
    return svg.drawing(WIDTH, height, parts, title)


def _axis(bands: Sequence[Band]) -> _Axis:
    """One axis where the bands follow each other, else stretches of one width side by side."""
    room, one = WIDTH - LEFT - RIGHT, is_one_axis(list(bands))
    low, high = min(b.low for b in bands), max(b.high for b in bands)
    if one and high > low:
        scale = room / (high - low)
        return _Axis(tuple((b, LEFT + (b.low - low) * scale, LEFT + (b.high - low) * scale) for b in bands), True)
    step = room / len(bands)
    return _Axis(tuple((b, LEFT + k * step + 4, LEFT + (k + 1) * step - 4) for k, b in enumerate(bands)), False)


def _modes(axis: _Axis, bottom: float) -> list[str]:
    """The bands with the names of the modes, as far as these fit."""
    parts = []
    for k, (band, left, right) in enumerate(axis.places):
        parts.append(svg.rect(left, 2, right - left, bottom - 2, f"band{k % 2}"))
        if svg.text_width(band.mode) <= right - left:
            parts.append(svg.label((left + right) / 2, 16, band.mode, "mode", "m"))
    return parts


def _clock(axis: _Axis, y: float, name: str) -> list[str]:
    parts = [svg.label((LEFT + WIDTH - RIGHT) / 2, y + 34, name, "axis", "m")]
    if axis.is_one:
        low, high = axis.places[0][0].low, axis.places[-1][0].high
        values = [(v, LEFT + (WIDTH - LEFT - RIGHT) * (v - low) / (high - low)) for v in svg.ticks(low, high, 10)]
    else:
        values = [(v, axis.x(k, v)) for k, (b, _, _) in enumerate(axis.places) for v in _ends(b, len(axis.places))]
    for value, x in values:
        parts.append(svg.line((x, y), (x, y + 4), "tick"))
        parts.append(svg.label(x, y + 17, svg.tick_text(value), "tick", "m"))
    return parts


def _ends(b: Band, count: int) -> list[float]:
    return [(b.low + b.high) / 2] if count > 6 else [b.low, b.high]


def _panel(p: Panel, axis: _Axis, top: float) -> list[str]:
    low, high = _range(p)

    scale = HEIGHT / (high - low)

    def y(value: float) -> float:
        return top + (high - value) * scale if low <= value <= high else top + (HEIGHT if value < low else 0.0)

    unit = p.quantity.unit
    name = f"{p.quantity.name} [{unit}]" if unit not in ("", "1") else p.quantity.name
    parts = [svg.rect(LEFT, top, WIDTH - LEFT - RIGHT, HEIGHT, "frame")]
    for value in svg.ticks(low, high, 5):
        parts.append(svg.line((LEFT, y(value)), (WIDTH - RIGHT, y(value)), "grid"))
        parts.append(svg.label(LEFT - 5, y(value) + 4, svg.tick_text(value), "tick", "e"))
    parts.append(svg.label(4, top - 8, name, "name"))
    for c in p.curves:
        parts += _curve(c, axis, low, high, y, c.band.mode in p.bad)
    parts += _jumps(p, axis, y)
    return parts + _marks(p, axis, y, top, low, high)


def _range(p: Panel) -> tuple[float, float]:
    """What the panel shows: curves and bounds, but of curves in violation no more than `_OFF_SCALE` times the rest."""
    bounds = [y for c in p.curves for line in c.bounds for _, y in line]
    fine = [y for c in p.curves if not any(c.is_bad) for _, y in c.points]
    every = [y for c in p.curves for _, y in c.points] + bounds
    core = bounds + fine or every
    low, high = min(core), max(core)
    is_far = max(every) - min(every) > _OFF_SCALE * max(high - low, 1e-9)
    if not is_far or high == low:
        low, high = min(every), max(every)
    room = (high - low) * (0.42 if is_far else 0.08) or max(abs(high), 1.0) * 0.1
    return low - room, high + room


def _curve(c: Curve, axis: _Axis, low: float, high: float, y: svg.Scale, is_bad: bool) -> list[str]:
    k = axis.index(c.band)
    parts = [svg.polyline([(axis.x(k, x), y(v)) for x, v in _ends_only(line)], "bound") for line in c.bounds]
    inside = [(x, v) for x, v in c.points if low <= v <= high]
    if not inside:
        return parts + _off_scale(c, axis.places[k], y)
    points = [(axis.x(k, x), y(v)) for x, v in c.points]
    parts.append(svg.polyline(points, "curve"))
    for first, last in _stretches(c.is_bad):
        parts.append(svg.polyline(points[first : last + 1], "curve bad"))
    return parts


def _off_scale(c: Curve, place: tuple[Band, float, float], y: svg.Scale) -> list[str]:
    """A curve that is nowhere on the scale: its ends in figures at the rim."""
    values = [v for _, v in c.points]
    is_above = values[0] > 0
    rim = y(1e18 if is_above else -1e18)
    _, left, right = place
    parts = [svg.line((left, rim), (right, rim), "curve bad")]
    sign = "\N{UPWARDS ARROW}" if is_above else "\N{DOWNWARDS ARROW}"
    texts = [f"{sign} {_short(min(values))}", f"to {_short(max(values))}"]
    if svg.text_width(texts[0]) > right - left + 14:
        texts = [sign]
    lift = 14 if is_above else -8 - 13 * (len(texts) - 1)
    return parts + [svg.label((left + right) / 2, rim + lift + 13 * n, t, "said bad", "m") for n, t in enumerate(texts)]


def _short(x: float) -> str:
    return f"{x:.4g}" if abs(x) < 1000 else f"{x:.0f}" if abs(x) < 1e7 else f"{x:.2e}"


def _ends_only(line: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
    """A level line needs its two ends only."""
    return (line[0], line[-1]) if all(v == line[0][1] for _, v in line) else line


def _stretches(flags: Sequence[bool]) -> list[tuple[int, int]]:
    """Where flags are set: first and last index of each stretch, at least two points wide."""
    found, start = [], None
    for k, flag in enumerate([*flags, False]):
        if flag and start is None:
            start = k
        elif not flag and start is not None:
            found.append((max(0, min(start, len(flags) - 2)), max(k - 1, start + 1)))
            start = None
    return found


def _jumps(p: Panel, axis: _Axis, y: svg.Scale) -> list[str]:
    """Where one band ends and the next begins on one axis: the step from the one value to the other."""
    parts = []
    for a, b in pairwise(p.curves) if axis.is_one else ():
        if abs(b.band.low - a.band.high) <= 1e-6 * max(1.0, abs(b.band.low)):
            x = axis.x(axis.index(b.band), b.band.low)
            is_bad = f"{a.band.mode} -> {b.band.mode}" in p.bad
            first, last = y(a.points[-1][1]), y(b.points[0][1])
            if abs(first - last) > 0.5 or is_bad:
                parts.append(svg.line((x, first), (x, last), "jump bad" if is_bad else "jump"))
    return parts


def _value(c: Curve, at: float) -> float:
    """The value at an instant, between two samples on the line that is drawn."""
    for (x, y), (u, v) in pairwise(c.points):
        if x <= at <= u and u > x:
            return y + (v - y) * (at - x) / (u - x)
    return c.points[0][1] if at < c.points[0][0] else c.points[-1][1]


def _holds(b: Band, mode: str, at: float) -> bool:
    tiny = 1e-5 * max(1.0, abs(at))  # instants are rounded for people
    return b.mode == mode and b.low - tiny <= at <= b.high + tiny


def _marks(p: Panel, axis: _Axis, y: svg.Scale, top: float, low: float, high: float) -> list[str]:
    """The marks on the scale; of what is off it the rim tells."""
    parts = []
    for m in p.marks:
        c = next((c for mode in m.modes for c in p.curves if _holds(c.band, mode, m.at)), None)
        value = _value(c, m.at) if c else low
        if c is None or not low < value < high:
            continue
        x, at = axis.x(axis.index(c.band), m.at), y(value)
        parts.append(svg.circle((x, at), 3.5, "mark bad" if m.is_bad else "mark"))
        if not m.text:
            continue
        anchor = "e" if x > WIDTH - RIGHT - 1.1 * svg.text_width(m.text) - 8 else ""
        above = at > top + HEIGHT / 2
        kind = "said bad" if m.is_bad else "said"
        parts.append(svg.label(x + (-7 if anchor else 7), at + (-7 if above else 16), m.text, kind, anchor))
    return parts
