"""Truths about lines with rational coefficients, made whole."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from math import lcm

from hacheck.lines import Node, plus
from hacheck.rational import Beyond, spend

MAX_BITS = 20_000
TRUTHS = ("le", "and", "or")


def _inner(n: Node) -> list[Node]:
    """The nodes that a node is made of."""
    return [p for p in ([m for _, m in n.parts] if n.op == "sum" else n.parts) if isinstance(p, Node)]


class Whole:
    """Truths with all lines multiplied so that they are whole, and with names replaced by their places."""

    def __init__(self, truth: Node, place: Mapping[str, int]) -> None:
        self.place, self.factor = place, 1
        self._made: dict[Node, tuple[int, Node]] = {}
        stack, seen = [truth], {truth}
        while stack:
            n = stack.pop()
            if n.op == "line":
                self.factor = lcm(self.factor, n.parts[0].denominator, *[q.denominator for _, q in n.parts[1]])
            inner = [p for p in (_inner(n) if n.op != "line" else ()) if p not in seen]
            seen.update(inner)
            stack.extend(inner)
            spend(2 + len(n.parts) + self.factor.bit_length() // 64)
            if self.factor.bit_length() > MAX_BITS:
                raise Beyond("numbers with too large denominators")

    def made(self, n: Node) -> tuple[int, Node]:
        """(k, k times a number, all in it whole); of a truth the second counts."""
        if n not in self._made:
            spend(1 + len(n.parts))
            self._made[n] = self._line(n) if n.op == "line" else self._sum(n) if n.op == "sum" else self._joined(n)
        return self._made[n]

    def _line(self, n: Node) -> tuple[int, Node]:
        terms = tuple([(self.place[v], int(q * self.factor)) for v, q in n.parts[1]])
        return 1, Node("line", (int(n.parts[0] * self.factor), terms))

    def _sum(self, n: Node) -> tuple[int, Node]:
        made = [(q, *self.made(m)) for q, m in n.parts]
        k = lcm(*[Fraction(q, j).denominator for q, j, _ in made])
        return k, plus(*[(int(q * k / j), m) for q, j, m in made])

    def _joined(self, n: Node) -> tuple[int, Node]:
        made = [self.made(p) if isinstance(p, Node) else (1, p) for p in n.parts]
        k = 1 if n.op in ("and", "or") else lcm(*[j for j, _ in made])
        at_k = [m if j == k or isinstance(m, bool) or m.op in TRUTHS else plus((k // j, m)) for j, m in made]
        return k, Node(n.op, tuple(at_k))


def weight(n: Node, known: dict[Node, int]) -> int:
    """How many ends of axes a number, or those that a truth compares, adds up at most."""
    if n not in known:
        if n.op == "line":
            known[n] = sum([abs(q) for _, q in n.parts[1]])
        elif n.op == "sum":
            known[n] = sum([abs(q) * weight(m, known) for q, m in n.parts])
        else:
            found = [weight(p, known) for p in _inner(n)]
            known[n] = sum(found) if n.op == "le" else max(found)
    return known[n]
