"""Which modes runs can enter, and by which edges: an over-approximation by the mode graph."""

from __future__ import annotations

from haverify.lint._facts import Facts, allowed
from haverify.model.hybrid import Edge, HybridAutomaton
from haverify.solvers.answer import Contradiction
from haverify.solvers.conditions import Condition, decide
from haverify.solvers.literals import TooManyCasesError


def live_edges(facts: Facts, automaton: HybridAutomaton) -> list[Edge]:
    """The edges that fire from some state of their source's domain, as far as is known."""
    return facts.remembered(
        ("live", automaton.name), lambda: [e for e in automaton.edges if _is_live(facts, automaton, e)]
    )


def _is_live(facts: Facts, automaton: HybridAutomaton, edge: Edge) -> bool:
    modes = facts.modes(automaton)
    frame = facts.frame(automaton, modes[edge.source])
    before = [Condition(modes[edge.source].domain, frame, closed=True), Condition(edge.guard, frame)]
    try:
        outcomes = facts.outcomes(frame, edge.resets)
    except TooManyCasesError:
        return True
    target = modes[edge.target]
    landings = (Condition(target.domain, frame.after(target, o.values), closed=True) for o in outcomes)
    return any(
        not isinstance(decide([*before, landing], o.case), Contradiction)
        for landing, o in zip(landings, outcomes, strict=True)
    )


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
