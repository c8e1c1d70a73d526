"""Scalable drawings as text: shapes with classes, which a style sheet colours; nothing in them is executed."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence

from haverify.report.markup import clipped, escape

Point = tuple[float, float]
Scale = Callable[[float], float]
Placing = Callable[[float, float], Point]

_LIMIT = 1e6


def number(x: float) -> str:
    """A coordinate to a tenth of a pixel; what is infinite stays on the page's far side."""
    if not -_LIMIT <= x <= _LIMIT:
        x = 0.0 if math.isnan(x) else min(max(x, -_LIMIT), _LIMIT)
    text = f"{x:.1f}"
    return text[:-2] if text.endswith(".0") else text


def line(a: Point, b: Point, kind: str) -> str:
    """A straight line."""
    return f'<path class="{kind}" d="M{number(a[0])} {number(a[1])}L{number(b[0])} {number(b[1])}"/>'


def polyline(points: Iterable[Point], kind: str) -> str:
    """Straight lines through points."""
    at = " ".join([f"{x:.1f},{y:.1f}" for x, y in points])
    return f'<polyline class="{kind}" points="{at}"/>'


def path(d: Sequence[str | float], kind: str, more: str = "") -> str:
    """A path from its commands and coordinates."""
    text = " ".join(x if isinstance(x, str) else number(x) for x in d)
    return f'<path class="{kind}" d="{text}"{more}/>'


def rect(x: float, y: float, width: float, height: float, kind: str, more: str = "") -> str:
    """A rectangle."""
    size = f'width="{number(width)}" height="{number(height)}"'
    return f'<rect class="{kind}" x="{number(x)}" y="{number(y)}" {size}{more}/>'


def circle(at: Point, radius: float, kind: str) -> str:
    """A circle."""
    return f'<circle class="{kind}" cx="{number(at[0])}" cy="{number(at[1])}" r="{number(radius)}"/>'


def label(x: float, y: float, text: str, kind: str = "", anchor: str = "") -> str:
    """A text; `anchor` is `m` (middle) or `e` (end), else it starts at `x`."""
    classes = " ".join(c for c in (kind, anchor) if c)
    said = f' class="{classes}"' if classes else ""
    return f'<text x="{number(x)}" y="{number(y)}"{said}>{escape(clipped(text, 80))}</text>'


def drawing(width: float, height: float, parts: Iterable[str], title: str) -> str:
    """A whole drawing, whose title is what a screen reader says."""
    size = f'viewBox="0 0 {number(width)} {number(height)}"'
    head = f'<svg xmlns="http://www.w3.org/2000/svg" {size} role="img" class="figure">'
    return f"{head}<title>{escape(clipped(title, 200))}</title>{''.join(parts)}</svg>"


def ticks(low: float, high: float, most: int) -> list[float]:
    """Up to `most` round numbers from `low` to `high`.

    >>> ticks(-2.2, 7.9, 5)
    [-2.0, 0.0, 2.0, 4.0, 6.0]
    """
    if not (math.isfinite(low) and math.isfinite(high)) or high <= low or most < 1:
        return []
    exponent = math.floor(math.log10((high - low) / most))
    for factor in (1, 2, 5, 10, 20, 50):
        step = factor * 10.0**exponent
        first = math.ceil(low / step - 1e-9)
        count = math.floor(high / step + 1e-9) - first + 1
        if count <= most:
            return [(first + k) * step for k in range(max(count, 0))]
    return []


def tick_text(x: float) -> str:
    """A round number as people write it.

    >>> tick_text(0.1 + 0.2), tick_text(-20.0), tick_text(25000.0)
    ('0.3', '-20', '25000')
    """
    return f"{x:.6g}" if 1e-4 <= abs(x) < 1e6 or x == 0 else f"{x:.2g}"


def text_width(text: str) -> float:
    """About how wide a text is in the drawings' font size."""
    return sum(8.4 if c.isupper() or c in "mwMW@%" else 6.8 for c in text)
