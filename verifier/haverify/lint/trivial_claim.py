"""HA604: an `always` claim about the variables that the domains alone make true."""

from __future__ import annotations

from collections.abc import Iterator

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.lint._claims import always_goals, conjuncts
from haverify.lint._facts import Facts
from haverify.lint._registry import rule
from haverify.model.claim import Claim
from haverify.model.expression import Expr, nodes
from haverify.model.hybrid import HybridAutomaton
from haverify.model.spec import Spec
from haverify.solvers.answer import Contradiction
from haverify.solvers.conditions import Condition, decide
from haverify.solvers.frame import Frame

_OTHER = frozenset({"let", "jump", "jumped", "pre", "der", "time", "stuck"})


# Where one of these has no value a claim does not hold.
PARTIAL = {"sqrt", "log", "asin", "acos"}


@rule("HA604")
def trivial_claim(spec: Spec, facts: Facts) -> Iterator[Diagnostic]:
    """Claims about outputs are none of these: there the domain bounds the argument and the claim says what follows."""
    for claim in spec.claims:
        automaton = facts.automata.get(claim.on or "")
        if automaton is not None and claim.kind == "property":
            parts = [c for g in always_goals(claim) for c in conjuncts(g.condition) if _speaks_of_state(c)]
            if parts and all(_follows(facts, automaton, c) for c in parts):
                yield _finding(facts, claim, parts[0])


def _speaks_of_state(e: Expr) -> bool:
    ops = {n.op for n in nodes(e)}
    return "var" in ops and not ops & _OTHER and not ops & PARTIAL and not any(map(_may_divide_by_zero, nodes(e)))


def _may_divide_by_zero(e: Expr) -> bool:
    """Whether a quotient by what reads a variable: where it has no value the claim does not hold."""
    return e.op == "/" and any(n.op == "var" for n in nodes(e.children[1]))


def _follows(facts: Facts, automaton: HybridAutomaton, conjunct: Expr) -> bool:
    """Whether the closed domain of each mode implies the conjunct."""
    for mode in automaton.modes:
        frame = Frame(facts.scope(automaton), mode, jump="")
        conditions = [Condition(mode.domain, frame, closed=True), Condition(conjunct, frame, holds=False)]
        if not isinstance(decide(conditions), Contradiction):
            return False
    return True


def _finding(facts: Facts, claim: Claim, part: Expr) -> Diagnostic:
    return Diagnostic(
        "HA604",
        f"{claim.kind} {claim.name}: `{facts.text(part.span)}` follows from the domains alone",
        span=part.span or claim.span,
        notes=("it would hold whatever the flows, guards and resets are",),
        key=f"{claim.name} follows from the domains alone",
    )
