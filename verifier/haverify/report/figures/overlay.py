"""Several curves over the bands of a clock in each of some panes: what was recorded against what is modelled."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from haverify.report.figures import svg
from haverify.report.figures.svg import Point
from haverify.text.record import record

Place = Callable[[Point], Point]

WIDTH, HEIGHT, LEFT, GAP, TOP, FOOT = 380.0, 170.0, 46.0, 46.0, 24.0, 42.0

_FEW = 300  # samples that are drawn as dots one can tell apart


@record
class Series:
    """Points of one curve; `kind` is the number of its colour, `is_dotted` draws single samples."""

    points: tuple[Point, ...]
    kind: int
    is_dotted: bool = False


@record
class Pane:
    """One quantity: its name with unit, its curves, and a band between two of them if there is one."""

    name: str
    series: tuple[Series, ...]
    low: tuple[Point, ...] = ()
    high: tuple[Point, ...] = ()


def overlay(
    panes: Sequence[Pane],
    names: Sequence[str],
    bands: Sequence[tuple[str, float, float]],
    clock: str,
    title: str,
    across: int = 2,
) -> str:
    """The drawing: panes in rows of `across`, over the same bands; `names` explain the colours."""
    rows = -(-len(panes) // across)
    width, height = across * (WIDTH + 10) + 10, TOP + rows * (HEIGHT + GAP) + FOOT
    parts = []
    for k, pane in enumerate(panes):
        left, top = (k % across) * (WIDTH + 10) + LEFT, TOP + (k // across) * (HEIGHT + GAP) + 8
        parts += _pane(pane, bands, left, top)
        if k + across >= len(panes):
            parts += _clock(bands, left, top + HEIGHT, clock)
    x = LEFT
    for k, name in enumerate(names):
        parts.append(_sample(panes, k, x, height - 10))
        parts.append(svg.label(x + 27, height - 6, name))
        x += 44 + svg.text_width(name)
    return svg.drawing(width, height, parts, title)


def _sample(panes: Sequence[Pane], kind: int, x: float, y: float) -> str:
    """What a kind of series looks like: a dot or a piece of curve."""
    if any(s.is_dotted for pane in panes for s in pane.series if s.kind == kind):
        return svg.circle((x + 14, y), 3.0, f"f{kind % 10}")
    return svg.line((x, y), (x + 22, y), _kind(kind))


def _kind(kind: int) -> str:
    """The classes of a curve: the first is broad, so that it shows beneath others that coincide with it."""
    return f"term t{kind % 10}" + (" broad" if kind == 0 else "")


def _pane(pane: Pane, bands: Sequence[tuple[str, float, float]], left: float, top: float) -> list[str]:
    first, last = bands[0][1], bands[-1][2]
    ys = [y for s in pane.series for _, y in s.points] + [y for _, y in (*pane.low, *pane.high)]
    low, high = (min(ys), max(ys)) if ys else (0.0, 1.0)
    low, high = low - 0.06 * (high - low or 1), high + 0.06 * (high - low or 1)
    room = WIDTH - LEFT

    def at(p: Point) -> Point:
        return left + room * (p[0] - first) / (last - first), top + HEIGHT * (high - p[1]) / (high - low)

    parts = [_band(b, k, at, top) for k, b in enumerate(bands)]
    parts += [svg.label((at((a, 0))[0] + at((b, 0))[0]) / 2, top + HEIGHT + 11, n, "tick", "m") for n, a, b in bands]
    for value in svg.ticks(low, high, 6):
        parts.append(svg.line(at((first, value)), at((last, value)), "grid"))
        parts.append(svg.label(left - 5, at((first, value))[1] + 4, svg.tick_text(value), "tick", "e"))
    if pane.low:
        outline = [at(p) for p in (*pane.low, *reversed(pane.high))]
        d: list[str | float] = ["M", *outline[0]]
        for p in outline[1:]:
            d += ["L", *p]
        parts.append(svg.path([*d, "Z"], "tube f0"))
    for s in pane.series:
        parts += _series(s, at)
    return [*parts, svg.label(left, top - 5, pane.name, "name")]


def _band(band: tuple[str, float, float], k: int, at: Place, top: float) -> str:
    a, b = at((band[1], 0.0))[0], at((band[2], 0.0))[0]
    return svg.rect(a, top, b - a, HEIGHT, f"band{k % 2}")


def _series(s: Series, at: Place) -> list[str]:
    if s.is_dotted:
        radius = 2.0 if len(s.points) <= _FEW else 0.8
        return [svg.circle(at(p), radius, f"f{s.kind % 10}") for p in s.points]
    return [svg.polyline([at(p) for p in s.points], _kind(s.kind))]


def _clock(bands: Sequence[tuple[str, float, float]], left: float, y: float, clock: str) -> list[str]:
    first, last = bands[0][1], bands[-1][2]
    room, parts = WIDTH - LEFT, [svg.label(left + (WIDTH - LEFT) / 2, y + 44, clock, "axis", "m")]
    for value in svg.ticks(first, last, 8):
        x = left + room * (value - first) / (last - first)
        parts += [svg.line((x, y + 14), (x, y + 18), "tick"), svg.label(x, y + 29, svg.tick_text(value), "tick", "m")]
    return parts
