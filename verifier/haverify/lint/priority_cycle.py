"""HA312: priorities that place an edge above itself."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise

from haverify.diagnostics.diagnostic import Diagnostic, Label
from haverify.lint._facts import Facts
from haverify.lint._registry import rule
from haverify.model.hybrid import HybridAutomaton, Priority
from haverify.model.spec import Spec
from haverify.model.system import System


@rule("HA312")
def priority_cycle(spec: Spec, _facts: Facts) -> Iterator[Diagnostic]:
    """Conditions `when` are left aside: an order must be one for every state."""
    owners: tuple[HybridAutomaton | System, ...] = (*spec.automata, *spec.systems)
    for owner in owners:
        cycle = _cycle(owner.priorities)
        if cycle:
            spans = [p.span for p in owner.priorities if p.span and set(p.over) & set(cycle)]
            yield Diagnostic(
                "HA312",
                f"priorities of {owner.name} form a cycle: " + ", ".join(f"{a} over {b}" for a, b in _pairs(cycle)),
                span=spans[-1] if spans else owner.span,
                labels=tuple(Label(s) for s in spans[:-1]),
                key=f"priorities of {owner.name} form a cycle",
            )


def _pairs(cycle: Sequence[str]) -> list[tuple[str, str]]:
    return list(zip(cycle, (*cycle[1:], cycle[0]), strict=True))


def _cycle(priorities: Sequence[Priority]) -> tuple[str, ...]:
    """The names of some cycle, each above the next; empty when there is none."""
    below: dict[str, set[str]] = {}
    for p in priorities:
        for higher, lower in pairwise(p.over):
            below.setdefault(higher, set()).add(lower)
    for start in sorted(below):
        path = _path(below, start, start, {start})
        if path:
            return path
    return ()


def _path(below: Mapping[str, set[str]], at: str, goal: str, seen: set[str]) -> tuple[str, ...]:
    for name in sorted(below.get(at, ())):
        if name == goal:
            return (at,)
        if name not in seen:
            seen.add(name)
            rest = _path(below, name, goal, seen)
            if rest:
                return (at, *rest)
    return ()
