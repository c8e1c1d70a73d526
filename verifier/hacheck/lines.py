"""Piecewise linear numbers over named reals, and truths about them: built of lines by sums, max, min and choice."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from fractions import Fraction
from typing import Any

from hacheck.rational import spend

Terms = tuple[tuple[Any, Any], ...]  # (name, coefficient), sorted by name, no coefficient is 0


class Node:
    """A number or a truth.

    `line`: (constant, terms); `sum`: ((factor, number), ...), at most one of them a line; `max`, `min`: numbers;
    `if`: (truth, number, number); `and`, `or`: truths; `le`: (number, number, is it strict).
    """

    __slots__ = ("op", "parts")

    def __init__(self, op: str, parts: Any) -> None:
        self.op, self.parts = op, parts


Truth = Node | bool


def line(constant: Any, terms: Mapping[Any, Any] | None = None) -> Node:
    """The number `constant + sum of terms`."""
    return Node("line", (constant, tuple(sorted([(v, q) for v, q in (terms or {}).items() if q]))))


def constant(n: Node) -> Fraction | None:
    """The value of a number that reads no name, if it has that form."""
    return n.parts[0] if n.op == "line" and not n.parts[1] else None


def plus(*parts: tuple[Any, Node]) -> Node:
    """The sum of multiples: one line and what is no line, each of that once."""
    left: Any = 0
    terms: dict[Any, Any] = {}
    rest: dict[Node, Any] = {}
    for factor, part in parts:
        for f, n in part.parts if part.op == "sum" else ((1, part),):
            k = factor * f
            if n.op != "line":
                rest[n] = rest[n] + k if n in rest else k
                continue
            left += k * n.parts[0]
            for v, q in n.parts[1]:
                terms[v] = terms[v] + k * q if v in terms else k * q
    spend(2 + len(terms) + len(rest))
    made = line(left, terms)
    kept = [(k, n) for n, k in rest.items() if k]
    if not kept:
        return made
    if left or made.parts[1]:
        kept.append((1, made))
    return kept[0][1] if len(kept) == 1 and kept[0][0] == 1 else Node("sum", tuple(kept))


def difference(a: Node, b: Node) -> Node:
    """`a - b`."""
    return plus((1, a), (-1, b))


def pick(op: str, numbers: Iterable[Node]) -> Node:
    """`min` or `max` of numbers, at least one."""
    kept = {m: None for n in numbers for m in (n.parts if n.op == op else (n,))}
    spend(len(kept))
    return Node(op, tuple(kept)) if len(kept) > 1 else next(iter(kept))


def choice(condition: Truth, a: Node, b: Node) -> Node:
    """`a` where the condition is true, else `b`."""
    if isinstance(condition, bool) or a is b:
        return b if condition is False else a
    return Node("if", (condition, a, b))


def at_most(a: Node, b: Node, strict: bool = False) -> Truth:
    """`a <= b`, or `a < b`."""
    p, q = constant(a), constant(b)
    return Node("le", (a, b, strict)) if p is None or q is None else p < q or (p == q and not strict)


def join(op: str, truths: Iterable[Truth]) -> Truth:
    """`and` or `or` of truths."""
    kept: dict[Node, None] = {}
    for t in truths:
        if isinstance(t, bool):
            if t is (op == "or"):
                return t
        else:
            kept.update(dict.fromkeys(t.parts if t.op == op else (t,)))
    spend(len(kept))
    return Node(op, tuple(kept)) if len(kept) > 1 else next(iter(kept)) if kept else op == "and"


def denied(t: Truth) -> Truth:
    """The negation."""
    if isinstance(t, bool):
        return not t
    spend(1)
    if t.op == "le":
        return at_most(t.parts[1], t.parts[0], not t.parts[2])
    return join("or" if t.op == "and" else "and", map(denied, t.parts))
