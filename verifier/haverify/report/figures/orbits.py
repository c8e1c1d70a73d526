"""Orbits of a cellular rule: every cell and where its rule sends it, cycles as rings and what leads into them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from haverify.report.figures import svg
from haverify.report.figures.graphs import END, HEADS, rim
from haverify.report.figures.material import Figure, Json, Material, Undrawable
from haverify.text.record import record

WIDTH = 680.0
_MOST, _TALL, _STEP = 72, 13.0, 46.0


def of_rule(material: Material, rule: Json) -> Figure:
    """The orbits of a rule table.

    Raises
    ------
    Undrawable      if it is given by a formula, has no rules or too many
    """
    pairs = [(str(a), str(b)) for a, b in rule.get("rules") or []]
    cells = list(dict.fromkeys(x for pair in pairs for x in pair))
    if not pairs or len(cells) > _MOST:
        raise Undrawable
    names = {c: _name(material, rule, c) for c in cells}
    following = dict(reversed(pairs))
    rings = _rings(cells, following)
    further = [(a, b) for a, b in pairs if following[a] != b]
    title = f"Orbits of {rule['name']}"
    counts: dict[int, int] = {}
    for ring in rings:
        counts[len(ring)] = counts.get(len(ring), 0) + 1
    said = [f"{n} cycle{'s' * (n > 1)} of length {k}" for k, n in sorted(counts.items())]
    stuck = [c for c in cells if c not in following]
    said += [f"{len(stuck)} cell{'s' * (len(stuck) > 1)} without a rule (red)"] if stuck else []
    said += [f"{len(further)} second rules for a cell (red arrows)"] if further else []
    drawing = _draw(names, following, rings, further, title)
    return Figure(f"orbits_{rule['name']}", title, f"{len(cells)} cells: {', '.join(said) or 'no cycle'}", drawing)


def _name(material: Material, rule: Json, bits: str) -> str:
    """`Left IC` for the bits of its two enumerations; the bits where these have no such codes."""
    words, rest = [], bits
    for enum in (material.named("enums", rule.get(key)) for key in ("first", "second")):
        codes = (
            {str(c).removeprefix("0b"): v for c, v in zip(enum["codes"], enum["values"], strict=False)} if enum else {}
        )
        width = max(map(len, codes), default=0)
        words.append(str(codes.get(rest[:width], rest[:width])))
        rest = rest[width:]
    return " ".join(w for w in words if w) if not rest else bits


def _rings(cells: Sequence[str], following: Mapping[str, str]) -> list[list[str]]:
    """The cycles, each once, in the order of their first cells."""
    rings, seen = [], set[str]()
    for c in cells:
        way: dict[str, int] = {}
        while c in following and c not in way and c not in seen:
            way[c] = len(way)
            c = following[c]
        if c in way:
            rings.append([x for x, k in way.items() if k >= way[c]])
        seen.update(way)
    return rings


def _draw(
    names: Mapping[str, str],
    following: Mapping[str, str],
    rings: Sequence[Sequence[str]],
    further: Sequence[tuple[str, str]],
    title: str,
) -> str:
    half = max(map(_half, names.values()))
    places: dict[str, svg.Point] = {}
    x, y, row, across = 10.0, 0.0, 0.0, WIDTH
    for group in _groups(names, following, rings):
        own = _placed(group, half)
        left, up = min(dx for dx, _ in own.values()) - half, min(dy for _, dy in own.values()) - _TALL - 24
        width = max(dx for dx, _ in own.values()) + half - left
        height = max(dy for _, dy in own.values()) + _TALL - up
        if x + width > WIDTH and x > 10:
            x, y, row = 10.0, y + row + 14, 0.0
        for node, (dx, dy) in own.items():
            places[node] = (x + dx - left, y + dy - up)
        x, row = x + width + 24, max(row, height)
        across = max(across, x)
    arrows = [_arrow(places, a, b, half, following.get(b) == a and a != b, "arrow") for a, b in following.items()]
    arrows += [_arrow(places, a, b, half, True, "arrow bad") for a, b in further]
    nodes = [_node(places[c], names[c], half, c in following) for c in names]
    return svg.drawing(across, y + row + 12, [HEADS, *arrows, *nodes], title)


def _half(name: str) -> float:
    return svg.text_width(name) / 2 + 8


def _node(at: svg.Point, name: str, half: float, has_rule: bool) -> str:
    kind = "node" if has_rule else "node bad"
    box = svg.rect(at[0] - half, at[1] - _TALL, 2 * half, 2 * _TALL, kind, ' rx="8"')
    return box + svg.label(at[0], at[1] + 4, name, "mode", "m")


@record
class _Group:
    """A cycle (or a cell without a rule) and the tree of cells that leads into each of its cells."""

    ring: tuple[str, ...]
    before: Mapping[str, Sequence[str]]

    def leaves(self, node: str) -> int:
        """How many ways lead into a cell from outside the ring, at least one."""
        return max(1, sum(self.leaves(a) for a in self.before[node]))

    @property
    def is_plain(self) -> bool:
        """Whether nothing leads into it and it is a cell or a pair."""
        return len(self.ring) <= 2 and not any(self.before[c] for c in self.ring)


def _groups(names: Mapping[str, str], following: Mapping[str, str], rings: Sequence[Sequence[str]]) -> list[_Group]:
    on_ring = {c for ring in rings for c in ring}
    before: dict[str, list[str]] = {c: [] for c in names}
    for a, b in following.items():
        if a not in on_ring:
            before[b].append(a)
    roots = [*map(tuple, rings), *((c,) for c in names if c not in following)]
    return [_Group(root, before) for root in roots]


def _placed(group: _Group, half: float) -> dict[str, svg.Point]:
    """Where the cells of a group stand around its middle: each tree in the sector of its root."""
    if group.is_plain:
        both = [(-half - 20, 0.0), (half + 20, 0.0)]
        return dict(zip(group.ring, both if len(group.ring) == 2 else [(0.0, 0.0)], strict=True))
    places, scale = _around(group, half, 1.0), 1.0
    while _overlap(list(places.values()), half) and scale < 8:
        scale *= 1.12
        places = _around(group, half, scale)
    return places


def _overlap(places: Sequence[svg.Point], half: float) -> bool:
    """Whether two boxes touch or leave no room for an arrow."""
    near = [(x, u, y, v) for k, (x, y) in enumerate(places) for u, v in places[:k]]
    return any(abs(x - u) < 2 * half + 14 and abs(y - v) < 2 * _TALL + 14 for x, u, y, v in near)


def _around(group: _Group, half: float, scale: float) -> dict[str, svg.Point]:
    total = sum(map(group.leaves, group.ring))
    radii = [scale * r for r in _radii(group)]
    places: dict[str, svg.Point] = {}
    turn = math.pi - math.pi * group.leaves(group.ring[0]) / total  # the first cell stands on the left
    pending = []
    for c in group.ring:
        pending.append((c, 0, turn, turn + 2 * math.pi * group.leaves(c) / total))
        turn = pending[-1][3]
    while pending:
        c, depth, low, high = pending.pop()
        angle = (low + high) / 2
        places[c] = (radii[depth] * math.cos(angle) * _aspect(half), radii[depth] * math.sin(angle))
        for a in group.before[c]:
            share = (high - low) * group.leaves(a) / sum(map(group.leaves, group.before[c]))
            pending.append((a, depth + 1, low, low + share))
            low += share
    return places


def _aspect(half: float) -> float:
    return max(1.0, half / 24)


def _radii(group: _Group) -> list[float]:
    """The radius of the ring, then of each layer around it, before they are widened."""
    layer, radii = list(group.ring), list[float]()
    while layer:
        radii.append(radii[-1] + _STEP if radii else 0.0 if len(layer) == 1 else 30.0)
        layer = [a for c in layer for a in group.before[c]]
    return radii


def _arrow(places: Mapping[str, svg.Point], a: str, b: str, half: float, is_mutual: bool, kind: str) -> str:
    (x, y), (u, v) = places[a], places[b]
    if a == b:
        d: list[str | float] = [
            "M",
            x - 8,
            y - _TALL,
            "C",
            x - 22,
            y - _TALL - 26,
            x + 22,
            y - _TALL - 26,
            x + 8,
            y - _TALL,
        ]
        return svg.path(d, kind, END)
    length = math.hypot(u - x, v - y) or 1.0
    bend = 12.0 if is_mutual else 0.0
    cx, cy = (x + u) / 2 - bend * (v - y) / length, (y + v) / 2 + bend * (u - x) / length
    start, end = rim((x, y), (cx, cy), half, _TALL), rim((u, v), (cx, cy), half, _TALL)
    return svg.path(["M", *start, "Q", cx, cy, *end], kind, END)
