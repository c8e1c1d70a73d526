"""Fuzzy systems: the membership functions of each input, and which conclusion wins over two of the inputs."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from functools import lru_cache
from typing import Any

from haverify.report.figures import svg
from haverify.report.figures.material import Figure, Json, Material, Undrawable
from haverify.text.record import field, record

WIDTH, LEFT, RIGHT, TOP = 680.0, 44.0, 10.0, 30.0
_INPUTS, _TERMS, _GRID, _DEPTH, _RULES = 12, 10, 20, 8, 400
_HEIGHT, _GAP = 84.0, 56.0

Values = Mapping[tuple[str, str], float]
End = tuple[str, Json]


def memberships(system: Json) -> Figure:
    """The membership functions of the inputs that have a range.

    Raises
    ------
    Undrawable      if there is none
    """
    inputs = [i for i in system["inputs"] if i.get("terms") and i.get("low") is not None][:_INPUTS]
    if not inputs:
        raise Undrawable
    width = (WIDTH - (LEFT + RIGHT) * 2) / 2 if len(inputs) > 1 else WIDTH - LEFT - RIGHT
    rows = (len(inputs) + 1) // 2
    parts = []
    for k, i in enumerate(inputs):
        parts += _input(i, LEFT + (k % 2) * (width + LEFT + RIGHT), TOP + (k // 2) * (_HEIGHT + _GAP), width)
    title = f"Membership functions of {system['name']}"
    drawing = svg.drawing(WIDTH, TOP + rows * (_HEIGHT + _GAP) - 24, parts, title)
    return Figure(f"terms_{system['name']}", title, "degree of each term over its input", drawing)


def _input(i: Json, left: float, top: float, width: float) -> list[str]:
    low, high = float_of(i["low"]), float_of(i["high"])
    if not high > low:
        raise Undrawable

    def x(value: float) -> float:
        return left + width * (min(max(value, low), high) - low) / (high - low)

    unit = i.get("unit")
    name = f"{i['name']} [{unit}]" if unit not in (None, "", "1") else i["name"]
    parts = [svg.rect(left, top, width, _HEIGHT, "frame"), svg.label(left - 40, top - 16, name, "name")]
    parts += [svg.label(left - 5, top + _HEIGHT * (1 - d) + 4, t, "tick", "e") for d, t in ((0, "0"), (1, "1"))]
    for v in svg.ticks(low, high, 6):
        parts.append(svg.label(x(v), top + _HEIGHT + 16, svg.tick_text(v), "tick", "m"))
    for k, term in enumerate(i["terms"]):
        corners = [(q, degree(term, q)) for q in _turns(term, low, high)]
        parts.append(svg.polyline([(x(q), top + _HEIGHT * (1 - d)) for q, d in corners], f"term t{k % _TERMS}"))
        peak = [x(q) for q, d in corners if d == max(d for _, d in corners)]
        half = 0.55 * svg.text_width(term["name"])
        middle = min(max((min(peak) + max(peak)) / 2, left + half + 4), left + width - half - 4)
        parts.append(
            svg.label(
                middle,
                top - 4 if k % 2 == 0 or len(i["terms"]) < 5 else top + 12,
                term["name"],
                f"said s{k % _TERMS}",
                "m",
            )
        )
    return parts


def _turns(term: Json, low: float, high: float) -> list[float]:
    """Where a membership function changes its slope, and just beside its steps."""
    tiny = (high - low) * 1e-7
    at = [float_of(c) for c in term["corners"]]
    steps = [c for c in at if at.count(c) > 1] + (at if term["shape"] == "point" else [])
    near = [c + d for c in steps for d in (-tiny, tiny)]
    return sorted({low, high, *(q for q in [*at, *near] if low <= q <= high)})


def degree(term: Json, x: float) -> float:
    """How far `x` belongs to a term."""
    at = [float_of(c) for c in term["corners"]]
    if term["shape"] == "point":
        return float(x == at[0])
    if term["shape"] == "ramp":
        return min(max((x - at[0]) / (at[1] - at[0]), 0.0), 1.0) if at[1] != at[0] else float(x >= at[0])
    a, b, c, d = at if len(at) == 4 else (at[0], at[1], at[1], at[2])
    if b <= x <= c:
        return 1.0
    return (x - a) / (b - a) if a < x < b else (d - x) / (d - c) if c < x < d else 0.0


@lru_cache(maxsize=10_000)
def float_of(text: Any) -> float:
    """A rational of the core as a float."""
    return float(Fraction(text))


@record
class Chain:
    """All fuzzy systems of a core, of which some read the conclusions of others; strengths are computed once."""

    systems: Mapping[str, Json]
    known: dict[tuple[str, Any], Values] = field(default_factory=dict, compare=False)
    degrees: dict[tuple[str, str, float], Values] = field(default_factory=dict, compare=False)

    def ends(self, system: Json, depth: int = 0) -> list[End]:
        """The inputs with a range that the system reads, through its chain, with the systems that declare them."""
        found: dict[str, End] = {}
        for i in system["inputs"]:
            if i.get("source") and depth < _DEPTH:
                for owner, end in self.ends(self.systems[i["source"][0]], depth + 1):
                    found.setdefault(f"{owner}.{end['name']}", (owner, end))
            else:
                found.setdefault(f"{system['name']}.{i['name']}", (system["name"], i))
        return list(found.values())

    def strengths(self, system: Json, at: Values, depth: int = 0) -> Values:
        """How strongly each term of each output is concluded; `at` are the values of all inputs with a range."""
        key = (str(system["name"]), tuple(at.items()))
        if key not in self.known:
            self.known[key] = self._strengths(system, at, depth)
        return self.known[key]

    def _strengths(self, system: Json, at: Values, depth: int) -> Values:
        known: dict[tuple[str, str], float] = {}
        for i in system["inputs"]:
            if i.get("source") and depth < _DEPTH:
                source, output = i["source"]
                inner = self.strengths(self.systems[source], at, depth + 1)
                known |= {(i["name"], term): v for (o, term), v in inner.items() if o == output}
            else:
                known |= self._degrees(system, i, at[system["name"], i["name"]])
        found: dict[tuple[str, str], float] = {}
        for rule in system["rules"]:
            key = (rule["output"], rule["term"])
            found[key] = max(found.get(key, 0.0), _holds(rule["premise"], known, system["logic"]))
        return found

    def _degrees(self, system: Json, i: Json, x: float) -> Values:
        key = (str(system["name"]), str(i["name"]), x)
        if key not in self.degrees:
            self.degrees[key] = {(i["name"], t["name"]): degree(t, x) for t in i["terms"]}
        return self.degrees[key]


def chain(material: Material) -> Chain:
    """The fuzzy systems of a core."""
    return Chain(material.by_name("fuzzy"))


def _holds(e: Any, known: Mapping[tuple[str, str], float], logic: list[str]) -> float:
    op, *args = e
    if op == "is":
        return known[args[0], args[1]]
    inner = [known[a[1], a[2]] if a[0] == "is" else _holds(a, known, logic) for a in args]
    if op == "not":
        return 1.0 - inner[0]
    if op not in ("and", "or") or logic != ["min", "max"]:
        raise Undrawable
    return min(inner) if op == "and" else max(inner)


def conclusions(systems: Chain, system: Json) -> list[Figure]:
    """For each output: the term that is concluded most strongly, over two inputs, the others at three quarters.

    Raises
    ------
    Undrawable      if the system reads fewer than two inputs with a range, or has another logic than min and max
    """
    every = systems.ends(system)
    ends = [(owner, i) for owner, i in every if i.get("low") is not None]
    if len(ends) < 2 or len(ends) < len(every):
        raise Undrawable
    grid = _grid(systems, system, ends)
    return [_map(system, o, ends, grid) for o in system["outputs"] if o.get("terms")]


def _rest(ends: list[End]) -> dict[tuple[str, str], float]:
    """Where the inputs stand that are not drawn: off the middle, where terms often meet."""
    values = {}
    for owner, i in ends:
        low, high = float_of(i["low"]), float_of(i["high"])
        values[owner, str(i["name"])] = low + (high - low) * 0.75
    return values


def _grid(systems: Chain, system: Json, ends: list[End]) -> list[list[Values]]:
    """The strengths at the middles of the squares of a grid, row by row from below."""
    (one, i), (two, j) = ends[:2]
    rules = sum(len(s["rules"]) for s in systems.systems.values())
    if rules > _RULES:
        raise Undrawable
    size = _GRID if rules <= _RULES // 4 else _GRID // 2
    rest, rows = _rest(ends), list[list[Values]]()
    for r in range(size):
        y = _between(j, r, size)
        at: list[Values] = [{**rest, (one, i["name"]): _between(i, c, size), (two, j["name"]): y} for c in range(size)]
        rows.append([systems.strengths(system, values) for values in at])
    return rows


def _between(i: Json, k: int, size: int) -> float:
    low, high = float_of(i["low"]), float_of(i["high"])
    return low + (high - low) * (k + 0.5) / size


def _map(system: Json, output: Json, ends: list[End], grid: list[list[Values]]) -> Figure:
    side, left, top = 264.0, 60.0, 14.0
    size = side / len(grid)
    parts = [svg.rect(left, top, side, side, "frame")]
    used: dict[int, None] = {}
    for r, row in enumerate(grid):
        start = 0
        winners = [_winner(output, strengths) for strengths in row]
        for c in range(1, len(grid) + 1):
            if c == len(grid) or winners[c] != winners[start]:
                if winners[start] is not None:
                    used[winners[start] or 0] = None
                    at = (left + start * size, top + side - (r + 1) * size)
                    parts.append(
                        svg.rect(*at, (c - start) * size + 0.3, size + 0.3, f"f{(winners[start] or 0) % _TERMS}")
                    )
                start = c
    (_, i), (_, j) = ends[:2]
    parts += _scales(i, j, left, top, side)
    parts += _legend(output, sorted(used), left + side + 40, top)
    title = f"Conclusions of {system['name']}: {output['name']}"
    rest = ", ".join(f"{name} = {svg.tick_text(v)}" for (_, name), v in list(_rest(ends).items())[2:])
    said = f"the strongest term over {i['name']} and {j['name']}" + (f", with {rest}" if rest else "")
    name = f"map_{system['name']}_{output['name']}"
    return Figure(
        name,
        title,
        said + "; of equals the first, blank: no rule fires",
        svg.drawing(WIDTH, top + side + 44, parts, title),
    )


def _winner(output: Json, strengths: Values) -> int | None:
    """The strongest term, the first of equals; none where no rule fires."""
    terms = [
        (strengths.get((output["name"], t if isinstance(t, str) else t["name"]), 0.0), -k)
        for k, t in enumerate(output["terms"])
    ]
    strength, index = max(terms)
    return -index if strength > 0 else None


def _scales(i: Json, j: Json, left: float, top: float, side: float) -> list[str]:
    parts = []
    for end, is_across in ((i, True), (j, False)):
        low, high = float_of(end["low"]), float_of(end["high"])
        for v in svg.ticks(low, high, 5):
            share = (v - low) / (high - low)
            if is_across:
                parts.append(svg.label(left + side * share, top + side + 16, svg.tick_text(v), "tick", "m"))
            else:
                parts.append(svg.label(left - 6, top + side * (1 - share) + 4, svg.tick_text(v), "tick", "e"))
    unit_i, unit_j = (f" [{e['unit']}]" if e.get("unit") not in (None, "", "1") else "" for e in (i, j))
    parts.append(svg.label(left + side / 2, top + side + 36, f"{i['name']}{unit_i}", "axis", "m"))
    x, y = 14.0, top + side / 2
    turned = svg.label(x, y, f"{j['name']}{unit_j}", "axis", "m").replace(
        "<text ", f'<text transform="rotate(-90 {x} {y})" '
    )
    return [*parts, turned]


def _legend(output: Json, used: list[int], x: float, top: float) -> list[str]:
    parts = []
    for n, k in enumerate(used):
        term = output["terms"][k]
        parts.append(svg.rect(x, top + n * 22, 14, 14, f"f{k % _TERMS}"))
        parts.append(svg.label(x + 22, top + n * 22 + 12, term if isinstance(term, str) else term["name"], "mode"))
    return parts
