"""Mode graphs: nodes on an ellipse in the order in which a walk from the start meets them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from haverify.report.figures import svg
from haverify.report.figures.material import Figure, Json, Undrawable
from haverify.text.record import record

WIDTH = 680.0
_MOST, _HEIGHT = 24, 15.0


@record
class Arrow:
    """An edge: `kind` is its class, `text` what stands beside it."""

    source: str
    target: str
    kind: str = "arrow"
    text: str = ""


def of_automaton(automaton: Json) -> Figure:
    """The mode graph of an automaton.

    Raises
    ------
    Undrawable      if it has a single mode without edges, or too many modes
    """
    names = [m["name"] for m in automaton["modes"]]
    if not 2 <= len(names) <= _MOST and not (len(names) == 1 and automaton["edges"]):
        raise Undrawable
    arrows = [
        Arrow(e["source"], e["target"], "arrow" if e["urgent"] else "arrow may", _edge_name(e))
        for e in automaton["edges"]
    ]
    starts = [i["mode"] for i in automaton["init"] if i.get("mode")]
    kinds = {m["name"]: "node terminal" if m["terminal"] else "node" for m in automaton["modes"]}
    kinds |= dict.fromkeys(starts, "node start")
    said = ["thick: where runs start"]
    said += ["dashed edge: may wait, solid: taken when due"] if any(a.kind != "arrow" for a in arrows) else []
    drawing = draw(ordered(names, arrows, starts), kinds, arrows, f"the modes of {automaton['name']}")
    return Figure(f"modes_{automaton['name']}", f"Modes of {automaton['name']}", "; ".join(said), drawing)


def _edge_name(e: Json) -> str:
    """The name of an edge where it says more than its two ends."""
    name = str(e.get("name") or "")
    return "" if name == f"{e['source']}_{e['target']}" else name


def ordered(names: Sequence[str], arrows: Sequence[Arrow], starts: Sequence[str]) -> list[str]:
    """The nodes as a depth-first walk from the starts meets them, what it misses after them."""
    following: dict[str, list[str]] = {n: [] for n in names}
    for a in arrows:
        if a.source in following:
            following[a.source].append(a.target)
    found: dict[str, None] = {}
    for first in [*starts, *names]:
        pending = [first]
        while pending:
            node = pending.pop()
            if node in following and node not in found:
                found[node] = None
                pending += reversed(following[node])
    return list(found)


def draw(names: Sequence[str], kinds: Mapping[str, str], arrows: Sequence[Arrow], title: str) -> str:
    """The drawing of a graph, its nodes in this order clockwise from the left."""
    places, height = _places(names)
    joined = _joined(arrows)
    parts = [HEADS]
    texts = list[str]()
    for (source, target), several in joined.items():
        is_mutual = (target, source) in joined
        drawn, text = _arrow(places, source, target, several, is_mutual, height)
        parts.append(drawn)
        texts += text
    for n in names:
        x, y = places[n]
        half = _half(n)
        parts.append(svg.rect(x - half, y - _HEIGHT, 2 * half, 2 * _HEIGHT, kinds.get(n, "node"), ' rx="9"'))
        parts.append(svg.label(x, y + 4.5, n, "mode", "m"))
    return svg.drawing(WIDTH, height, parts + texts, title)


HEADS = (
    '<defs><marker id="head" viewBox="0 0 8 8" refX="7.5" refY="4" markerWidth="8" markerHeight="8" '
    'orient="auto" markerUnits="userSpaceOnUse"><path class="head" d="M0 0.5L8 4L0 7.5z"/></marker></defs>'
)
END = ' marker-end="url(#head)"'


def _joined(arrows: Sequence[Arrow]) -> dict[tuple[str, str], list[Arrow]]:
    """The arrows by their ends."""
    joined: dict[tuple[str, str], list[Arrow]] = {}
    for a in arrows:
        joined.setdefault((a.source, a.target), []).append(a)
    return joined


def _half(name: str) -> float:
    return max(20.0, svg.text_width(name[:40]) / 2 + 9)


def _places(names: Sequence[str]) -> tuple[dict[str, tuple[float, float]], float]:
    """Centres on an ellipse that grows with their number, from the left, clockwise; and the drawing's height."""
    widest = max(map(_half, names))
    across = WIDTH / 2 - widest - 40
    up = min(60.0 + 16 * max(0, len(names) - 3), 210.0) if len(names) > 1 else 0.0
    height = 2 * up + 110
    places = {}
    for k, n in enumerate(names):
        angle = math.pi + 2 * math.pi * k / len(names)
        spread = across if len(names) > 1 else 0.0
        places[n] = (WIDTH / 2 + spread * math.cos(angle), height / 2 + up * math.sin(angle))
    return places, height


def _arrow(
    places: Mapping[str, tuple[float, float]],
    source: str,
    target: str,
    several: Sequence[Arrow],
    is_mutual: bool,
    height: float,
) -> tuple[str, list[str]]:
    """The path of the arrows between two nodes, and their names beside it."""
    kind = "arrow" if any(a.kind == "arrow" for a in several) else several[0].kind
    text = ", ".join(dict.fromkeys(a.text for a in several if a.text))
    text = text if len(text) <= 26 else text[:24] + "..."
    (x, y), (u, v) = places[source], places[target]
    if source == target:
        return _loop(x, y, y <= height / 2, kind, text)
    bend = 26.0 if is_mutual else 0.0
    length = math.hypot(u - x, v - y) or 1.0
    cx = (x + u) / 2 - bend * (v - y) / length
    cy = (y + v) / 2 + bend * (u - x) / length
    start, end = rim((x, y), (cx, cy), _half(source)), rim((u, v), (cx, cy), _half(target))
    drawn = svg.path(["M", *start, "Q", cx, cy, *end], kind, END)
    middle = ((start[0] + 2 * cx + end[0]) / 4, (start[1] + 2 * cy + end[1]) / 4)
    return drawn, [svg.label(middle[0], middle[1] + 4, text, "edge", "m")] if text else []


def _loop(x: float, y: float, is_up: bool, kind: str, text: str) -> tuple[str, list[str]]:
    sign = -1 if is_up else 1
    rim, far = y + sign * _HEIGHT, y + sign * (_HEIGHT + 34)
    drawn = svg.path(["M", x - 9, rim, "C", x - 26, far, x + 26, far, x + 9, rim], kind, END)
    return drawn, [svg.label(x, far + (10 if is_up else 0), text, "edge", "m")] if text else []


def rim(centre: svg.Point, towards: svg.Point, half: float, tall: float = _HEIGHT) -> tuple[float, float]:
    """Where the line from a node's centre leaves its box."""
    dx, dy = towards[0] - centre[0], towards[1] - centre[1]
    scale = min(half / abs(dx) if dx else math.inf, tall / abs(dy) if dy else math.inf)
    return centre if math.isinf(scale) else (centre[0] + dx * scale, centre[1] + dy * scale)
