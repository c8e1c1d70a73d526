"""Which modes runs can enter, and by which edges: an over-approximation by the mode graph."""

from __future__ import annotations

from haverify.lint._facts import Facts, allowed
from haverify.model.hybrid import Edge, HybridAutomaton
from haverify.solvers.answer import Contradiction


def live_edges(facts: Facts, automaton: HybridAutomaton) -> list[Edge]:
    """The edges that fire from some state of their source's domain, as far as is known."""
    return [e for e in automaton.edges if facts.edge(automaton, e).kind == "live"]


def reached_modes(facts: Facts, automaton: HybridAutomaton) -> frozenset[str]:
    """The modes that runs may enter."""
    return facts.remembered(("reached", automaton.name), lambda: _reached(facts, automaton))


def _reached(facts: Facts, automaton: HybridAutomaton) -> frozenset[str]:
    reached = {
        mode.name
        for init in automaton.init
        for mode in allowed(automaton, init)
        if not isinstance(facts.start(automaton, mode, init), Contradiction)
    }
    edges = live_edges(facts, automaton)
    todo = sorted(reached)
    while todo:
        here = todo.pop()
        for e in edges:
            if e.source == here and e.target not in reached:
                reached.add(e.target)
                todo.append(e.target)
    return frozenset(reached)
