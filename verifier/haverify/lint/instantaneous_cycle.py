"""HA402: edges that can fire in turn for ever with no time passing."""

from __future__ import annotations

from collections.abc import Iterator

from haverify.diagnostics.diagnostic import Diagnostic, Label
from haverify.lint._cycles import Cycle, cycles, is_identity, is_reached, returns
from haverify.lint._facts import Facts
from haverify.lint._registry import rule
from haverify.lint._wording import edge_name, point_text
from haverify.model.hybrid import HybridAutomaton
from haverify.model.spec import Spec
from haverify.solvers.answer import Holds


@rule("HA402")
def instantaneous_cycle(spec: Spec, facts: Facts) -> Iterator[Diagnostic]:
    """At a start of the automaton every guard of the cycle holds in turn and the resets lead back to it.

    At a state of which nobody knows whether runs reach it this is a risk: HA401.
    """
    for automaton in spec.automata:
        for cycle in cycles(facts, automaton):
            answer = returns(facts, "HA402", automaton, cycle)
            if isinstance(answer, Holds) and is_reached(facts, automaton, cycle, answer):
                yield _finding(facts, automaton, cycle, answer)


def _finding(facts: Facts, automaton: HybridAutomaton, cycle: Cycle, answer: Holds) -> Diagnostic:
    point = point_text(answer.point, facts.scope(automaton), facts.scope(automaton).vars)
    names = " and ".join(e.name or edge_name(e) for e in cycle)
    who = f"edges {names} can fire in turn" if len(cycle) > 1 else f"{edge_name(cycle[0])} can fire again and again"
    kept = "keep" if is_identity(cycle) else "lead back to"
    return Diagnostic(
        "HA402",
        f"{who} with no time passing",
        span=cycle[0].span,
        labels=tuple(Label(e.span) for e in cycle[1:] if e.span),
        notes=(f"at {point or 'any state'} every guard holds and the resets {kept} the point",),
        help="make one guard strict, or add a rest mode that is entered there",
        key=f"{automaton.name}: {who} with no time passing",
    )
