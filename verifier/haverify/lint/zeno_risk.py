"""HA401: a cycle whose resets lead towards a state where it takes no time."""

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


@rule("HA401")
def zeno_risk(spec: Spec, facts: Facts) -> Iterator[Diagnostic]:
    """Some state passes the cycle at one instant and is unchanged by it; runs may come ever closer to it.

    Where a reset is on the way guards are read as closed. What certainly happens is HA402.
    """
    for automaton in spec.automata:
        for cycle in cycles(facts, automaton):
            still = is_identity(cycle)
            answer = returns(facts, "HA401", automaton, cycle, closed=not still)
            if not isinstance(answer, Holds) or not answer.is_exact:
                continue
            if not still or not is_reached(facts, automaton, cycle, answer):
                yield _finding(facts, automaton, cycle, answer)


def _finding(facts: Facts, automaton: HybridAutomaton, cycle: Cycle, answer: Holds) -> Diagnostic:
    point = point_text(answer.point, facts.scope(automaton), facts.scope(automaton).vars)
    names = ", ".join(e.name or edge_name(e) for e in cycle)
    limit = f" as the state tends to {point}" if point else ""
    resets = [a.span for e in cycle for a in e.resets if a.span]
    return Diagnostic(
        "HA401",
        f"Zeno risk: the time between jumps of {names} may tend to 0{limit}",
        span=cycle[0].span,
        labels=tuple(Label(s, "this reset may lead there") for s in resets),
        notes=("infinitely many jumps in bounded time end a run; nothing after that is covered by a proof",),
        help="bound the jumps (`within T, K jumps`), or add a rest mode that is entered near that state",
        key=f"{automaton.name}: Zeno risk of {names}",
    )
