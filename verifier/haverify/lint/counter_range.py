"""HA311: an edge that moves a counter (or truth value) out of the range of its type."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.lint._facts import Facts, any_of
from haverify.lint._registry import rule
from haverify.lint._wording import edge_name, point_text, quantity
from haverify.maths.polynomial import constant
from haverify.model.expression import Expr
from haverify.model.hybrid import Assign, Edge, HybridAutomaton
from haverify.model.spec import EnumType, Spec
from haverify.solvers.answer import Answer, Holds
from haverify.solvers.conditions import Condition
from haverify.solvers.literals import Literal


@rule("HA311")
def counter_range(spec: Spec, facts: Facts) -> Iterator[Diagnostic]:
    """For variables of an enumeration `a..b`; the state must meet the domain and the guard."""
    for automaton in spec.automata:
        scope = facts.scope(automaton)
        for edge in automaton.edges:
            for assign in edge.resets:
                variable = scope.vars.get(assign.var)
                enum = scope.enums.get(variable.type) if variable else None
                if enum is not None and enum.low is not None and enum.high is not None and isinstance(assign.to, Expr):
                    yield from _check(facts, automaton, edge, assign, enum)


def _check(
    facts: Facts, automaton: HybridAutomaton, edge: Edge, assign: Assign, enum: EnumType
) -> Iterator[Diagnostic]:
    assert enum.low is not None and enum.high is not None
    for bound, side in ((enum.high, 1), (enum.low, -1)):
        answer = _leaves(facts, automaton, edge, assign, bound, side)
        if isinstance(answer, Holds) and answer.is_exact:
            yield _finding(facts, automaton, edge, assign, enum, answer, side)
            return


def _leaves(facts: Facts, automaton: HybridAutomaton, edge: Edge, assign: Assign, bound: Fraction, side: int) -> Answer:
    """Whether the assigned value may lie beyond `bound`."""
    mode = facts.modes(automaton)[edge.source]
    frame = facts.frame(automaton, mode)
    conditions = [Condition(mode.domain, frame, closed=True), Condition(edge.guard, frame)]
    answers = []
    for o in facts.reset("HA311", edge, frame):
        beyond = Literal((constant(bound) - o.values[assign.var]).scaled(Fraction(side)), "<")
        answers.append(facts.decide("HA311", edge_name(edge), assign.span, conditions, (*o.case, beyond)))
    return any_of(answers)


def _finding(
    facts: Facts, automaton: HybridAutomaton, edge: Edge, assign: Assign, enum: EnumType, answer: Holds, side: int
) -> Diagnostic:
    assert enum.low is not None and enum.high is not None
    limit = f"{assign.var} < {quantity(enum.high, None)}" if side > 0 else f"{assign.var} > {quantity(enum.low, None)}"
    return Diagnostic(
        "HA311",
        f"{edge_name(edge)}: `{facts.text(assign.span)}` leaves {enum.name} "
        f"({quantity(enum.low, None)}..{quantity(enum.high, None)})",
        span=assign.span,
        notes=(f"from {point_text(answer.point, facts.scope(automaton))}",),
        help=f"add `and {limit}` to the guard",
        key=f"{automaton.name}: {edge_name(edge)} moves {assign.var} out of {enum.name}",
    )
