"""What is left of numbers and truths on a region, in whole numbers."""

from __future__ import annotations

from collections.abc import Iterable
from operator import attrgetter
from typing import Any

from haverify.analyses.regions import NUMBERS, Node, Truth, both, choice, combine, denied, either, extreme, join
from haverify.analyses.regions_whole import Ends, Region, difference, line

_FEW = 9  # members of a minimum that are compared with each other
_MANY = 12  # pairs of parts of two numbers that are compared


class Narrowing:
    """What is left of numbers and truths on a region; only what reads one of the `changed` names is looked at."""

    def __init__(self, region: Region, changed: int | None = None) -> None:
        self.region, self.changed = region, -1 if changed is None else changed
        self.looks_at_all = changed is None
        self.done: dict[Node, Any] = {}
        self._shared: dict[tuple[Node, bool, bool, int], Truth] = {}

    def of(self, n: Any) -> Any:
        """The node on this region, a truth value where a truth is decided."""
        if isinstance(n, bool) or not (self.looks_at_all or n.names & self.changed):
            return n
        found = self.done.get(n)
        if found is None:
            found = self.done[n] = self._number(n) if n.op in NUMBERS else self._truth(n)
        return found

    def _number(self, n: Node) -> Node:
        if n.op == "lin":
            return Node("lin", n.parts, n.names, *self.region.enclose(*n.parts))
        if n.op == "sum":
            return self._bounded(combine([(q, self.of(m)) for q, m in n.parts[1]], n.parts[0], line))
        if n.op == "if":
            made = choice(*map(self.of, n.parts))
            return self._bounded(made) if made.op == "if" else made
        return self._extreme(n.op, extreme(n.op, map(self.of, n.parts)))

    def _bounded(self, n: Node) -> Node:
        """The node with its ends; those of the parts are known."""
        if n.op == "lin":
            n.low, n.high = self.region.enclose(*n.parts)
        elif n.op == "sum":
            n.low, n.high = self._sum(*n.parts)
        elif n.op == "if":
            n.low, n.high = min(n.parts[1].low, n.parts[2].low), max(n.parts[1].high, n.parts[2].high)
        return n

    def _sum(self, constant: int, parts: Iterable[tuple[int, Node]]) -> Ends:
        low = high = constant * self.region.unit
        for q, m in parts:
            a, b = self.region.enclose(*m.parts) if m.op == "lin" else (m.low, m.high)
            low, high = (low + q * a, high + q * b) if q > 0 else (low + q * b, high + q * a)
        return low, high

    def _extreme(self, op: str, n: Node) -> Node:
        """Without the members that are never the least (greatest) alone."""
        if n.op != op:
            return n
        if op == "min":
            best = min(n.parts, key=_HIGH_LOW)
            kept = [m for m in n.parts if m is best or m.low < best.high]
        else:
            best = max(n.parts, key=_LOW_HIGH)
            kept = [m for m in n.parts if m is best or m.high > best.low]
        if 1 < len(kept) < _FEW and (self.region.across or _have_equal_names(kept)):
            kept = self._undominated(op, kept)
        if len(kept) == 1:
            only: Node = kept[0]
            return only
        made = n if len(kept) == len(n.parts) else extreme(op, kept)
        pick = min if op == "min" else max
        made.low, made.high = pick([m.low for m in kept]), pick([m.high for m in kept])
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
        key = n, n is a, strict, bound.low
        if key not in self._shared:
            parts = [self._compared(m, b, strict) if n is a else self._compared(a, m, strict) for m in _alternatives(n)]
            self._shared[key] = (
                _chosen(n, parts) if n.op == "if" else join("and" if (n.op == "max") is (n is a) else "or", parts)
            )
        return self._shared[key]

    def order(self, a: Node, b: Node, strict: bool) -> bool | None:
        """Is `a <= b` (`a < b`) on the whole region (True), nowhere (False), or not known?"""
        if a is b:
            return not strict
        if a.high <= b.low - strict:
            return True
        if a.low > b.high - strict:
            return False
        if _is_among(b, a) if strict else _is_among(a, b):
            return not strict
        if a.size * b.size > _MANY:
            return None
        if a.op in ("max", "if") or (a.op == "min" and b.op != "min"):
            return _by_parts(a, (self.order(m, b, strict) for m in _alternatives(a)), a.op == "max")
        if b.op in ("min", "max", "if"):
            return _by_parts(b, (self.order(a, m, strict) for m in _alternatives(b)), b.op == "min")
        n = difference(a, b)
        low, high = self.region.enclose(*n.parts) if n.op == "lin" else self._sum(*n.parts)
        if high <= -strict:
            return True
        return False if low > -strict else None


_HIGH_LOW, _LOW_HIGH = attrgetter("high", "low"), attrgetter("low", "high")


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
        return set(b.parts if b.op == "min" else (b,)) <= set(a.parts)
    return b.op == "max" and set(a.parts if a.op == "max" else (a,)) <= set(b.parts)


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
