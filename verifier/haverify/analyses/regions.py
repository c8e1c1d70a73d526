"""Piecewise linear numbers and truths over named reals, and their values at points.

The same nodes serve a search (`regions_whole`): there numbers are whole, a name is a bit and names are a sum of bits.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from typing import Any

Terms = tuple[tuple[Any, Any], ...]
"""A linear number without its constant: (name, coefficient), sorted by name, no coefficient is 0."""

NUMBERS = frozenset({"lin", "sum", "min", "max", "if"})


class Node:
    """A number (`lin`, `sum`, `min`, `max`, `if`), in a search with its ends, or a truth (`le`, `and`, `or`).

    `lin`: (constant, terms); `sum`: (constant, ((factor, node), ...)); `if`: (truth, node, node);
    `le`: (node, node, is it strict).
    """

    __slots__ = ("high", "low", "names", "op", "parts", "size")

    def __init__(self, op: str, parts: Any, names: Any, low: int = 0, high: int = 0) -> None:
        self.op, self.parts, self.names, self.low, self.high = op, parts, names, low, high
        self.size: int = sum([n.size for n in parts]) if op in ("min", "max") else 1  # in how many parts it is compared


Truth = Node | bool


def linear(constant: Any, terms: Mapping[Any, Any] | None = None) -> Node:
    """The number `constant + sum of terms`."""
    kept = tuple(sorted([(v, q) for v, q in (terms or {}).items() if q]))
    return Node("lin", (constant, kept), frozenset([v for v, _ in kept]))


def named(name: str) -> Node:
    """The number that a name stands for."""
    return linear(Fraction(0), {name: Fraction(1)})


def combine(
    parts: Iterable[tuple[Any, Node]], constant: Any = Fraction(0), line: Callable[[Any, Any], Node] = linear
) -> Node:
    """A sum of multiples; linear where all summands are, and equal summands are put together."""
    terms: dict[Any, Any] = {}
    rest: dict[Node, Any] = {}
    stack = list(parts)
    while stack:
        q, n = stack.pop()
        if n.op in ("lin", "sum"):
            constant += q * n.parts[0]
        if n.op == "lin":
            for v, k in n.parts[1]:
                terms[v] = terms[v] + q * k if v in terms else q * k
        elif n.op == "sum":
            stack.extend([(q * k, m) for k, m in n.parts[1]])
        else:
            rest[n] = rest.get(n, 0) + q
    return _sum(line(constant, terms), [(q, n) for n, q in rest.items() if q])


def _sum(line: Node, rest: list[tuple[Any, Node]]) -> Node:
    if not rest:
        return line
    parts = (*(((1, line),) if line.names else ()), *rest)
    return Node("sum", (0 if line.names else line.parts[0], parts), _names([n for _, n in parts]))


def minus(a: Node, b: Node, line: Callable[[Any, Any], Node] = linear) -> Node:
    """The difference."""
    if a.op == b.op == "lin" and not (a.names and b.names):
        terms = a.parts[1] or tuple([(v, -q) for v, q in b.parts[1]])
        return Node("lin", (a.parts[0] - b.parts[0], terms), a.names or b.names)
    return combine([(1, a), (-1, b)], 0, line)


def extreme(op: str, parts: Iterable[Node]) -> Node:
    """`min` or `max` of numbers, at least one."""
    kept = tuple({m: None for n in parts for m in (n.parts if n.op == op else (n,))})
    return Node(op, kept, _names(kept)) if len(kept) > 1 else kept[0]


def choice(condition: Truth, a: Node, b: Node) -> Node:
    """`a` where the condition is true, else `b`."""
    if isinstance(condition, bool) or a is b:
        return b if condition is False else a
    return Node("if", (condition, a, b), condition.names | a.names | b.names)


def at_most(a: Node, b: Node, strict: bool = False) -> Truth:
    """`a <= b`, or `a < b`."""
    if not a.names and not b.names and a.op == b.op == "lin":
        small, large = a.parts[0], b.parts[0]
        return bool(small < large if strict else small <= large)
    return Node("le", (a, b, strict), a.names | b.names)


def both(parts: Iterable[Truth]) -> Truth:
    """The conjunction."""
    return join("and", parts)


def either(parts: Iterable[Truth]) -> Truth:
    """The disjunction."""
    return join("or", parts)


def join(op: str, parts: Iterable[Truth]) -> Truth:
    """`and` or `or` of truths."""
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


def _names(nodes: Sequence[Node]) -> Any:
    names = nodes[0].names
    for n in nodes:
        names |= n.names
    return names


def denied(t: Truth) -> Truth:
    """The negation."""
    if isinstance(t, bool):
        return not t
    if t.op == "le":
        return at_most(t.parts[1], t.parts[0], not t.parts[2])
    return join("or" if t.op == "and" else "and", map(denied, t.parts))


# ---- at a point -----------------------------------------------------------------


class Place:
    """Values of numbers and truths at a point."""

    def __init__(self, point: Mapping[str, Fraction]) -> None:
        self.point = point
        self._known: dict[Node, Fraction] = {}

    def holds(self, t: Truth) -> bool:
        """Is a truth true here?"""
        if isinstance(t, bool):
            return t
        if t.op == "le":
            a, b = self.value(t.parts[0]), self.value(t.parts[1])
            return a < b if t.parts[2] else a <= b
        return all(map(self.holds, t.parts)) if t.op == "and" else any(map(self.holds, t.parts))

    def value(self, n: Node) -> Fraction:
        """The value of a number here."""
        found = self._known.get(n)
        if found is None:
            found = self._known[n] = self._value(n.op, n.parts)
        return found

    def _value(self, op: str, parts: Any) -> Fraction:
        if op in ("lin", "sum"):
            total: Fraction = parts[0]
            for a, b in parts[1]:
                total += b * self.point[a] if op == "lin" else a * self.value(b)
            return total
        if op == "if":
            return self.value(parts[1] if self.holds(parts[0]) else parts[2])
        return (min if op == "min" else max)(map(self.value, parts))


def holds_at(truth: Truth, point: Mapping[str, Fraction]) -> bool:
    """Is a truth true at a point?"""
    return Place(point).holds(truth)


def value_at(number: Node, point: Mapping[str, Fraction]) -> Fraction:
    """The value of a number at a point."""
    return Place(point).value(number)
