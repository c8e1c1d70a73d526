"""HA302: a guard that is never true inside the domain of its mode."""

from __future__ import annotations

from collections.abc import Iterator

from haverify.diagnostics.diagnostic import Diagnostic, Label
from haverify.lint._facts import Facts
from haverify.lint._formulas import Formula, written_in
from haverify.lint._registry import rule
from haverify.lint._wording import edge_name
from haverify.lint.empty_interval import empty_bounds
from haverify.model.expression import Expr, rebuild
from haverify.model.hybrid import Edge, HybridAutomaton
from haverify.model.spec import Spec
from haverify.solvers.answer import Contradiction, Holds
from haverify.solvers.conditions import Condition, decide


@rule("HA302")
def dead_guard(spec: Spec, facts: Facts) -> Iterator[Diagnostic]:
    """Guards that contradict themselves, or stand under an empty domain, are HA201 or HA202."""
    for automaton in spec.automata:
        for edge in automaton.edges:
            if not is_empty_by_itself(facts, automaton, edge):
                answer = facts.jump("HA302", automaton, edge, lands=False)
                if isinstance(answer, Contradiction):
                    yield _finding(facts, automaton, edge, answer.core)


def is_empty_by_itself(facts: Facts, automaton: HybridAutomaton, edge: Edge) -> bool:
    """Whether the guard or the domain it stands under is empty already."""
    mode = facts.modes(automaton)[edge.source]
    frame = facts.frame(automaton, mode)
    for expr, kind in ((edge.guard, "guard"), (mode.domain, "domain")):
        if any(True for _ in empty_bounds(Formula(expr, frame, kind, ""))):
            return True
        if expr.op != "true" and isinstance(decide([Condition(expr, frame, closed=kind == "domain")]), Contradiction):
            return True
    return False


def _finding(facts: Facts, automaton: HybridAutomaton, edge: Edge, core: tuple[Expr, ...]) -> Diagnostic:
    mode = facts.modes(automaton)[edge.source]
    own = written_in(core, edge.guard)
    others = [e for e in core if e not in own]
    guard = " and ".join(f"`{facts.text(e.span)}`" for e in own)
    domain = " and ".join(f"`{facts.text(e.span)}`" for e in others)
    relaxed = next((r for e in own if (r := _relaxed(facts, automaton, edge, e))), None)
    return Diagnostic(
        "HA302",
        f"{edge_name(edge)} is never enabled: {guard} cannot hold in mode {mode.name}",
        span=(own[0].span if own else None) or edge.guard.span or edge.span,
        label="never true in this mode",
        labels=tuple(Label(e.span, f"the domain of mode {mode.name}") for e in others if e.span),
        notes=(f"the domain of mode {mode.name} needs {domain}",) if domain else (),
        help=f"include the bound: `when {relaxed}`" if relaxed else None,
        key=f"{automaton.name}: {edge_name(edge)} is never enabled",
    )


def _relaxed(facts: Facts, automaton: HybridAutomaton, edge: Edge, atom: Expr) -> str | None:
    """The text of a strict comparison with its bound included, if that lets the edge fire."""
    text = facts.text(atom.span)
    if atom.op not in ("<", ">") or text.count(atom.op) != 1:
        return None
    closed = Expr(atom.op + "=", atom.args, atom.unit, atom.span)
    guard = _replaced(edge.guard, atom, closed)
    if not isinstance(facts.jump("HA302", automaton, edge, guard=guard), Holds):
        return None
    return text.replace(atom.op, atom.op + "=")


def _replaced(e: Expr, old: Expr, new: Expr) -> Expr:
    return new if e == old else rebuild(e, lambda child: _replaced(child, old, new))
