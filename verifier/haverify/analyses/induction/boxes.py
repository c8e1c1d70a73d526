"""Premises with no common point on a box, found by splitting it (proofs `b` and `s` of docs/core.md section 9)."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from math import prod
from typing import Any

from haverify.maths.bernstein import bounds
from haverify.maths.digits import rational_text
from haverify.maths.interval import Fault, Interval
from haverify.obligations.formula import Formula, Literal, by_bounds, literals, truth
from haverify.obligations.functions import Functions
from haverify.obligations.induction import names_of
from haverify.obligations.premises import Premises
from haverify.text.record import holder

Q = Fraction
Json = Any
Box = dict[str, tuple[Q, Q]]
MOST_TERMS = 400
LEAF = 100  # the coefficients of a leaf that costs no more than one
PI = (Q(31415926535897932, 10**16), Q(31415926535897933, 10**16))


@holder
class Search:
    """How many coefficients may still be looked at, and how many a leaf has."""

    left: int
    cost: int


def on_boxes(premises: Premises, leaves: int) -> Json | None:
    """A tree of boxes on each of which an entry is false; None where that takes more leaves."""
    box = bounded(premises.entries)
    found = [f for f in premises.entries if _is_within(f, box, premises.functions)]
    if box is None or not found or sum(len(leaf.polynomial.whole) for f in found for leaf in literals(f)) > MOST_TERMS:
        return None
    cost = sum(prod(p.degree(v) + 1 for v in p.variables) for p in (q.polynomial for f in found for q in literals(f)))
    return _tree(premises.functions, found, box, Search(leaves * LEAF, max(LEAF, cost)))


def bounded(entries: Iterable[Formula]) -> Box | None:
    """The bounds that single literals give to names; None where they leave nothing."""
    low: dict[str, Q] = {}
    high: dict[str, Q] = {}
    for f in entries:
        if isinstance(f, Literal) and len(f.polynomial.variables) == 1 and f.polynomial.total_degree() == 1:
            (v,) = f.polynomial.variables
            slope = f.polynomial.terms[((v, 1),)]
            end = -f.polynomial.terms.get((), Q(0)) / slope
            if f.op == "==" or (f.op != "!=" and slope > 0):
                high[v] = min(high.get(v, end), end)
            if f.op == "==" or (f.op != "!=" and slope < 0):
                low[v] = max(low.get(v, end), end)
    box = {v: (low[v], high[v]) for v in low.keys() & high.keys()}
    return None if any(a > b for a, b in box.values()) else box


def _is_within(f: Formula, box: Box | None, functions: Functions) -> bool:
    return box is not None and set(functions.support(names_of(f))) <= box.keys() | {"pi"}


def _tree(functions: Functions, entries: list[Formula], box: Box, search: Search) -> Json | None:
    wide = enclosed(functions, entries, box)
    judged = [(f, _judged(f, wide)) for f in entries]
    if any(t is False for _, t in judged):
        return "b"
    search.left -= search.cost
    names = {v for f, t in judged if t is None for v in functions.support(names_of(f))} & box.keys()
    if search.left < 0 or not names:
        return None
    v = max(sorted(names), key=lambda n: box[n][1] - box[n][0])
    low, high = box[v]
    if low == high:
        return None
    middle = _simple((low + high) / 2, (high - low) / 8)
    halves = []
    for part in ((low, middle), (middle, high)):
        found = _tree(functions, entries, {**box, v: part}, search)
        if found is None:
            return None
        halves.append(found)
    return ["s", v, rational_text(middle), *halves]


def _simple(q: Q, room: Q) -> Q:
    """A short number near another."""
    return q.limit_denominator(max(1, int(1 / room)) + 1)


def _judged(f: Formula, box: Box) -> bool | None:
    return truth(f, lambda leaf: by_bounds(leaf.op, *bounds(leaf.polynomial, box)))


def enclosed(functions: Functions, entries: Iterable[Formula], box: Box) -> Box:
    """The box with an enclosure for each function that the entries read."""
    found = {**box, "pi": PI}
    for n in sorted({n for f in entries for n in names_of(f)}, key=len):
        _enclose(functions, n, found)
    return found


def _enclose(functions: Functions, name: str, box: Box) -> None:
    if name in box or name not in functions.known:
        return
    op, a = functions.known[name]
    for n in a.variables:
        _enclose(functions, n, box)
    try:
        inside = Interval.between(*bounds(a, box))
        named = {"sin": inside.sin, "cos": inside.cos, "exp": inside.exp, "log": inside.log, "sqrt": inside.sqrt}
        value = Interval.at(1) / inside if op == "inv" else named[op]()
        box[name] = (Q(value.low), Q(value.high))
    except Fault:
        box[name] = (Q(-(10**300)) if op != "exp" else Q(0), Q(10**300))
