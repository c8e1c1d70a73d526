"""HA602: a claim `always P implies Q` whose premise is never true."""

from __future__ import annotations

from collections.abc import Iterator

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.lint._claims import always_goals, conjuncts, modes_of, situations
from haverify.lint._facts import Facts
from haverify.lint._reach import live_edges, reached_modes
from haverify.lint._registry import rule
from haverify.model.claim import Claim
from haverify.model.expression import Expr
from haverify.model.hybrid import HybridAutomaton, Mode
from haverify.model.spec import Spec
from haverify.solvers.answer import Contradiction
from haverify.solvers.conditions import Condition, decide
from haverify.solvers.frame import Frame
from haverify.solvers.literals import TooManyCasesError, cases


@rule("HA602")
def vacuous_claim(spec: Spec, facts: Facts) -> Iterator[Diagnostic]:
    """No reached mode, and no edge that fires, makes the premise true."""
    for claim in spec.claims:
        automaton = facts.automata.get(claim.on or "")
        if automaton is not None and facts.has_start(automaton):
            premises = [c.children[0] for g in always_goals(claim) for c in conjuncts(g.condition) if c.op == "implies"]
            for premise in dict.fromkeys(premises):
                key = "never true", automaton.name, premise
                if facts.remembered(key, lambda a=automaton, p=premise: is_never_true(facts, a, p)):  # type: ignore[misc]
                    yield _finding(facts, claim, premise)


def is_never_true(facts: Facts, automaton: HybridAutomaton, premise: Expr) -> bool:
    """Whether a condition certainly holds at no instant of a run."""
    reached = reached_modes(facts, automaton)
    named = modes_of(automaton, premise)
    if named is not None:
        return not named & reached
    live = {id(e) for e in live_edges(facts, automaton)}
    for frame, mode, edge in situations(facts, automaton, premise):
        is_possible = mode.name in reached if edge is None else id(edge) in live and edge.source in reached
        if is_possible and _may_hold(premise, frame, mode):
            return False
    return True


def _may_hold(premise: Expr, frame: Frame, mode: Mode) -> bool:
    """Whether the premise and the domain may hold together; often `at` and `jump` decide it."""
    try:
        folded = cases(premise, frame)
    except TooManyCasesError:
        return True
    if not folded or () in folded:
        return bool(folded)
    domain = [Condition(mode.domain, frame, closed=True)]
    return any(not isinstance(decide(domain, case), Contradiction) for case in folded)


def _finding(facts: Facts, claim: Claim, premise: Expr) -> Diagnostic:
    text = facts.text(premise.span)
    return Diagnostic(
        "HA602",
        f"{claim.kind} {claim.name}: the premise `{text}` is never true, so the claim holds trivially",
        span=premise.span or claim.span,
        key=f"{claim.name}: the premise {text} is never true",
    )
