"""HA302: a guard that is never true inside the domain of its mode."""

from __future__ import annotations

from collections.abc import Iterator

from haverify.diagnostics.diagnostic import Diagnostic, Label
from haverify.lint._facts import Facts
from haverify.lint._formulas import written_in
from haverify.lint._registry import rule
from haverify.lint._wording import edge_name
from haverify.model.expression import Expr, rebuild
from haverify.model.hybrid import Edge, HybridAutomaton
from haverify.model.spec import Spec
from haverify.solvers.answer import Contradiction
from haverify.text.record import replace


@rule("HA302")
def dead_guard(spec: Spec, facts: Facts) -> Iterator[Diagnostic]:
    """Guards that contradict themselves, or stand under an empty domain, are HA201 or HA202.

    An urgent edge whose strict bound is met at the border of the domain is due there (LANGUAGE S8).
    """
    for automaton in spec.automata:
        for edge in automaton.edges:
            state = facts.edge(automaton, edge)
            if state.kind != "never enabled" or (edge.urgent and _is_due_at_a_border(facts, automaton, edge)):
                continue
            if isinstance(state.answer, Contradiction):
                yield _finding(facts, automaton, edge, state.answer.core)


def _is_due_at_a_border(facts: Facts, automaton: HybridAutomaton, edge: Edge) -> bool:
    return facts.edge_state(automaton, replace(edge, guard=_with_borders(edge.guard))).kind == "live"


def _with_borders(e: Expr) -> Expr:
    """The condition with strict comparisons closed, those under `not` excepted."""
    if e.op in ("<", ">"):
        return Expr(e.op + "=", e.args, e.unit, e.span)
    return rebuild(e, _with_borders) if e.op in ("and", "or") else e


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
        labels=tuple(
            Label(e.span, "" if k else f"the domain of mode {mode.name}") for k, e in enumerate(others) if e.span
        ),
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
    if facts.edge_state(automaton, replace(edge, guard=guard)).kind != "live":
        return None
    return text.replace(atom.op, atom.op + "=")


def _replaced(e: Expr, old: Expr, new: Expr) -> Expr:
    return new if e == old else rebuild(e, lambda child: _replaced(child, old, new))
