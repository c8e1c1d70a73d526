"""`for which` drawn: the range of a param as a bar, the box of two as a map, coloured by what is shown of each."""

from __future__ import annotations

import re
from collections.abc import Sequence
from fractions import Fraction

from haverify.report.figures import svg
from haverify.report.figures.material import Figure, Undrawable
from haverify.report.report import Claim, Part

WIDTH, SIDE, LEFT, TOP, BAR = 680.0, 264.0, 70.0, 14.0, 40.0
KINDS = {"proved": "piece proved", "refuted": "piece refuted", "unknown": "piece"}
POINT = "piece refuted point"
SAID = {"proved": "proved", "refuted": "refuted", "unknown": "left open"}
_SIDE = re.compile(r"([^,\s]+) in \[(-?\d+(?:/\d+)?), (-?\d+(?:/\d+)?)\]")
_VALUE = re.compile(r"([^,\s]+) = (-?\d+(?:/\d+)?)")
Ends = tuple[float, float]


def of_pieces(c: Claim) -> Figure:
    """The pieces of a claim with `for which`, over its first two params.

    Raises
    ------
    Undrawable      if it has none, or more than two params that are cut
    """
    boxes = [(p.verdict, _sides(p)) for p in c.parts if p.kind == "piece"]
    if not boxes or not boxes[0][1]:
        raise Undrawable
    names = list(boxes[0][1])
    if len(names) > 2:
        raise Undrawable
    ends = [(min(b[n][0] for _, b in boxes), max(b[n][1] for _, b in boxes)) for n in names]
    if any(low >= high for low, high in ends):
        raise Undrawable
    height = SIDE if len(names) == 2 else BAR
    parts = [_box(word, [b[n] for n in names], ends, height) for word, b in boxes]
    points = [_values(p) for p in c.parts if p.kind == "point"]
    parts += [_point([q[n] for n in names], ends, height) for q in points]
    parts += [svg.rect(LEFT, TOP, SIDE, height, "frame"), *_scales(names, ends, height)]
    parts += _legend(boxes, ends, len(points))
    title = f"{c.name}: where it holds"
    said = f"over {' and '.join(names)}; each piece is shown as a whole{', each dot by a run' if points else ''}"
    return Figure(f"pieces_{c.name}", title, said, svg.drawing(WIDTH, TOP + height + 46, parts, title), c.name)


def _sides(p: Part) -> dict[str, Ends]:
    return {n: (float(Fraction(a)), float(Fraction(b))) for n, a, b in _SIDE.findall(p.mode)}


def _values(p: Part) -> dict[str, float]:
    return {n: float(Fraction(q)) for n, q in _VALUE.findall(p.mode)}


def _place(ends: Ends, size: float, x: float) -> float:
    return size * (x - ends[0]) / (ends[1] - ends[0])


def _box(word: str, box: Sequence[Ends], ends: Sequence[Ends], height: float) -> str:
    left, right = (_place(ends[0], SIDE, x) for x in box[0])
    low, high = (_place(ends[1], height, y) for y in box[1]) if len(box) > 1 else (0.0, height)
    return svg.rect(LEFT + left, TOP + height - high, right - left, high - low, KINDS[word])


def _point(values: Sequence[float], ends: Sequence[Ends], height: float) -> str:
    up = _place(ends[1], height, values[1]) if len(values) > 1 else height / 2
    return svg.circle((LEFT + _place(ends[0], SIDE, values[0]), TOP + height - up), 3, POINT)


def _scales(names: Sequence[str], ends: Sequence[Ends], height: float) -> list[str]:
    parts = []
    for t in svg.ticks(*ends[0], 6):
        parts.append(svg.label(LEFT + _place(ends[0], SIDE, t), TOP + height + 16, svg.tick_text(t), "tick", "m"))
    parts.append(svg.label(LEFT + SIDE / 2, TOP + height + 36, names[0], "", "m"))
    if len(names) > 1:
        for t in svg.ticks(*ends[1], 6):
            at = TOP + height - _place(ends[1], height, t) + 4
            parts.append(svg.label(LEFT - 6, at, svg.tick_text(t), "tick", "e"))
        parts.append(svg.label(LEFT - 40, TOP + height / 2, names[1], "", "m"))
    return parts


def _legend(boxes: Sequence[tuple[str, dict[str, Ends]]], ends: Sequence[Ends], points: int) -> list[str]:
    """Each verdict with its share of the whole, and how many points are refuted beside."""
    parts, y = [], TOP + 12.0
    for word, kind in KINDS.items():
        share = sum(_share(list(b.values()), ends) for w, b in boxes if w == word)
        if share:
            parts.append(svg.rect(LEFT + SIDE + 40, y - 10, 14, 12, kind))
            parts.append(svg.label(LEFT + SIDE + 62, y, f"{SAID[word]}: {100 * share:.3g} %"))
            y += 22
    if points:
        parts.append(svg.circle((LEFT + SIDE + 47, y - 4), 3, POINT))
        parts.append(svg.label(LEFT + SIDE + 62, y, f"refuted at {points} point{'s' * (points > 1)}"))
    return parts


def _share(box: Sequence[Ends], ends: Sequence[Ends]) -> float:
    found = 1.0
    for (low, high), (first, last) in zip(box, ends, strict=True):
        found *= (high - low) / (last - first)
    return found
