"""Search for a region tree: regions are split until the truth holds on each, or fails at a point."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from math import gcd
from typing import Any

from haverify.analyses.regions import Node, Terms, Truth
from haverify.analyses.regions_narrow import Narrowing
from haverify.analyses.regions_sample import FEW, MANY, failing
from haverify.analyses.regions_simplex import solve
from haverify.analyses.regions_whole import TINY, Ranges, Region, Whole, box, difference, parted, primitive
from haverify.maths.digits import rational_text
from haverify.text.record import holder

Json = Any
Cut = tuple[Terms, str, int, int]  # a direction, `<=` or `<`, a quotient: the points below are on one side
Point = dict[str, Fraction]
PAUSE = 4_000  # nodes narrowed before many points are tried
ENOUGH = 30  # places that are looked at for a cut
DEEPEST = 250
_MANY = 2  # directions; with more, a region is looked at whether it is empty before it is said that all holds on it


class SpentError(Exception):
    """The search did as much work as it may."""


@holder
class Search:
    """At most `left` nodes are narrowed; `found` is a point at which the truth fails, once there is one.

    The truth is one of whole numbers; `names` are those of its bits, in order.

    After `pause` nodes many points are tried: what fails on a large part is found so, what fails nowhere goes on.
    """

    truth: Truth
    ranges: Ranges
    names: list[str]
    left: int
    pause: int = PAUSE
    found: Point | None = None

    def tree(self, truth: Truth, region: Region, changed: int | None = None, depth: int = 0) -> Json:
        """A tree as docs/core.md section 6 has it; None where the truth fails at a point, which is kept."""
        narrowing = Narrowing(region, changed)
        truth = narrowing.of(truth)
        self._spend(1 + len(narrowing.done), depth)
        if truth is True:
            return (self._nothing(region) if len(region.across) > _MANY else None) or "t"
        if truth is False:
            return self._empty(region)
        terms, relation, top, bottom = cut(truth, region)
        at = Fraction(top, bottom)
        parts = region.split(terms, relation, at)
        names = sum([v for v, _ in terms]) if parts[0].unit == region.unit else None
        branches = []
        for part in parts:
            branches.append(self.tree(truth, part, names, depth + 1))
            if self.found is not None:
                return None
        first = terms[0][1]
        direction = [[self._name(v), rational_text(Fraction(q, first))] for v, q in terms]
        return [relation, direction, rational_text(at / first), *branches]

    def _name(self, bit: int) -> str:
        return self.names[bit.bit_length() - 1]

    def _spend(self, nodes: int, depth: int) -> None:
        self.left -= nodes
        if self.left < 0 or depth > DEEPEST:
            raise SpentError
        if 0 < self.pause <= nodes:
            self.found = failing(self.truth, self.ranges, MANY)
        self.pause -= nodes

    def _empty(self, region: Region) -> Json:
        leaf = self._nothing(region)
        if leaf is None:
            solution = solve(region.exact())
            assert isinstance(solution, dict)
            self.found = {self._name(v): q for v, q in solution.items()}
        return leaf

    def _nothing(self, region: Region) -> Json:
        solution = solve(region.exact())
        return ["f", [[k, rational_text(q)] for k, q in solution]] if isinstance(solution, list) else None


# ---- where to cut ---------------------------------------------------------------


def cut(truth: Node, region: Region) -> Cut:
    """A direction and a number where an open comparison changes; along an axis, where many do, if possible."""
    useful: dict[Cut, int] = {}
    for crossing in (False, True):
        useful |= _useful(_cuts(truth, crossing), region)
        straight = {c: n for c, n in useful.items() if len(c[0]) == 1}
        if straight:
            return max(straight, key=lambda c: (straight[c], -_off_middle(c, region)))
    return max(useful, key=lambda c: useful[c]) if useful else _halved(truth, region)


def _useful(cuts: Iterator[Cut], region: Region) -> dict[Cut, int]:
    """How often cuts inside the region occur, of the first few, or of the first one that is there later."""
    counts: dict[Cut, int] = {}
    for k, found in enumerate(cuts):
        if found in counts or _is_inside(found, region):
            counts[found] = counts.get(found, 0) + 1
        if k >= ENOUGH and counts:
            break
    return counts


def _is_inside(c: Cut, region: Region) -> bool:
    terms, relation, top, bottom = c
    low, high = region.enclose(0, terms)
    end = top * region.unit - (bottom if relation == "<" else 0)
    return low * bottom <= end < high * bottom


def _off_middle(c: Cut, region: Region) -> float:
    """How far a cut of an axis is from the middle; a guide only."""
    low, high = region.axes[c[0][0][0]]
    return abs(2 * c[2] * region.unit - (low + high) * c[3]) / ((high - low) * c[3]) if high > low + 2 else 1.0


def _halved(truth: Node, region: Region) -> Cut:
    """The middle of the widest axis that the truth reads."""
    bits = [v for v in region.axes if v & truth.names]
    name = max(bits, key=lambda v: region.axes[v][1] - region.axes[v][0])
    middle = Fraction(sum(parted(e)[0] for e in region.axes[name]) * TINY, 2 * region.unit)
    return ((name, 1),), "<=", middle.numerator, middle.denominator


def _cuts(t: Node, crossing: bool) -> Iterator[Cut]:
    """Where pieces, and with `crossing` the two sides, of open comparisons change their order."""
    if t.op in ("and", "or"):
        for part in t.parts:
            yield from _cuts(part, crossing)
        return
    a, b, strict = t.parts
    if crossing or not a.names or not b.names:
        yield from _crossings(a, b, strict)
    else:
        yield from _inside(a)
        yield from _inside(b)


def _crossings(a: Node, b: Node, strict: bool) -> Iterator[Cut]:
    """Where a piece of one number meets a piece of the other."""
    for m in _pieces(a):
        for n in _pieces(b):
            if m.low <= n.high and n.low <= m.high:
                yield from _zero(difference(m, n), strict)
    yield from _conditions(a)
    yield from _conditions(b)


def _pieces(n: Node) -> Iterator[Node]:
    if n.op in ("min", "max"):
        for m in n.parts:
            yield from _pieces(m)
    elif n.op == "if":
        for m in n.parts[1:]:
            yield from _pieces(m)
    else:
        yield n


def _conditions(n: Node) -> Iterator[Cut]:
    if n.op == "if" and not isinstance(n.parts[0], bool):
        yield from _cuts(n.parts[0], True)
    if n.op in ("min", "max", "if"):
        for m in n.parts[1:] if n.op == "if" else n.parts:
            yield from _conditions(m)


def _zero(n: Node, strict: bool = False) -> Iterator[Cut]:
    """Where a number is at most 0 (less than 0), as a cut along its direction."""
    if n.op == "sum":
        yield from _inside(n)
    elif n.names:
        constant, terms = n.parts
        g, direction = primitive(terms)
        common = gcd(constant, g) * (1 if g > 0 else -1)
        yield direction, "<" if (g > 0) is strict else "<=", -constant // common, g // common


def _inside(n: Node) -> Iterator[Cut]:
    """Where the members of minima and maxima inside a number change their order, where its choices change."""
    if n.op == "sum":
        for _, m in n.parts[1]:
            yield from _inside(m)
    elif n.op == "if":
        yield from _conditions(n)
        for m in n.parts[1:]:
            yield from _inside(m)
    elif n.op in ("min", "max"):
        for k, m in enumerate(n.parts):
            yield from _inside(m)
            for other in n.parts[:k]:
                if m.op == other.op == "lin" and (not m.names or not other.names or m.names == other.names):
                    yield from _zero(difference(m, other))
        yield from _orders(n)


def _orders(n: Node) -> Iterator[Cut]:
    """The order of members that read different names."""
    lines = [m for m in n.parts if m.op == "lin" and m.names]
    for k, m in enumerate(lines):
        for other in lines[:k]:
            if m.names != other.names:
                yield from _zero(difference(m, other))


def settle(truth: Truth, ranges: Ranges, nodes: int) -> Point | Json:
    """A point (a dictionary) of the box at which a truth fails, or a tree that shows it to hold.

    Raises
    ------
    SpentError              where neither was found
    """
    names = sorted(ranges)
    whole = Whole(truth, names).truth(truth)
    found = failing(whole, ranges, FEW)
    if found is not None:
        return found
    search = Search(whole, ranges, names, nodes)
    tree = search.tree(whole, box(ranges))
    return tree if search.found is None else search.found
