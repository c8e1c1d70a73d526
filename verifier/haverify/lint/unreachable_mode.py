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
    """By edges that can fire at all, from modes where a run can start. Without a start the fault is there."""
    for automaton in spec.automata:
        if facts.has_start(automaton):
            reached = reached_modes(facts, automaton)
            for mode in automaton.modes:
                if mode.name not in reached:
                    yield _finding(facts, automaton, mode)


def _finding(facts: Facts, automaton: HybridAutomaton, mode: Mode) -> Diagnostic:
    entering = [e for e in automaton.edges if e.target == mode.name and e.source != mode.name]
    live = {id(e) for e in live_edges(facts, automaton)}
    if not entering:
        why = "no edge leads to it and no run starts there"
    elif all(id(e) not in live for e in entering):
        why = "no edge that leads to it can fire"
    else:
        why = "edges lead to it only from modes that are never entered"
    return Diagnostic(
        "HA301",
        f"mode {mode.name} is never entered: {why}",
        span=mode.span,
        key=f"{automaton.name}: mode {mode.name} is never entered",
    )
