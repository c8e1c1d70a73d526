"""HA306: an edge whose outcome never lies in the domain of its target, so it can never be taken."""

from __future__ import annotations

from collections.abc import Iterator

from haverify.diagnostics.diagnostic import Diagnostic, Label
from haverify.lint._facts import Facts
from haverify.lint._formulas import written_in
from haverify.lint._registry import rule
from haverify.lint._wording import edge_name, mentioned, point_text
from haverify.lint.slot_gap import meetings
from haverify.model.expression import Expr
from haverify.model.hybrid import Edge, HybridAutomaton
from haverify.model.spec import Spec
from haverify.solvers.answer import Contradiction, Holds


@rule("HA306")
def reset_outside(spec: Spec, facts: Facts) -> Iterator[Diagnostic]:
    """Only where the guard itself can hold and the target's domain is not empty; a gap between slots is HA204.

    A domain that excludes nothing is not in the way: the range of a reset is empty, which is HA201.
    """
    for automaton in spec.automata:
        gaps = [m.edge for m in meetings(facts, automaton) if m.begins > m.ends]
        for edge in automaton.edges:
            state = facts.edge(automaton, edge)
            if facts.modes(automaton)[edge.target].domain.op == "true":
                continue
            if state.kind == "lands outside" and isinstance(state.answer, Contradiction) and edge not in gaps:
                leaving = state.leaving if isinstance(state.leaving, Holds) else None
                yield _finding(facts, automaton, edge, state.answer.core, leaving)


def _finding(
    facts: Facts, automaton: HybridAutomaton, edge: Edge, core: tuple[Expr, ...], leaving: Holds | None
) -> Diagnostic:
    target = facts.modes(automaton)[edge.target]
    needs = written_in(core, target.domain) or [target.domain]
    names = [n for e in needs for n in mentioned(e) if n in facts.scope(automaton).vars]
    shown = point_text(leaving.point, facts.scope(automaton), names) if leaving else ""
    reset = {a.var for a in edge.resets}
    kept = [n for n in dict.fromkeys(names) if n not in reset]
    needed = " and ".join(f"`{facts.text(e.span)}`" for e in needs)
    what = f"keeps {', '.join(kept)}" if kept else "sets " + ", ".join(dict.fromkeys(names))
    return Diagnostic(
        "HA306",
        f"{edge_name(edge)} {what}, but mode {edge.target} needs {needed}",
        span=edge.span,
        labels=tuple(Label(e.span, f"the domain of mode {edge.target}") for e in needs if e.span),
        notes=(f"at {shown}, for example, no outcome lies in the domain: the edge never fires",) if shown else (),
        help=f"reset it on the edge: `do {kept[0]} := ...`" if kept else None,
        key=f"{automaton.name}: {edge_name(edge)} lands outside the domain",
    )
