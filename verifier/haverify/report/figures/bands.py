"""The stretches of a clock that a run can spend in each mode: the bands of a figure."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

from haverify.report.figures.evaluate import scope
from haverify.report.figures.material import Json, Material, Undrawable
from haverify.text.record import record

MOST = 36


@record
class Band:
    """A mode and the range of the clock there."""

    mode: str
    low: float
    high: float


def bands(material: Material, automaton: Json, clock: str) -> list[Band]:
    """The bands of a clock, in order of their beginnings.

    They come from the cells of a certificate where there is one, else from the domains.

    Raises
    ------
    Undrawable      if the clock has no bound in some mode, or there are too many bands
    """
    cells = material.cells.get(automaton["name"], {}).get("cells")
    modes = {m["name"]: m for m in automaton["modes"]}
    if cells:
        found = [_of_cell(material, automaton, modes[c["mode"]], c, clock) for c in cells[: 4 * MOST]]
    else:
        found = [_of_domain(material, automaton, m, clock) for m in automaton["modes"]]
    order = list(modes)
    merged = sorted(_merged(found), key=lambda b: (b.low, b.high, order.index(b.mode)))
    if not merged or len(merged) > MOST:
        raise Undrawable
    return merged


def _of_cell(material: Material, automaton: Json, mode: Json, cell: Json, clock: str) -> Band:
    """The entry of a cell stretched by its dwell, within the domain's own bounds on the clock."""
    s = scope(material, automaton, mode)
    low, high = (s.value(end)({}) for end in cell["entry"][clock])
    if cell.get("dwell") is not None:
        stretch = s.value(cell["dwell"])({}) * slope(s.rates, clock, s.value)
        low, high = min(low, low + stretch), max(high, high + stretch)
        return Band(mode["name"], low, high)
    bound = _of_domain(material, automaton, mode, clock)
    return Band(mode["name"], max(low, bound.low), bound.high)


def slope(rates: dict[str, Any], clock: str, value: Any) -> float:
    """The clock's rate in the scaled time of cells: 1 for the first rate that is no plain number."""
    scale = next((rate for rate in rates.values() if not isinstance(rate, str)), "1")
    return float(value(rates[clock])({}) / value(scale)({}))


def _of_domain(material: Material, automaton: Json, mode: Json, clock: str) -> Band:
    """What the declared window and the domain say of the clock alone."""
    s = scope(material, automaton, mode)
    declared: Json = next((v for v in automaton["vars"] if v["name"] == clock), {})
    low = [s.value(declared["low"])({})] if declared.get("low") is not None else []
    high = [s.value(declared["high"])({})] if declared.get("high") is not None else []
    for op, a, b in _comparisons(mode.get("domain")):
        if op in (">", ">="):
            a, b = b, a
        if a == ["var", clock] and not _mentions(b):
            high.append(s.value(b)({}))
        if b == ["var", clock] and not _mentions(a):
            low.append(s.value(a)({}))
    if not low or not high or max(low) > min(high):
        raise Undrawable
    return Band(mode["name"], max(low), min(high))


def _comparisons(e: Any) -> list[tuple[str, Any, Any]]:
    if isinstance(e, list) and e and e[0] == "and":
        return [c for x in e[1:] for c in _comparisons(x)]
    is_one = isinstance(e, list) and len(e) == 3 and e[0] in ("<", "<=", ">", ">=")
    return [(e[0], e[1], e[2])] if is_one else []


def _mentions(e: Any) -> bool:
    return isinstance(e, list) and bool(e) and (e[0] in ("var", "let", "time") or any(map(_mentions, e[1:])))


def _merged(found: list[Band]) -> list[Band]:
    """Bands of one mode that overlap are one."""
    merged: list[Band] = []
    for b in sorted(found, key=lambda b: (b.mode, b.low)):
        last = merged[-1] if merged else None
        if last and last.mode == b.mode and b.low <= last.high:
            merged[-1] = Band(b.mode, last.low, max(last.high, b.high))
        else:
            merged.append(b)
    return merged


def is_one_axis(found: list[Band]) -> bool:
    """Whether the bands follow each other on one axis, none over another."""
    span = max(b.high for b in found) - min(b.low for b in found)
    return all(b.low >= a.high - 1e-6 * span for a, b in pairwise(found))
