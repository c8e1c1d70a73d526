"""Bindings of ports that depend on each other at one instant."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from haverify.elaborate.context import Context
from haverify.model.expression import Expr, nodes
from haverify.model.hybrid import HybridAutomaton, Range
from haverify.model.system import Part

Names = frozenset[str]


def port_loops(ctx: Context, parts: Sequence[Part], models: Mapping[str, Any]) -> bool:
    """Whether some binding reads itself through ports and outputs alone; such a circle is HA008."""
    reads = _reads(parts, models)
    state: dict[str, int] = {}
    for start in reads:
        path = _circle(reads, start, state)
        if path:
            span = next((b.span for p in parts for b in p.bindings if f"{p.name}.{b.name}" in path), None)
            ctx.report("HA008", f"{' reads '.join(path)} at the same instant", span)
            return True
    return False


def _reads(parts: Sequence[Part], models: Mapping[str, Any]) -> dict[str, Names]:
    """For each bound port and each output of a part: the ports and outputs it reads."""
    found: dict[str, Names] = {}
    for part in parts:
        for b in part.bindings:
            if isinstance(b.to, Range):
                continue
            found[f"{part.name}.{b.name}"] = _mentioned([b.to], "")
        model = models[part.name]
        if isinstance(model, HybridAutomaton):
            for name, exprs in _outputs(model).items():
                found[f"{part.name}.{name}"] = _mentioned(exprs, f"{part.name}.")
    return found


def _outputs(model: HybridAutomaton) -> dict[str, list[Expr]]:
    found: dict[str, list[Expr]] = {}
    for lets in (model.lets, *(m.lets for m in model.modes)):
        for let in lets:
            found.setdefault(let.name, []).append(let.expr)
    return found


def _mentioned(exprs: Sequence[Expr], prefix: str) -> Names:
    return frozenset(prefix + n.name for e in exprs for n in nodes(e) if n.op in ("input", "let"))


def _circle(reads: Mapping[str, Names], start: str, state: dict[str, int]) -> list[str]:
    """A circle reached from `start`, or nothing; `state` is 1 on the way, 2 when done."""
    path: list[str] = []
    stack: list[tuple[str, list[str]]] = [(start, sorted(reads.get(start, ())))] if state.get(start) is None else []
    state.setdefault(start, 1)
    path = [start] if stack else []
    while stack:
        name, rest = stack[-1]
        if not rest:
            state[name] = 2
            stack.pop()
            path.pop()
            continue
        nxt = rest.pop(0)
        if state.get(nxt) == 1:
            return [*path[path.index(nxt) :], nxt]
        if nxt in reads and state.get(nxt) is None:
            state[nxt] = 1
            stack.append((nxt, sorted(reads[nxt])))
            path.append(nxt)
    return []
