"""Trees of regions that show a piecewise linear truth on all of a box of named reals, and its truth at a point."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from math import lcm
from typing import Any

from hacheck.lines import Node, Terms, Truth
from hacheck.rational import Refused, number, spend
from hacheck.regions import CUTS, FOLDS, Ends, Region
from hacheck.whole import Whole, weight

Json = Any


def _show(tree: Json, truth: Truth, region: Region, place: Mapping[str, int]) -> None:
    """Refuse a tree that does not show a truth to hold on all of a region.

    "t": decided by the ends; ["f", [[k, q], ...]]: the region is empty; ["<=", [[name, q], ...], c, below, above]:
    split where the direction is at most c ("<": below c) and where it is not.
    """
    spend(10)
    if tree == "t":
        if not region.shows(region.truth(truth)):
            raise Refused("a leaf of a region tree leaves the claim open")
    elif isinstance(tree, list) and len(tree) == 2 and tree[0] == "f":
        _empty(tree[1], region)
    elif isinstance(tree, list) and len(tree) == 5 and tree[0] in ("<=", "<"):
        left = region.truth(truth)
        terms = _direction(tree[1], place)
        parts = region.split(terms, tree[0], number(tree[2]) * terms[0][1])
        for branch, part in zip(tree[3:], parts, strict=True):
            _show(branch, left, part, place)
    else:
        raise Refused("a region tree is none")


def _direction(given: Json, place: Mapping[str, int]) -> Terms:
    """The direction with whole coefficients; as written it is sorted by name and begins with coefficient 1."""
    terms = [(v, number(q)) for v, q in given]
    names = [v for v, _ in terms]
    if not terms or names != sorted(set(names)) or terms[0][1] != 1 or not all(q for _, q in terms):
        raise Refused("a region is split along no direction")
    if not set(names) <= set(place):
        raise Refused("a region is split along a name that is no input")
    factor = lcm(*(q.denominator for _, q in terms))
    return tuple((place[v], int(q * factor)) for v, q in terms)


def _empty(multipliers: Json, region: Region) -> None:
    """A sum of nonnegative multiples of the region's bounds says 0 < 0, or 0 <= a negative number (Farkas)."""
    directions: list[tuple[Terms, Ends]] = [(((i, 1),), e) for i, e in enumerate(region.axes)]
    directions.extend(region.across.items())
    total: dict[int, Fraction] = {}
    right, strict = Fraction(0), False
    for k, text in multipliers:
        q = number(text)
        if isinstance(k, bool) or not isinstance(k, int) or not 0 <= k < 2 * len(directions) or q <= 0:
            raise Refused("a multiplier is of no bound, or not positive")
        terms, ends = directions[k // 2]
        value, nudge = region.parted(ends[k % 2])
        q *= Fraction(1 if k % 2 else -1, terms[0][1])  # as written the direction begins with coefficient 1
        spend(2 * len(terms))
        for v, c in terms:
            total[v] = total.get(v, Fraction(0)) + q * c
        right, strict = right + q * value, strict or nudge != 0
    if any(total.values()) or right > 0 or (right == 0 and not strict):
        raise Refused("multipliers do not show a region empty")


def box(ranges: Mapping[str, tuple[Fraction, Fraction]], heaviest: int) -> Region:
    """All points with each name in its closed range; `heaviest` is the weight of what it is for."""
    if any(low > high for low, high in ranges.values()):
        raise Refused("the range of an input is empty")
    grain = lcm(*(q.denominator for ends in ranges.values() for q in ends))
    base = 8 << (CUTS + 1) * heaviest.bit_length()
    axes = [(int(a * grain) * base, int(b * grain) * base) for _, (a, b) in sorted(ranges.items())]
    return Region(grain * base, base, axes, {})


def shown(tree: Json, truth: Truth, ranges: Mapping[str, tuple[Fraction, Fraction]]) -> None:
    """Refuse a tree that does not show a truth to hold on all of a box."""
    place = {v: i for i, v in enumerate(sorted(ranges))}
    heaviest = 0
    if not isinstance(truth, bool):
        truth = Whole(truth, place).made(truth)[1]
        heaviest = weight(truth, {})
    _show(tree, truth, box(ranges, heaviest), place)


def holds_at(truth: Truth, point: Mapping[str, Fraction], known: dict[Node, Any] | None = None) -> bool:
    """Is a truth true at a point?"""
    if isinstance(truth, bool):
        return truth
    known = {} if known is None else known
    if truth not in known:
        spend(10)
        if truth.op == "le":
            a, b = (_value(n, point, known) for n in truth.parts[:2])
            known[truth] = a < b or (a == b and not truth.parts[2])
        else:
            known[truth] = (all if truth.op == "and" else any)(holds_at(t, point, known) for t in truth.parts)
    found: bool = known[truth]
    return found


def _value(n: Node, point: Mapping[str, Fraction], known: dict[Node, Any]) -> Fraction:
    """The value of a number at a point."""
    if n not in known:
        spend(10 * len(n.parts))
        if n.op == "line":
            known[n] = n.parts[0] + sum(q * point[v] for v, q in n.parts[1])
        elif n.op == "sum":
            known[n] = sum(q * _value(m, point, known) for q, m in n.parts)
        elif n.op == "if":
            known[n] = _value(n.parts[1 if holds_at(n.parts[0], point, known) else 2], point, known)
        else:
            known[n] = FOLDS[n.op][0](_value(p, point, known) for p in n.parts)
    found: Fraction = known[n]
    return found
