"""Curves of quantities over a clock, mode by mode, sampled as far as a drawing shows it."""

from __future__ import annotations

import math
from collections.abc import Callable

from haverify.report.figures.bands import Band, bands
from haverify.report.figures.evaluate import Scope, Value, reads, scope
from haverify.report.figures.material import Json, Material, Undrawable
from haverify.report.figures.quantities import Bound, Quantity
from haverify.text.record import record

_SAMPLES = 23
_HOLDS: dict[str, Callable[[float, float], bool]] = {
    "<": lambda a, b: a < b,
    "<=": lambda a, b: a <= b,
    ">": lambda a, b: a > b,
    ">=": lambda a, b: a >= b,
}


@record
class Curve:
    """A quantity in one band: points (clock, value), the bounds there as such points, which points violate them."""

    band: Band
    points: tuple[tuple[float, float], ...]
    bounds: tuple[tuple[tuple[float, float], ...], ...]
    is_bad: tuple[bool, ...]


def clock_of(material: Material, automaton: Json, wanted: list[Quantity]) -> str:
    """The one variable that the quantities read and that moves in every mode.

    Raises
    ------
    Undrawable      if there is none, or more than one
    """
    found: set[str] = set()
    for mode in automaton["modes"]:
        s = scope(material, automaton, mode)
        for q in wanted:
            found |= reads(q.expr, s)
    moving = {name for name in found if all(_moves(m, name) for m in automaton["modes"])}
    if len(found) != 1 or moving != found:
        raise Undrawable
    return found.pop()


def _moves(mode: Json, name: str) -> bool:
    rate = next((line.get("rate") for line in mode.get("flow", []) if line["var"] == name), None)
    return rate is not None and rate != "0"


def curves(material: Material, automaton: Json, q: Quantity, clock: str) -> list[Curve]:
    """The curve of a quantity in each band where it is defined, with its bounds.

    Raises
    ------
    Undrawable      if there is no such band
    """
    modes = {m["name"]: m for m in automaton["modes"]}
    found = []
    for band, points in _sampled(material, automaton, q, clock):
        try:
            found.append(_bounded(q, scope(material, automaton, modes[band.mode]), band, clock, points))
        except (Undrawable, ArithmeticError, ValueError, TypeError, KeyError):
            continue
    if not found:
        raise Undrawable
    return found


Points = tuple[tuple[float, float], ...]


def _sampled(material: Material, automaton: Json, q: Quantity, clock: str) -> list[tuple[Band, Points]]:
    """The points of a quantity in each band where it is defined, computed once for all claims about it."""
    key = (str(automaton["name"]), q.key)
    if key not in material.points:
        modes = {m["name"]: m for m in automaton["modes"]}
        found = []
        for band in bands(material, automaton, clock):
            try:
                found.append((band, _points(q, scope(material, automaton, modes[band.mode]), band, clock)))
            except (Undrawable, ArithmeticError, ValueError, TypeError, KeyError):
                continue
        material.points[key] = found
    return material.points[key]  # type: ignore[no-any-return]


def _points(q: Quantity, s: Scope, band: Band, clock: str) -> Points:
    value = s.value(q.expr)
    points = tuple([(x, float(value({clock: x}))) for x in _spread(band)])
    if not all(math.isfinite(y) and abs(y) < 1e9 for _, y in points):
        raise Undrawable
    return points


def _bounded(q: Quantity, s: Scope, band: Band, clock: str, points: Points) -> Curve:
    at = [x for x, _ in points]
    bounds, is_bad = list[Points](), [False] * len(at)
    for b in q.bounds:
        line = _bound(b, s, clock, at)
        drawn = tuple([(x, y) for x, y in zip(at, line, strict=True) if y is not None])
        bounds += [drawn] if drawn else []
        holds = _HOLDS.get(b.op)
        for k, y in enumerate(line if holds else ()):
            if holds and y is not None and not holds(points[k][1], y + _slack(b.op, y)):
                is_bad[k] = True
    return Curve(band, points, tuple(bounds), tuple(is_bad))


def _slack(op: str, y: float) -> float:
    """What rounding may make of a bound that is met exactly, so that no such point is marked."""
    return (1e-9 if op in ("<", "<=") else -1e-9) * (abs(y) + 1.0)


def _bound(b: Bound, s: Scope, clock: str, at: list[float]) -> list[float | None]:
    """The bound at each instant at which its premises hold."""
    try:
        value = s.value(b.value)
        if not all(s.value(p)({}) for p in b.premises if not reads(p, s)):
            return [None] * len(at)
        premises: list[Value] = [s.value(p) for p in b.premises if reads(p, s)]
        if not reads(b.value, s) and not premises:
            return [float(value({}))] * len(at)
    except Undrawable:
        return [None] * len(at)
    return [float(value({clock: x})) if all(p({clock: x}) for p in premises) else None for x in at]


def _spread(band: Band) -> list[float]:
    width = band.high - band.low
    return [band.low + width * k / (_SAMPLES - 1) for k in range(_SAMPLES)]
