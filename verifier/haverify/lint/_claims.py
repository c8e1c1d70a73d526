"""The conjuncts of claims, and the situations in which they are evaluated."""

from __future__ import annotations

from collections.abc import Iterator

from haverify.lint._facts import Facts
from haverify.model.claim import Claim, Goal
from haverify.model.expression import Expr, nodes
from haverify.model.hybrid import Edge, HybridAutomaton, Mode
from haverify.solvers.frame import Frame


def always_goals(claim: Claim) -> Iterator[Goal]:
    """The goals that speak of every instant."""
    return (g for g in claim.goals if g.kind == "always")


def conjuncts(e: Expr) -> Iterator[Expr]:
    """The conjuncts of a condition, those behind a premise with it."""
    if e.op == "and":
        for c in e.children:
            yield from conjuncts(c)
    elif e.op == "implies":
        premise, conclusion = e.children
        for c in conjuncts(conclusion):
            yield e if c is conclusion else Expr("implies", (premise, c), span=c.span)
    else:
        yield e


def modes_of(automaton: HybridAutomaton, premise: Expr) -> frozenset[str] | None:
    """The modes while dwelling in which a premise is true; None where it speaks of more than modes."""
    if premise.op == "at":
        return frozenset({premise.name})
    if premise.op not in ("and", "or", "not"):
        return None
    parts = [modes_of(automaton, c) for c in premise.children]
    known = [p for p in parts if p is not None]
    if len(known) < len(parts):
        return None
    if premise.op == "not":
        return frozenset(m.name for m in automaton.modes) - known[0]
    return frozenset.intersection(*known) if premise.op == "and" else frozenset.union(*known)


def situations(facts: Facts, automaton: HybridAutomaton, e: Expr) -> Iterator[tuple[Frame, Mode, Edge | None]]:
    """Every mode while dwelling in it, then after each edge into it; those that `e` names come first."""
    named = {n.name for n in nodes(e) if n.op in ("at", "jump")}
    has_jump = any(n.op in ("jump", "jumped") for n in nodes(e))
    ordered = sorted(automaton.modes, key=lambda m: m.name not in named)
    for mode in ordered:
        yield Frame(facts.scope(automaton), mode, jump=""), mode, None
    if has_jump:
        modes = facts.modes(automaton)
        for edge in sorted(automaton.edges, key=lambda k: k.name not in named):
            yield Frame(facts.scope(automaton), modes[edge.target], jump=edge.name), modes[edge.target], edge
