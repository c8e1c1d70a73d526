"""What piecewise linear numbers are, and which truths about them hold, on a region of reals, in whole numbers.

Lines are multiplied so that their coefficients are whole, the ends of a region by its `unit`: x >= 5 is 5 unit,
x > 5 is 5 unit + 1. That 1 stands for an infinitely small number: the unit has a factor, `base`, so large that no sum
of such ones comes near its half. So all ends are closed, and strictness is exact.
"""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from math import gcd
from typing import Any

from hacheck.lines import Node, Terms, Truth, choice, denied, difference, join, pick, plus
from hacheck.rational import Beyond, spend
from hacheck.whole import MAX_BITS

Ends = tuple[int, int]
Multiple = tuple[int, Node]
CUTS = 2  # directions whose ends bound a line together


class Region:
    """All points with each axis, and each direction (terms without a common factor), between its two ends."""

    def __init__(self, unit: int, base: int, axes: list[Ends], across: dict[Terms, Ends]) -> None:
        self.unit, self.base, self.axes, self.across = unit, base, axes, across
        self.cost = 1 + unit.bit_length() // 256
        self._ends: dict[Node, Ends] = {}
        self._left: dict[Node, Any] = {}
        self._shown: dict[Node, bool] = {}
        if unit.bit_length() > MAX_BITS:
            raise Beyond("ends with too large denominators")

    # ---- numbers

    def line(self, n: Node) -> Ends:
        """The ends of a line, from the axes and from its own direction."""
        low = high = n.parts[0] * self.unit
        terms = n.parts[1]
        for i, q in terms:
            a, b = self.axes[i]
            low, high = (low + q * a, high + q * b) if q > 0 else (low + q * b, high + q * a)
        spend(self.cost * (2 + len(terms)))
        if self.across and len(terms) > 1:
            g = gcd(*[q for _, q in terms]) * (1 if terms[0][1] > 0 else -1)
            known = self.across.get(tuple([(i, q // g) for i, q in terms]))
            if known is not None:
                a, b = sorted(n.parts[0] * self.unit + g * e for e in known)
                low, high = max(low, a), min(high, b)
        return low, high

    def ends(self, n: Node) -> Ends:
        """The ends of a number, by interval arithmetic."""
        found = self._ends.get(n)
        if found is None:
            if n.op == "line":
                found = self.line(n)
            elif n.op == "sum":
                found = self.total(n.parts)
            else:
                ends = [self.ends(p) for p in (n.parts[1:] if n.op == "if" else n.parts)]
                spend(self.cost * len(ends))
                first, last = FOLDS[n.op]
                found = first([e[0] for e in ends]), last([e[1] for e in ends])
            self._ends[n] = found
        return found

    def total(self, parts: Iterable[Multiple]) -> Ends:
        """The ends of a sum of multiples."""
        low = high = 0
        for q, n in parts:
            a, b = self.ends(n)
            low, high = (low + q * a, high + q * b) if q > 0 else (low + q * b, high + q * a)
        return low, high

    def left(self, n: Node) -> Node:
        """What is left of a number: without members of maxima that are never the greatest, and so on."""
        if n.op == "line":
            return n
        found: Node | None = self._left.get(n)
        if found is None:
            found = self._left[n] = self._number(n)
        return found

    def _number(self, n: Node) -> Node:
        if n.op == "if":
            condition = self.truth(n.parts[0])
            if isinstance(condition, bool):
                return self.left(n.parts[1 if condition else 2])
            return choice(condition, self.left(n.parts[1]), self.left(n.parts[2]))
        if n.op == "sum":
            return plus(*[(q, self.left(m)) for q, m in n.parts])
        return self._extreme(n, tuple(map(self.left, n.parts)))

    def _extreme(self, n: Node, parts: tuple[Node, ...]) -> Node:
        """Without the members that are never the greatest (least) alone."""
        ends = [self.ends(p) for p in parts]
        if n.op == "min":
            ends = [(-b, -a) for a, b in ends]
        best = max(ends)
        at = ends.index(best)
        kept = tuple([p for k, p in enumerate(parts) if k == at or ends[k][1] > best[0]])
        if self.across and len(kept) > 1:
            kept = self._undominated(n.op, kept)
        return n if kept == n.parts else pick(n.op, kept)

    def _undominated(self, op: str, parts: tuple[Node, ...]) -> tuple[Node, ...]:
        """Without lines that another line is never below (above)."""
        kept: list[Node] = []
        for p in parts:
            if p.op != "line":
                kept.append(p)
            elif not any(self._is_beyond(op, k, p) for k in kept):
                kept = [*(k for k in kept if not self._is_beyond(op, p, k)), p]
        return tuple(kept)

    def _is_beyond(self, op: str, a: Node, b: Node) -> bool:
        """Is a line everywhere at least (at most) as large as another?"""
        if a.op != "line" or b.op != "line":
            return False
        low, high = self.line(difference(a, b))
        return low >= 0 if op == "max" else high <= 0

    # ---- truths

    def truth(self, t: Truth) -> Truth:
        """What is left of a truth: true or false where the ends decide it."""
        if isinstance(t, bool):
            return t
        found: Truth | None = self._left.get(t)
        if found is None:
            found = self._left[t] = self._compared(t) if t.op == "le" else join(t.op, map(self.truth, t.parts))
        return found

    def _compared(self, t: Node) -> Truth:
        a, b, strict = self.left(t.parts[0]), self.left(t.parts[1]), t.parts[2]
        low, high = self.total(((1, a), (-1, b)))
        if low <= 0 <= high or self.across:
            ends = self.ends(difference(a, b))  # closer: what they have in common cancels
            low, high = max(low, ends[0]), min(high, ends[1])
        if high < 0 or (high == 0 and not strict) or low > high:  # or no point is in the region
            return True
        if low > 0 or (low == 0 and strict):
            return False
        return t if a is t.parts[0] and b is t.parts[1] else Node("le", (a, b, strict))

    def shows(self, t: Truth) -> bool:
        """Is a truth shown true on all of the region?"""
        if isinstance(t, bool):
            return t
        if t not in self._shown:
            if t.op == "le":
                self._shown[t] = self._below(((1, t.parts[0]), (-1, t.parts[1])), t.parts[2])
            else:
                self._shown[t] = (all if t.op == "and" else any)(map(self.shows, t.parts))
        return self._shown[t]

    def _below(self, parts: tuple[Multiple, ...], strict: bool) -> bool:
        """Is a sum at most 0 (below 0)? With a maximum it is if it is with each member, with a minimum if with one."""
        if not strict and len(parts) == 2 and _is_among(*parts):
            return True
        low, high = self.total(parts)
        whole = plus(*parts)
        a, b = self.ends(whole)
        low, high = max(low, a), min(high, b)
        if high < 0 or (high == 0 and not strict) or low > high:
            return True
        if low > 0 or (low == 0 and strict) or whole.op == "line":
            return whole.op == "line" and low <= 0 and self._is_cut_below(whole, strict)
        pieces = [(k, f, n) for k, (q, p) in enumerate(parts) for f, n in _summands(p) if n.op != "line"]
        if len(pieces) > sum(n.op != "line" for _, n in _summands(whole)):
            return self._below(((1, whole),), strict)
        for wants_all in (True, False):
            for k, f, n in pieces:
                q, p = parts[k]
                if (n.op == "if" or (n.op == "max") is (q * f > 0)) is wants_all:
                    rest = [(g, m) for g, m in _summands(p) if m is not n]
                    put = [(q, m if n is p else plus((f, m), *rest)) for m in self._members(n)]
                    cases = (self._below((*parts[:k], part, *parts[k + 1 :]), strict) for part in put)
                    if wants_all or any(cases):
                        return all(cases) if wants_all else True
        return False

    def _is_cut_below(self, n: Node, strict: bool, offset: int = 0, cuts: int = CUTS) -> bool:
        """Is a line plus an offset at most 0 (below 0) because of the ends of few directions and those of the axes?"""
        for direction, (low, high) in self.across.items() if cuts else ():
            for place, c in direction:
                q = dict(n.parts[1]).get(place, 0) * (1 if c > 0 else -1)
                if q:
                    rest = plus((abs(c), n), (-q, Node("line", (0, direction))))  # does not read that place
                    more = abs(c) * offset + q * (high if q > 0 else low)
                    end = self.line(rest)[1] + more
                    if end < 0 or (end == 0 and not strict) or self._is_cut_below(rest, strict, more, cuts - 1):
                        return True
        return False

    def _members(self, n: Node) -> tuple[Node, ...]:
        """Of which numbers a number is one."""
        if n.op == "if":
            condition, a, b = n.parts
            if self.shows(self.truth(condition)):
                return (a,)
            return (b,) if self.shows(self.truth(denied(condition))) else (a, b)
        members: tuple[Node, ...] = n.parts
        return members

    # ---- smaller regions

    def finer(self, factor: int, heaviest: int) -> Region:
        """The same region with a larger unit: for ends with larger denominators, for directions of more weight."""
        base = max(self.base, 8 << (CUTS + 1) * heaviest.bit_length())
        if factor == 1 and base == self.base:
            return self

        def end(e: int) -> int:
            q, nudge = self.parted(e)
            return q * factor * base + nudge

        axes = [(end(a), end(b)) for a, b in self.axes]
        across = {d: (end(a), end(b)) for d, (a, b) in self.across.items()}
        return Region(self.unit // self.base * factor * base, base, axes, across)

    def parted(self, end: int) -> tuple[int, int]:
        """An end without the infinitely small part, in units divided by `base`, and that part."""
        q = (end + self.base // 2) // self.base
        return q, end - q * self.base

    def split(self, terms: Terms, relation: str, at: Fraction) -> tuple[Region, Region]:
        """Where a direction is at most a number (`<=`) or below it (`<`), and the rest."""
        grain = self.unit // self.base
        here = self.finer(at.denominator // gcd(at.denominator, grain), sum(abs(q) for _, q in terms))
        low, high = here.line(Node("line", (0, terms)))
        end = int(at * here.unit) - (relation == "<")
        return here.cut(terms, low, min(high, end)), here.cut(terms, max(low, end + 1), high)

    def cut(self, terms: Terms, low: int, high: int) -> Region:
        """The part of the region with other ends for one direction."""
        if len(terms) > 1:
            return Region(self.unit, self.base, self.axes, {**self.across, terms: (low, high)})
        i = terms[0][0]
        return Region(self.unit, self.base, [*self.axes[:i], (low, high), *self.axes[i + 1 :]], self.across)


FOLDS: dict[str, Any] = {"max": (max, max), "min": (min, min), "if": (min, max)}


def _summands(n: Node) -> tuple[Multiple, ...]:
    parts: tuple[Multiple, ...] = n.parts if n.op == "sum" else ((1, n),)
    return parts


def _is_among(one: Multiple, other: Multiple) -> bool:
    """Are two numbers with opposite signs a member of a maximum and that, or a minimum and a member of it?"""
    (p, a), (q, b) = (one, other) if one[0] > 0 else (other, one)
    return p == -q and (a is b or (b.op == "max" and a in b.parts) or (a.op == "min" and b in a.parts))
