"""HA304: two urgent edges, or two edges on an event, that are enabled at the same state and lead apart."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

from haverify.diagnostics.diagnostic import Diagnostic, Label
from haverify.lint._facts import Facts
from haverify.lint._registry import rule
from haverify.lint._wording import edge_name, point_text
from haverify.model.expression import nodes
from haverify.model.hybrid import Edge, HybridAutomaton
from haverify.model.spec import Spec
from haverify.solvers.answer import Holds
from haverify.solvers.conditions import Condition
from haverify.solvers.literals import Case


@rule("HA304")
def overlapping_guards(spec: Spec, facts: Facts) -> Iterator[Diagnostic]:
    """Plain edges with room to wait are choices on purpose; so are edges under a priority or in a `sync`."""
    for automaton in spec.automata:
        ordered = {name for p in automaton.priorities for name in p.over}
        free = [e for e in automaton.edges if e.name not in facts.synced | ordered]
        for a, b in combinations(free, 2):
            if a.source == b.source and _compete(a, b):
                yield from _check(facts, automaton, a, b)


def _compete(a: Edge, b: Edge) -> bool:
    both_urgent = a.urgent and b.urgent
    on_events = has_equality(a) and has_equality(b)
    return (both_urgent or on_events) and (a.target, a.resets) != (b.target, b.resets)


def has_equality(edge: Edge) -> bool:
    """Whether the guard names an event: an equation of the state."""
    return any(n.op == "==" and any(m.op in ("var", "let") for m in nodes(n)) for n in nodes(edge.guard))


def _check(facts: Facts, automaton: HybridAutomaton, a: Edge, b: Edge) -> Iterator[Diagnostic]:
    mode = facts.modes(automaton)[a.source]
    frame = facts.frame(automaton, mode)
    place = f"{edge_name(a)} and {edge_name(b)}"
    conditions = [Condition(mode.domain, frame, closed=True), Condition(a.guard, frame), Condition(b.guard, frame)]
    for case in _landings(facts, automaton, a, b, conditions):
        answer = facts.decide("HA304", place, a.span, case[0], case[1])
        if isinstance(answer, Holds) and answer.is_exact:
            yield _finding(facts, automaton, a, b, answer)
            return


def _landings(
    facts: Facts, automaton: HybridAutomaton, a: Edge, b: Edge, conditions: list[Condition]
) -> Iterator[tuple[list[Condition], Case]]:
    """The conditions with an outcome of each edge inside its target's domain."""
    modes = facts.modes(automaton)
    frame = conditions[0].frame
    for o in facts.reset("HA304", a, frame):
        for q in facts.reset("HA304", b, frame):
            first = Condition(modes[a.target].domain, frame.after(modes[a.target], o.values), closed=True)
            second = Condition(modes[b.target].domain, frame.after(modes[b.target], q.values), closed=True)
            yield [*conditions, first, second], o.case + q.case


def _finding(facts: Facts, automaton: HybridAutomaton, a: Edge, b: Edge, answer: Holds) -> Diagnostic:
    witness = point_text(answer.point, facts.scope(automaton))
    where = f"at {witness}" if witness else "everywhere in the mode"
    return Diagnostic(
        "HA304",
        f"{edge_name(a)} and {edge_name(b)} are both enabled {where}",
        span=b.span,
        labels=(Label(a.span, "enabled there as well"),) if a.span else (),
        notes=("which of them fires is left open: claims must hold for both choices",),
        help=f"order them: `priority {a.name} over {b.name}`" if a.name and b.name and a.name != b.name else None,
        key=f"{automaton.name}: {edge_name(a)} and {edge_name(b)} overlap",
    )
