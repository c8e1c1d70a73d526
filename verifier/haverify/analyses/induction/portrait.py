"""What a figure of a state that leaves an invariant shows: two variables, the others as in that state; in floats."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from haverify.analyses.induction.counterexample import Leaving
from haverify.analyses.induction.reached import Nearest, rates
from haverify.analyses.induction.refutation import names_of
from haverify.analyses.induction.runs import Vector, compiled, violated
from haverify.obligations.formula import Formula, conjunction, disjunction, literals, negation
from haverify.obligations.induction import Induction
from haverify.obligations.induction import names_of as names_in

Json = Any
ACROSS, UP = 48, 32  # cells of the grid
ARROWS = 6  # cells between arrows
MOST_RUNS = 8


def portrait(induction: Induction, found: Leaving, formula: Formula, near: Nearest) -> Json | None:
    """The data of a figure: ranges, where the invariant, the domain and starts are, borders, the field, runs."""
    pair = _pair(induction, formula)
    if pair is None:
        return None
    names = [*names_of(induction), "time"]
    at = [float(found.point.get(n, 0)) for n in names]
    places = [names.index(v) for v in pair]
    ranges = [_range(at[k], [p[near.names.index(v)] for run in near.runs for p in run])
              for k, v in zip(places, pair, strict=True)]  # fmt: skip

    def put(x: float, y: float) -> Vector:
        return [x if k == places[0] else y if k == places[1] else q for k, q in enumerate(at)]

    field = rates(induction, found.mode, names)
    units = {v.name: str(v.unit) if v.unit is not None else "1" for v in induction.automaton.vars}
    corners = _grid(ranges, ACROSS, UP)
    return {
        "kind": "portrait",
        "mode": found.mode,
        "names": list(pair),
        "units": [units[v] for v in pair],
        "ranges": ranges,
        "state": [at[k] for k in places],
        "arrow": _slope(field, at, places),
        "broken": _flags(induction, negation(formula), names, corners, put),
        "outside": _flags(induction, _outside(induction, found.mode), names, corners, put),
        "starts": _flags(induction, _started(induction, found.mode), names, corners, put),
        "borders": [_values(induction, p, names, ranges, put) for p in _borders(formula)],
        "field": [[x, y, *_slope(field, put(x, y), places)] for x, y in _grid(ranges, ACROSS // ARROWS, UP // ARROWS)],
        "runs": [[[_short(p[near.names.index(v)]) for v in pair] for p in run] for run in near.runs[:MOST_RUNS]],
    }


def _pair(induction: Induction, formula: Formula) -> tuple[str, str] | None:
    """The two variables that the invariant reads first, or that there are."""
    moving = [v.name for v in induction.automaton.vars if v.type == "real"]
    read = set(induction.functions.support(v for q in literals(formula) for v in q.polynomial.variables))
    ordered = sorted(moving, key=lambda v: v not in read)
    return (ordered[0], ordered[1]) if len(ordered) > 1 else None


def _range(middle: float, seen: list[float]) -> list[float]:
    low, high = min([middle, *seen]), max([middle, *seen])
    room = 0.25 * (high - low) or 0.5 * max(abs(middle), 1.0)
    return [low - room, high + room]


def _grid(ranges: list[list[float]], across: int, up: int) -> list[tuple[float, float]]:
    """The middles of cells, row by row from below."""
    (a, b), (c, d) = ranges
    xs = [a + (b - a) * (2 * i + 1) / (2 * across) for i in range(across)]
    ys = [c + (d - c) * (2 * j + 1) / (2 * up) for j in range(up)]
    return [(x, y) for y in ys for x in xs]


def _flags(
    induction: Induction, f: Formula, names: list[str], at: list[tuple[float, float]],
    put: Callable[[float, float], Vector],
) -> str:  # fmt: skip
    """For each cell a 1 where a formula plainly holds, else a 0."""
    holds = violated(f, names, induction.functions)
    return "".join("1" if _safely(holds, put(x, y)) else "0" for x, y in at)


def _safely(f: Callable[[Vector], Any], point: Vector) -> Any:
    try:
        return f(point)
    except (OverflowError, ValueError, ZeroDivisionError):
        return 0


def _outside(induction: Induction, mode: str) -> Formula:
    return negation(induction.premises(*induction.common(mode)).conjunction())


def _started(induction: Induction, mode: str) -> Formula:
    """The starts of a mode."""
    lines = [induction.premises(*induction.starts(x, m)).entries for x, m, _ in induction.lines() if m == mode]
    return disjunction([conjunction([f for f in line if names_in(f) != {"time"}]) for line in lines])


def _borders(formula: Formula) -> list[Any]:
    return list(dict.fromkeys(q.polynomial for q in literals(formula)))[:6]


def _values(
    induction: Induction, p: Any, names: list[str], ranges: list[list[float]], put: Callable[[float, float], Vector]
) -> list[float]:
    """A polynomial at the corners of the cells, row by row from below."""
    f = compiled(p, names, induction.functions)
    (a, b), (c, d) = ranges
    xs = [a + (b - a) * i / ACROSS for i in range(ACROSS + 1)]
    ys = [c + (d - c) * j / UP for j in range(UP + 1)]
    return [_short(_safely(f, put(x, y))) for y in ys for x in xs]


def _slope(field: list[Any], point: Vector, places: list[int]) -> list[float]:
    return [float(_safely(field[k], point)) for k in places]


def _short(x: float) -> float:
    return float(f"{x:.4g}")
