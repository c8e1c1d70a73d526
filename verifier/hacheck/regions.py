"""Regions of real inputs, and trees that show a piecewise linear formula true on all of one.

An end of an interval is (number, nudge): (5, 0) is 5, (5, -1) just below, (5, 1) just above, so that ends compare as
pairs and strictness is exact. A region holds ends for some directions; the axes are the first of them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from fractions import Fraction
from typing import Any

from hacheck.rational import Beyond, Refused, number, spend

Json = Any
End = tuple[Fraction, int]
Terms = tuple[tuple[str, Fraction], ...]  # sorted by name, no coefficient is 0
ZERO: End = (Fraction(0), 0)
UNIT = Fraction(1)
MANY = 12  # pairs of parts of two numbers that are compared


class Node:
    """A number (`lin`, `sum`, `min`, `max`, `if`) with its ends on a region, or a truth (`le`, `and`, `or`).

    `lin`: (constant, terms); `sum`: (constant, ((factor, node), ...)); `if`: (truth, node, node);
    `le`: (node, node, is it strict).
    """

    __slots__ = ("high", "low", "names", "op", "parts", "size")

    def __init__(self, op: str, parts: Any, names: frozenset[str], low: End = ZERO, high: End = ZERO) -> None:
        self.op, self.parts, self.names, self.low, self.high = op, parts, names, low, high
        self.size: int = sum(n.size for n in parts) if op in ("min", "max") else 1  # in how many parts it is compared


Truth = Node | bool


def linear(constant: Fraction, terms: Mapping[str, Fraction] | None = None) -> Node:
    """The number `constant + sum of terms`; its ends are not known yet."""
    kept = tuple(sorted((v, q) for v, q in (terms or {}).items() if q))
    return Node("lin", (constant, kept), frozenset(v for v, _ in kept), (constant, 0), (constant, 0))


def combine(parts: Iterable[tuple[Fraction, Node]], constant: Fraction = Fraction(0)) -> Node:
    """A sum of multiples; linear where all summands are, and equal summands are put together."""
    terms: dict[str, Fraction] = {}
    rest: dict[int, tuple[Fraction, Node]] = {}
    stack = list(parts)
    while stack:
        q, n = stack.pop()
        spend(2 + len(n.parts))
        if n.op in ("lin", "sum"):
            constant += q * n.parts[0]
        if n.op == "lin":
            for v, k in n.parts[1]:
                terms[v] = terms.get(v, Fraction(0)) + q * k
        elif n.op == "sum":
            stack.extend((q * k, m) for k, m in n.parts[1])
        else:
            rest[id(n)] = (rest.get(id(n), (Fraction(0), n))[0] + q, n)
    line = linear(constant, terms)
    kept = tuple((q, n) for q, n in rest.values() if q)
    if not kept:
        return line
    all_parts = (*(((Fraction(1), line),) if line.names else ()), *kept)
    names = frozenset[str]().union(*(n.names for _, n in all_parts))
    return Node("sum", (Fraction(0) if line.names else constant, all_parts), names)


def minus(a: Node, b: Node) -> Node:
    """The difference."""
    if a.op == b.op == "lin" and not (a.names and b.names):
        constant, terms = a.parts[0] - b.parts[0], a.parts[1] or tuple((v, -q) for v, q in b.parts[1])
        return Node("lin", (constant, terms), a.names or b.names, (constant, 0), (constant, 0))
    return combine([(UNIT, a), (-UNIT, b)])


def least(op: str, parts: Iterable[Node]) -> Node:
    """`min` or `max` of numbers, at least one."""
    kept = {id(m): m for n in parts for m in (n.parts if n.op == op else (n,))}
    spend(len(kept))
    if len(kept) == 1:
        return next(iter(kept.values()))
    return Node(op, tuple(kept.values()), frozenset[str]().union(*(n.names for n in kept.values())))


def choice(condition: Truth, a: Node, b: Node) -> Node:
    """`a` where the condition is true, else `b`."""
    if isinstance(condition, bool) or a is b:
        return b if condition is False else a
    return Node("if", (condition, a, b), condition.names | a.names | b.names)


def at_most(a: Node, b: Node, strict: bool = False) -> Truth:
    """`a <= b`, or `a < b`."""
    if not a.names and not b.names and a.op == b.op == "lin":
        return a.low < b.low if strict else a.low <= b.low
    return Node("le", (a, b, strict), a.names | b.names)


def join(op: str, parts: Iterable[Truth]) -> Truth:
    """`and` or `or` of truths."""
    kept: list[Node] = []
    for t in parts:
        if isinstance(t, bool):
            if t is (op == "or"):
                return t
        else:
            kept.extend(t.parts if t.op == op else (t,))
    spend(len(kept))
    if not kept:
        return op == "and"
    return kept[0] if len(kept) == 1 else Node(op, tuple(kept), frozenset[str]().union(*(t.names for t in kept)))


def denied(t: Truth) -> Truth:
    """The negation."""
    if isinstance(t, bool):
        return not t
    spend(1)
    if t.op == "le":
        return at_most(t.parts[1], t.parts[0], not t.parts[2])
    return join("or" if t.op == "and" else "and", map(denied, t.parts))


def scaled(q: Fraction, low: End, high: End) -> tuple[End, End]:
    """The ends of q times a number."""
    if q < 0:
        return (q * high[0], -high[1]), (q * low[0], -low[1])
    return (q * low[0], low[1]), (q * high[0], high[1])


def added(ends: Iterable[tuple[End, End]], constant: Fraction) -> tuple[End, End]:
    """The ends of a sum of numbers and a constant."""
    low = high = constant
    above = below = 0
    for a, b in ends:
        low, high, above, below = low + a[0], high + b[0], above | a[1], below | b[1]
    return (low, above), (high, below)


class Region:
    """All points whose directions lie between their ends."""

    def __init__(self, ends: dict[Terms, tuple[End, End]]) -> None:
        self.ends = ends

    def enclose(self, constant: Fraction, terms: Terms) -> tuple[End, End]:
        """The ends of a linear number, from the axes and from its own direction."""
        spend(3 * len(terms) + 2)
        if len(terms) == 1:
            v, q = terms[0]
            (x, up), (y, down) = self.ends[((v, UNIT),)]
            ends = (constant + q * x, up), (constant + q * y, down)
            return ends if q > 0 else ((ends[1][0], -down), (ends[0][0], -up))
        low, high = added([scaled(q, *self.ends[((v, UNIT),)]) for v, q in terms], constant)
        if len(terms) > 1:
            first = terms[0][1]
            known = self.ends.get(tuple((v, q / first) for v, q in terms))
            if known is not None:
                a, b = added([scaled(first, *known)], constant)
                low, high = max(low, a), min(high, b)
        return low, high

    def split(self, terms: Terms, relation: str, at: Fraction) -> tuple[Region, Region]:
        """Where a direction is at most a number (`<=`) or below it (`<`), and the rest."""
        low, high = self.enclose(Fraction(0), terms)
        below, above = ((at, 0), (at, 1)) if relation == "<=" else ((at, -1), (at, 0))
        return (Region({**self.ends, terms: (low, min(high, below))}),
                Region({**self.ends, terms: (max(low, above), high)}))  # fmt: skip


class Narrowing:
    """What is left of numbers and truths on a region; only what reads one of the `changed` names is looked at."""

    def __init__(self, region: Region, changed: frozenset[str] | None) -> None:
        self.region, self.changed = region, changed
        self.done: dict[int, tuple[Node, Any]] = {}
        self.shared: dict[tuple[int, bool, bool, End], tuple[Node, Truth]] = {}
        self.crossed = any(len(d) > 1 for d in region.ends)

    def of(self, n: Any) -> Any:
        """The node on this region, a truth value where a truth is decided."""
        if isinstance(n, bool) or (self.changed is not None and not n.names & self.changed):
            return n
        if id(n) not in self.done:
            spend(2)
            self.done[id(n)] = (n, self._number(n) if n.op in ("lin", "sum", "min", "max", "if") else self._truth(n))
        return self.done[id(n)][1]

    def _number(self, n: Node) -> Node:
        if n.op == "lin":
            return self._bounded(n)
        if n.op == "sum":
            return self._bounded(combine([(q, self.of(m)) for q, m in n.parts[1]], n.parts[0]))
        if n.op == "if":
            made = choice(*map(self.of, n.parts))
            return self._bounded(made) if made.op == "if" else made
        return self._extreme(n.op, least(n.op, map(self.of, n.parts)))

    def _bounded(self, n: Node) -> Node:
        if n.op == "lin":
            n = Node("lin", n.parts, n.names)
            n.low, n.high = self.region.enclose(*n.parts)
        elif n.op == "sum":
            n.low, n.high = added([scaled(q, *self._known(m)) for q, m in n.parts[1]], n.parts[0])
        elif n.op == "if":
            n.low, n.high = min(n.parts[1].low, n.parts[2].low), max(n.parts[1].high, n.parts[2].high)
        return n

    def _known(self, n: Node) -> tuple[End, End]:
        return self.region.enclose(*n.parts) if n.op == "lin" else (n.low, n.high)

    def _extreme(self, op: str, n: Node) -> Node:
        """Without the members that are never the least (greatest) alone."""
        if n.op != op:
            return n
        if op == "min":
            best = min(n.parts, key=lambda m: (m.high, m.low))
            kept = [m for m in n.parts if m is best or m.low < best.high]
        else:
            best = max(n.parts, key=lambda m: (m.low, m.high))
            kept = [m for m in n.parts if m is best or m.high > best.low]
        read = [m.names for m in kept if m.op == "lin" and m.names]
        if len(kept) < 9 and (self.crossed or len(set(read)) < len(read)):
            kept = self._undominated(op, kept)
        made = least(op, kept)
        if made.op == op:
            pick = min if op == "min" else max
            made.low, made.high = pick(m.low for m in kept), pick(m.high for m in kept)
        return made

    def _undominated(self, op: str, parts: list[Node]) -> list[Node]:
        kept: list[Node] = []
        for m in parts:
            if any(self.order(*((k, m) if op == "min" else (m, k)), False) is True for k in kept):
                continue
            kept = [k for k in kept if self.order(*((m, k) if op == "min" else (k, m)), False) is not True] + [m]
        return kept

    def _truth(self, t: Node) -> Truth:
        if t.op != "le":
            return join(t.op, map(self.of, t.parts))
        return self._compared(self.of(t.parts[0]), self.of(t.parts[1]), t.parts[2])

    def _compared(self, a: Node, b: Node, strict: bool) -> Truth:
        """The order of two numbers; where one is a constant, shared out among the members of the other."""
        found = self.order(a, b, strict)
        if found is not None:
            return found
        n, bound = (a, b) if a.names else (b, a)
        if bound.names or n.op not in ("min", "max", "if"):
            return Node("le", (a, b, strict), a.names | b.names)
        key = id(n), n is a, strict, bound.low
        if key not in self.shared:
            members = n.parts[1:] if n.op == "if" else n.parts
            parts = [self._compared(m, b, strict) if n is a else self._compared(a, m, strict) for m in members]
            if n.op == "if":
                parts = [join("and", [n.parts[0], parts[0]]), join("and", [denied(n.parts[0]), parts[1]])]
            self.shared[key] = n, join("and" if n.op == ("max" if n is a else "min") else "or", parts)
        return self.shared[key][1]

    def order(self, a: Node, b: Node, strict: bool) -> bool | None:
        """Is `a <= b` (`a < b`) on the whole region (True), nowhere (False), or not known?"""
        spend(3)
        if a is b:
            return not strict
        if (a.high < b.low) if strict else (a.high <= b.low):
            return True
        if (a.low >= b.high) if strict else (a.low > b.high):
            return False
        if _is_among(b, a) if strict else _is_among(a, b):
            return not strict
        if a.size * b.size > MANY:
            return None
        for n, smaller in ((a, True), (b, False)):
            if n.op in ("max", "if") or (n.op == "min" and not (smaller and b.op == "min")):
                parts = n.parts[1:] if n.op == "if" else n.parts
                found = (self.order(m, b, strict) if smaller else self.order(a, m, strict) for m in parts)
                if n.op == "if":
                    first, second = found
                    return first if first is second else None
                return _every(found) if (n.op == "max") is smaller else _some(found)
        return self._signs(minus(a, b), strict)

    def _signs(self, n: Node, strict: bool) -> bool | None:
        low, high = self._known(self._bounded(n))
        if high < ZERO or (high == ZERO and not strict):
            return True
        return False if low > ZERO or (low == ZERO and strict) else None


def _is_among(a: Node, b: Node) -> bool:
    """Is `a <= b` because the members of a minimum, or of a maximum, are among those of the other?"""
    if a.op == "min" and b.op != "max":
        return {id(n) for n in (b.parts if b.op == "min" else (b,))} <= {id(n) for n in a.parts}
    return b.op == "max" and {id(n) for n in (a.parts if a.op == "max" else (a,))} <= {id(n) for n in b.parts}


def _every(found: Iterable[bool | None]) -> bool | None:
    out: bool | None = True
    for f in found:
        if f is False:
            return False
        out = out if f else None
    return out


def _some(found: Iterable[bool | None]) -> bool | None:
    out: bool | None = False
    for f in found:
        if f:
            return True
        out = None if f is None else out
    return out


def true_on(tree: Json, truth: Truth, region: Region, changed: frozenset[str] | None = None) -> None:
    """Refuse a tree that does not show a truth to hold on all of a region.

    "t": decided by the ends; ["f", [[k, q], ...]]: the region is empty; ["<=", [[name, q], ...], c, below, above]:
    split where the direction is at most c ("<": below c) and where it is not.
    """
    spend(10)
    if tree == "t":
        if Narrowing(region, changed).of(truth) is not True:
            raise Refused("a leaf of a region tree leaves the claim open")
    elif isinstance(tree, list) and len(tree) == 2 and tree[0] == "f":
        _empty(tree[1], region)
    elif isinstance(tree, list) and len(tree) == 5 and tree[0] in ("<=", "<"):
        left = Narrowing(region, changed).of(truth)
        terms = _direction(tree[1], region)
        names = frozenset(v for v, _ in terms)
        for branch, part in zip(tree[3:], region.split(terms, tree[0], number(tree[2])), strict=True):
            true_on(branch, left, part, names)
    else:
        raise Refused("a region tree is none")


def _direction(given: Json, region: Region) -> Terms:
    terms = tuple((v, number(q)) for v, q in given)
    names = [v for v, _ in terms]
    if not terms or names != sorted(set(names)) or terms[0][1] != 1 or not all(q for _, q in terms):
        raise Refused("a region is split along no direction")
    if any(((v, Fraction(1)),) not in region.ends for v in names):
        raise Refused("a region is split along a name that is no input")
    return terms


def _empty(multipliers: Json, region: Region) -> None:
    """A sum of nonnegative multiples of the region's bounds says 0 < 0, or 0 <= a negative number (Farkas)."""
    bounds = [b for d, (low, high) in region.ends.items() for b in ((d, Fraction(-1), low), (d, Fraction(1), high))]
    total: dict[str, Fraction] = {}
    right, strict = Fraction(0), False
    for k, text in multipliers:
        q = number(text)
        if isinstance(k, bool) or not isinstance(k, int) or not 0 <= k < len(bounds) or q <= 0:
            raise Refused("a multiplier is of no bound, or not positive")
        direction, sign, (value, nudge) = bounds[k]
        spend(2 * len(direction))
        for v, c in direction:
            total[v] = total.get(v, Fraction(0)) + q * sign * c
        right, strict = right + q * sign * value, strict or nudge != 0
    if any(total.values()) or right > 0 or (right == 0 and not strict):
        raise Refused("multipliers do not show a region empty")


def box(ranges: Mapping[str, tuple[Fraction, Fraction]]) -> Region:
    """All points with each name in its closed range."""
    if any(low > high for low, high in ranges.values()):
        raise Refused("the range of an input is empty")
    return Region({((v, Fraction(1)),): ((low, 0), (high, 0)) for v, (low, high) in sorted(ranges.items())})


def holds_at(truth: Truth, point: Mapping[str, Fraction]) -> bool:
    """Is a truth true at a point?"""
    found = Narrowing(box({v: (q, q) for v, q in point.items()}), None).of(truth)
    if not isinstance(found, bool):
        raise Beyond("a truth that a point does not decide")
    return found
