"""The figure of a state that leaves an invariant: two variables, where it holds, its borders, the flow, runs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby
from math import hypot

from haverify.report.figures import svg
from haverify.report.figures.material import Figure, Json, Undrawable
from haverify.report.report import Claim

WIDTH, LEFT, TOP, FOOT = 680.0, 58.0, 30.0, 40.0
ACROSS, UP = 48, 32
WIDE, HIGH = 510.0, 340.0
ARROW = 13.0  # pixels


def of_leaving(data: Json, c: Claim) -> Figure:
    """The drawing from the data of a portrait.

    Raises
    ------
    Undrawable      if the data have another shape
    """
    (a, b), (low, high) = data["ranges"]
    sizes = {len(data[k]) for k in ("broken", "outside", "starts")}
    if sizes != {ACROSS * UP} or not (a < b and low < high):
        raise Undrawable

    def place(x: float, y: float) -> svg.Point:
        return LEFT + WIDE * (x - a) / (b - a), TOP + HIGH * (high - y) / (high - low)

    parts = [part for kind in ("broken", "outside", "starts") for part in _cells(data[kind], kind)]
    parts += _grid((a, b), (low, high), place)
    for values in data["borders"]:
        parts += _border(values, place, (a, b), (low, high))
    parts += [_arrow(place(x, y), dx * WIDE / (b - a), -dy * HIGH / (high - low), "arrow may", ARROW)
              for x, y, dx, dy in data["field"] if dx or dy]  # fmt: skip
    parts += [svg.polyline([place(*_kept(p, data["ranges"])) for p in run], "trail") for run in data["runs"]]
    parts += [svg.circle(place(*_kept(run[0], data["ranges"])), 3.0, "origin") for run in data["runs"] if run]
    state, (dx, dy) = place(*data["state"]), data["arrow"]
    parts.append(_arrow(state, dx * WIDE / (b - a), -dy * HIGH / (high - low), "arrow bad", 3 * ARROW))
    parts.append(svg.circle(state, 4.5, "mark bad"))
    said = [n if u == "1" else f"{n} [{u}]" for n, u in zip(data["names"], data["units"], strict=True)]
    parts += [svg.rect(LEFT, TOP, WIDE, HIGH, "frame"), svg.label(4, TOP - 8, said[1], "name")]
    parts.append(svg.label(LEFT + WIDE / 2, TOP + HIGH + 34, said[0], "axis", "m"))
    drawing = svg.drawing(WIDTH, TOP + HIGH + FOOT, parts, f"where {c.name} is left")
    title = f"Where {c.name} is left, in mode {data['mode']}"
    told = (
        "red dot: the state, its arrow the flow there; borders of the invariant green, broken beyond them (red); starts"
    )
    told += " blue; outside of the domain grey; sampled runs black, from their circles"
    return Figure(f"leaving_{c.name}", title, told, drawing, c.name)


_KINDS = {"broken": "leaves", "outside": "nowhere", "starts": "begins"}


def _cells(flags: str, kind: str) -> Iterator[str]:
    """The cells that are marked, a rectangle for each stretch of a row."""
    for j in range(UP):
        row, at = flags[j * ACROSS : (j + 1) * ACROSS], 0
        for flag, run in groupby(row):
            n = len(list(run))
            if flag == "1":
                x, y = LEFT + WIDE * at / ACROSS, TOP + HIGH * (UP - 1 - j) / UP
                yield svg.rect(x, y, WIDE * n / ACROSS, HIGH / UP, _KINDS[kind])
            at += n


def _border(
    values: Sequence[float], place: svg.Placing, across: tuple[float, float], up: tuple[float, float]
) -> list[str]:
    """Where values at the corners change their sign: a stroke in each cell."""
    (a, b), (c, d) = across, up
    found = []
    for j in range(UP):
        for i in range(ACROSS):
            at = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
            q = [values[y * (ACROSS + 1) + x] for x, y in at]
            cuts = [
                _between(at[k], at[k - 1], q[k] / (q[k] - q[k - 1]))
                for k in range(4)
                if (q[k] > 0) is not (q[k - 1] > 0)
            ]
            ends = [place(a + (b - a) * x / ACROSS, c + (d - c) * y / UP) for x, y in cuts]
            found += [svg.line(ends[0], ends[1], "bound")] if len(ends) == 2 else []
    return found


def _between(a: tuple[int, int], b: tuple[int, int], share: float) -> svg.Point:
    return a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])


def _arrow(at: svg.Point, dx: float, dy: float, kind: str, length: float) -> str:
    """An arrow of a length, whatever the size of its slope."""
    size = hypot(dx, dy) or 1.0
    ux, uy = dx / size, dy / size
    end = (at[0] + length * ux, at[1] + length * uy)
    left = (end[0] - 4 * ux + 2.5 * uy, end[1] - 4 * uy - 2.5 * ux)
    right = (end[0] - 4 * ux - 2.5 * uy, end[1] - 4 * uy + 2.5 * ux)
    return svg.path(["M", *at, "L", *end, "M", *left, "L", *end, "L", *right], kind)


def _kept(p: Sequence[float], ranges: Sequence[Sequence[float]]) -> tuple[float, float]:
    x, y = (min(max(q, r[0]), r[1]) for q, r in zip(p, ranges, strict=True))
    return x, y


def _grid(across: tuple[float, float], up: tuple[float, float], place: svg.Placing) -> list[str]:
    parts = []
    for value in svg.ticks(*across, 8):
        x, _ = place(value, up[0])
        parts += [svg.line((x, TOP), (x, TOP + HIGH), "grid")]
        parts += [svg.label(x, TOP + HIGH + 17, svg.tick_text(value), "tick", "m")]
    for value in svg.ticks(*up, 7):
        _, y = place(across[0], value)
        parts += [svg.line((LEFT, y), (LEFT + WIDE, y), "grid")]
        parts += [svg.label(LEFT - 5, y + 4, svg.tick_text(value), "tick", "e")]
    return parts
