"""Piecewise linear numbers and truths over named reals, and what is left of them on a region.

An end of an interval is (number, nudge): (5, 0) is 5, (5, -1) just below, (5, 1) just above, so that ends compare as
pairs and strictness is exact. A region holds ends for some directions; the axes are the first of them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from fractions import Fraction
from itertools import chain
from typing import Any

End = tuple[Fraction, int]
Ends = tuple[End, End]
Terms = tuple[tuple[str, Fraction], ...]
"""A linear number without its constant: sorted by name, no coefficient is 0. A direction begins with coefficient 1."""

NUMBERS = frozenset({"lin", "sum", "min", "max", "if"})
ORIGIN: End = (Fraction(0), 0)
_UNIT = Fraction(1)
_FEW = 9  # members of a minimum that are compared with each other
_MANY = 12  # pairs of parts of two numbers that are compared


class Node:
    """A number (`lin`, `sum`, `min`, `max`, `if`) with its ends on a region, or a truth (`le`, `and`, `or`).

    `lin`: (constant, terms); `sum`: (constant, ((factor, node), ...)); `if`: (truth, node, node);
    `le`: (node, node, is it strict).
    """

    __slots__ = ("high", "low", "names", "op", "parts", "size")

    def __init__(self, op: str, parts: Any, names: frozenset[str], low: End = ORIGIN, high: End = ORIGIN) -> None:
        self.op, self.parts, self.names, self.low, self.high = op, parts, names, low, high
        self.size: int = sum(n.size for n in parts) if op in ("min", "max") else 1  # in how many parts it is compared


Truth = Node | bool


def linear(constant: Fraction, terms: Mapping[str, Fraction] | None = None) -> Node:
    """The number `constant + sum of terms`; its ends are those of the constant."""
    kept = tuple(sorted((v, q) for v, q in (terms or {}).items() if q))
    return Node("lin", (constant, kept), frozenset(v for v, _ in kept), (constant, 0), (constant, 0))


def named(name: str) -> Node:
    """The number that a name stands for."""
    return linear(Fraction(0), {name: Fraction(1)})


def combine(parts: Iterable[tuple[Fraction, Node]], constant: Fraction = Fraction(0)) -> Node:
    """A sum of multiples; linear where all summands are, and equal summands are put together."""
    terms: dict[str, Fraction] = {}
    rest: dict[int, tuple[Fraction, Node]] = {}
    stack = list(parts)
    while stack:
        q, n = stack.pop()
        if n.op in ("lin", "sum"):
            constant += q * n.parts[0]
        if n.op == "lin":
            for v, k in n.parts[1]:
                terms[v] = terms.get(v, Fraction(0)) + q * k
        elif n.op == "sum":
            stack.extend((q * k, m) for k, m in n.parts[1])
        else:
            rest[id(n)] = (rest.get(id(n), (Fraction(0), n))[0] + q, n)
    return _sum(linear(constant, terms), [(q, n) for q, n in rest.values() if q])


def _sum(line: Node, rest: list[tuple[Fraction, Node]]) -> Node:
    if not rest:
        return line
    parts = (*(((Fraction(1), line),) if line.names else ()), *rest)
    return Node("sum", (Fraction(0) if line.names else line.parts[0], parts), _names(n for _, n in parts))


def minus(a: Node, b: Node) -> Node:
    """The difference."""
    if a.op == b.op == "lin" and not (a.names and b.names):
        terms = a.parts[1] or tuple((v, -q) for v, q in b.parts[1])
        constant = a.parts[0] - b.parts[0]
        return Node("lin", (constant, terms), a.names or b.names, (constant, 0), (constant, 0))
    return combine([(_UNIT, a), (-_UNIT, b)])


def extreme(op: str, parts: Iterable[Node]) -> Node:
    """`min` or `max` of numbers, at least one."""
    kept = {id(m): m for n in parts for m in (n.parts if n.op == op else (n,))}
    if len(kept) == 1:
        return next(iter(kept.values()))
    return Node(op, tuple(kept.values()), _names(kept.values()))


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


def both(parts: Iterable[Truth]) -> Truth:
    """The conjunction."""
    return _join("and", parts)


def either(parts: Iterable[Truth]) -> Truth:
    """The disjunction."""
    return _join("or", parts)


def _join(op: str, parts: Iterable[Truth]) -> Truth:
    kept: list[Node] = []
    for t in parts:
        if isinstance(t, bool):
            if t is (op == "or"):
                return t
        else:
            kept.extend(t.parts if t.op == op else (t,))
    if not kept:
        return op == "and"
    return kept[0] if len(kept) == 1 else Node(op, tuple(kept), _names(kept))


def _names(nodes: Iterable[Node]) -> frozenset[str]:
    return frozenset(chain.from_iterable(n.names for n in nodes))


def denied(t: Truth) -> Truth:
    """The negation."""
    if isinstance(t, bool):
        return not t
    if t.op == "le":
        return at_most(t.parts[1], t.parts[0], not t.parts[2])
    return _join("or" if t.op == "and" else "and", map(denied, t.parts))


# ---- regions --------------------------------------------------------------------


def scaled(q: Fraction, low: End, high: End) -> Ends:
    """The ends of q times a number."""
    if q < 0:
        return (q * high[0], -high[1]), (q * low[0], -low[1])
    return (q * low[0], low[1]), (q * high[0], high[1])


def added(ends: Iterable[Ends], constant: Fraction) -> Ends:
    """The ends of a sum of numbers and a constant."""
    low = high = constant
    above = below = 0
    for a, b in ends:
        low, high, above, below = low + a[0], high + b[0], above | a[1], below | b[1]
    return (low, above), (high, below)


def axis(name: str) -> Terms:
    """The direction of one name."""
    return ((name, _UNIT),)


class Region:
    """All points whose directions lie between their ends."""

    def __init__(self, ends: dict[Terms, Ends]) -> None:
        self.ends = ends
        self.is_crossed = any(len(d) > 1 for d in ends)

    def enclose(self, constant: Fraction, terms: Terms) -> Ends:
        """The ends of a linear number, from the axes and from its own direction."""
        if len(terms) == 1:
            v, q = terms[0]
            (x, up), (y, down) = self.ends[axis(v)]
            ends = (constant + q * x, up), (constant + q * y, down)
            return ends if q > 0 else ((ends[1][0], -down), (ends[0][0], -up))
        low, high = added([scaled(q, *self.ends[axis(v)]) for v, q in terms], constant)
        if len(terms) > 1 and self.is_crossed:
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
        return Region({**self.ends, terms: (low, min(high, below))}), Region(
            {**self.ends, terms: (max(low, above), high)}
        )


def box(ranges: Mapping[str, tuple[Fraction, Fraction]]) -> Region:
    """All points with each name in its closed range."""
    return Region({axis(v): ((low, 0), (high, 0)) for v, (low, high) in sorted(ranges.items())})


# ---- what is left on a region ---------------------------------------------------


class Narrowing:
    """What is left of numbers and truths on a region; only what reads one of the `changed` names is looked at."""

    def __init__(self, region: Region, changed: frozenset[str] | None = None) -> None:
        self.region, self.changed = region, changed
        self.done: dict[int, tuple[Node, Any]] = {}
        self.shared: dict[tuple[int, bool, bool, End], tuple[Node, Truth]] = {}

    def of(self, n: Any) -> Any:
        """The node on this region, a truth value where a truth is decided."""
        if isinstance(n, bool) or (self.changed is not None and not n.names & self.changed):
            return n
        found = self.done.get(id(n))
        if found is None:
            found = self.done[id(n)] = (n, self._number(n) if n.op in NUMBERS else self._truth(n))
        return found[1]

    def _number(self, n: Node) -> Node:
        if n.op == "lin":
            return self._bounded(Node("lin", n.parts, n.names))
        if n.op == "sum":
            return self._bounded(combine([(q, self.of(m)) for q, m in n.parts[1]], n.parts[0]))
        if n.op == "if":
            made = choice(*map(self.of, n.parts))
            return self._bounded(made) if made.op == "if" else made
        return self._extreme(n.op, extreme(n.op, map(self.of, n.parts)))

    def _bounded(self, n: Node) -> Node:
        """The node with its ends; those of the parts are known."""
        if n.op == "lin":
            n.low, n.high = self.region.enclose(*n.parts)
        elif n.op == "sum":
            n.low, n.high = added([scaled(q, *self._known(m)) for q, m in n.parts[1]], n.parts[0])
        elif n.op == "if":
            n.low, n.high = min(n.parts[1].low, n.parts[2].low), max(n.parts[1].high, n.parts[2].high)
        return n

    def _known(self, n: Node) -> Ends:
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
        if len(kept) < _FEW and (self.region.is_crossed or _have_equal_names(kept)):
            kept = self._undominated(op, kept)
        made = extreme(op, kept)
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
            return _join(t.op, map(self.of, t.parts))
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
            parts = [self._compared(m, b, strict) if n is a else self._compared(a, m, strict) for m in _alternatives(n)]
            self.shared[key] = (
                n,
                _chosen(n, parts) if n.op == "if" else _join("and" if (n.op == "max") is (n is a) else "or", parts),
            )
        return self.shared[key][1]

    def order(self, a: Node, b: Node, strict: bool) -> bool | None:
        """Is `a <= b` (`a < b`) on the whole region (True), nowhere (False), or not known?"""
        if a is b:
            return not strict
        if (a.high < b.low) if strict else (a.high <= b.low):
            return True
        if (a.low >= b.high) if strict else (a.low > b.high):
            return False
        if _is_among(b, a) if strict else _is_among(a, b):
            return not strict
        if a.size * b.size > _MANY:
            return None
        if a.op in ("max", "if") or (a.op == "min" and b.op != "min"):
            return _by_parts(a, (self.order(m, b, strict) for m in _alternatives(a)), a.op == "max")
        if b.op in ("min", "max", "if"):
            return _by_parts(b, (self.order(a, m, strict) for m in _alternatives(b)), b.op == "min")
        low, high = self._known(self._bounded(minus(a, b)))
        if high < ORIGIN or (high == ORIGIN and not strict):
            return True
        return False if low > ORIGIN or (low == ORIGIN and strict) else None


def _chosen(n: Node, parts: Iterable[Truth]) -> Truth:
    """What holds of a choice, by what holds of its two numbers."""
    first, second = parts
    return either([both([n.parts[0], first]), both([denied(n.parts[0]), second])])


def _have_equal_names(nodes: list[Node]) -> bool:
    """Do two linear numbers read the same names?"""
    read = [n.names for n in nodes if n.op == "lin" and n.names]
    return len(set(read)) < len(read)


def _is_among(a: Node, b: Node) -> bool:
    """Is `a <= b` because the members of a minimum, or of a maximum, are among those of the other?"""
    if a.op == "min" and b.op != "max":
        return set(map(id, _members("min", b))) <= set(map(id, a.parts))
    return b.op == "max" and set(map(id, _members("max", a))) <= set(map(id, b.parts))


def _members(op: str, n: Node) -> tuple[Node, ...]:
    parts: tuple[Node, ...] = n.parts if n.op == op else (n,)
    return parts


def _alternatives(n: Node) -> tuple[Node, ...]:
    parts: tuple[Node, ...] = n.parts[1:] if n.op == "if" else n.parts
    return parts


def _by_parts(n: Node, found: Iterable[bool | None], needs_all: bool) -> bool | None:
    """What the order of the parts says of the order of the whole."""
    if n.op == "if":
        first, second = found
        return first if first is second else None
    out: bool | None = needs_all
    for f in found:
        if f is not None and f is not needs_all:
            return f
        out = None if f is None else out
    return out


def holds_at(truth: Truth, point: Mapping[str, Fraction]) -> bool:
    """Is a truth true at a point?"""
    return Narrowing(box({v: (q, q) for v, q in point.items()})).of(truth) is True


def value_at(number: Node, point: Mapping[str, Fraction]) -> Fraction:
    """The value of a number at a point."""
    found: Node = Narrowing(box({v: (q, q) for v, q in point.items()})).of(number)
    return found.low[0]
