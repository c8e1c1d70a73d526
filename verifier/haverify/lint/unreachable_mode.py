"""HA301: a mode that no run enters."""

from __future__ import annotations

from collections.abc import Iterator

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.lint._facts import Facts
from haverify.lint._reach import live_edges, reached_modes
from haverify.lint._registry import rule
from haverify.model.hybrid import HybridAutomaton, Mode
from haverify.model.spec import Spec


@rule("HA301")
def unreachable_mode(spec: Spec, facts: Facts) -> Iterator[Diagnostic]:
    """By edges that can fire, from modes where a run can start.

    Where no run starts, or no edge that leads to the mode can fire, the fault lies there and is reported there.
    """
    for automaton in spec.automata:
        if facts.has_start(automaton):
            reached = reached_modes(facts, automaton)
            live = {id(e) for e in live_edges(facts, automaton)}
            for mode in automaton.modes:
                entering = [e for e in automaton.edges if e.target == mode.name and e.source != mode.name]
                has_way = not entering or any(id(e) in live for e in entering)
                if mode.name not in reached and has_way:
                    yield _finding(automaton, mode, bool(entering))


def _finding(automaton: HybridAutomaton, mode: Mode, is_entered: bool) -> Diagnostic:
    only = "edges lead to it only from modes that are never entered"
    none = "no edge leads to it and no run starts there"
    return Diagnostic(
        "HA301",
        f"mode {mode.name} is never entered: " + (only if is_entered else none),
        span=mode.span,
        key=f"{automaton.name}: mode {mode.name} is never entered",
    )
