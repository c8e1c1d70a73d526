"""HA313: an edge that a priority never lets fire."""

from __future__ import annotations

from collections.abc import Iterator

from haverify.diagnostics.diagnostic import Diagnostic, Label
from haverify.lint._facts import Facts
from haverify.lint._registry import rule
from haverify.lint._wording import edge_name
from haverify.model.hybrid import Edge, HybridAutomaton, Priority
from haverify.model.spec import Spec
from haverify.solvers.answer import Contradiction
from haverify.solvers.conditions import Condition


@rule("HA313")
def silenced_edge(spec: Spec, facts: Facts) -> Iterator[Diagnostic]:
    """Wherever the lower edge is enabled, the higher one is too and the priority applies. Inside automata only."""
    for automaton in spec.automata:
        for priority in automaton.priorities:
            for higher, lower in zip(priority.over, priority.over[1:], strict=False):
                pairs = [
                    (a, b) for a in automaton.edges for b in automaton.edges if (a.name, b.name) == (higher, lower)
                ]
                for a, b in pairs:
                    if a.source == b.source and _is_silenced(facts, automaton, priority, a, b):
                        yield _finding(automaton, priority, a, b)


def _is_silenced(facts: Facts, automaton: HybridAutomaton, priority: Priority, above: Edge, edge: Edge) -> bool:
    if facts.edge(automaton, edge).kind != "live":
        return False
    modes = facts.modes(automaton)
    frame = facts.frame(automaton, modes[edge.source])
    enabled = [Condition(modes[edge.source].domain, frame, closed=True), Condition(edge.guard, frame)]
    failures = [Condition(above.guard, frame, holds=False), Condition(priority.when, frame, holds=False)]
    outcomes = facts.reset("HA313", above, frame)
    if len(outcomes) != 1 or outcomes[0].case:
        return False
    after = frame.after(modes[above.target], outcomes[0].values)
    failures.append(Condition(modes[above.target].domain, after, holds=False, closed=True))
    place = f"{edge_name(edge)} below {above.name}"
    answers = [facts.decide("HA313", place, priority.span, [*enabled, failure]) for failure in failures]
    return all(isinstance(a, Contradiction) for a in answers)


def _finding(automaton: HybridAutomaton, priority: Priority, above: Edge, edge: Edge) -> Diagnostic:
    return Diagnostic(
        "HA313",
        f"{above.name} is enabled whenever {edge.name} is, so {edge_name(edge)} below it can never fire",
        span=priority.span,
        labels=(Label(edge.span, "never fires"),) if edge.span else (),
        key=f"{automaton.name}: {edge_name(edge)} is silenced by {above.name}",
    )
