"""What the claims of a spec state about its outputs: bounds in a mode, limits of a step at an edge."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction

from haverify.lint._claims import always_goals, conjuncts
from haverify.lint._facts import Facts
from haverify.model.claim import Claim, Goal
from haverify.model.expression import Expr, nodes
from haverify.model.hybrid import HybridAutomaton
from haverify.solvers.frame import Frame
from haverify.solvers.literals import TooManyCasesError, cases, number_of
from haverify.text.record import record

Q = Fraction
Recorded = Mapping[str, tuple[str, ...]]  # the violated parts on record, by claim


@record
class Limit:
    """`low <= output <= high` in the mode `where`; at an edge (`A -> B`), the same for the output's step there.

    A firm limit is to be met. One that is expected to be violated tells a gross error from a small one.
    """

    claim: str
    automaton: str
    where: str
    edge: str
    output: str
    low: Q | None
    high: Q | None
    is_firm: bool

    def excess(self, low: Q, high: Q) -> Q:
        """How far values from `low` to `high` are outside."""
        below = self.low - low if self.low is not None else Q(0)
        above = high - self.high if self.high is not None else Q(0)
        return max(below, above, Q(0))

    @property
    def width(self) -> Q | None:
        """The width of the range, None where a side is open."""
        return None if self.low is None or self.high is None else self.high - self.low


@record
class _Side:
    output: str
    is_step: bool
    low: Q | None
    high: Q | None


def limits(facts: Facts, recorded: Recorded) -> list[Limit]:
    """The limits that `always` goals state for all time, with numbers."""
    found: list[Limit] = []
    for claim in facts.spec.claims:
        automaton = facts.automata.get(claim.on or "")
        is_bounded = claim.time is not None or claim.jumps is not None or bool(claim.assume)
        if automaton is not None and not is_bounded and _verdict(claim) != "unknown":
            for index, goal in enumerate(claim.goals):
                if goal.window is None and goal in always_goals(claim):
                    found += _of_goal(facts, automaton, claim, index, recorded)
    return found


def _verdict(claim: Claim) -> str:
    return claim.expect.verdict if claim.expect else "proved"


def _of_goal(facts: Facts, automaton: HybridAutomaton, claim: Claim, index: int, recorded: Recorded) -> Iterator[Limit]:
    goal = claim.goals[index]
    for where, edge, frame in _places(facts, automaton, goal):
        sides: dict[str, list[_Side]] = {}
        for c in conjuncts(goal.condition):
            side = _side(c, frame, bool(edge))
            if side is not None:
                sides.setdefault(side.output, []).append(side)
        for output, found in sides.items():
            low = max((s.low for s in found if s.low is not None), default=None)
            high = min((s.high for s in found if s.high is not None), default=None)
            is_firm = _is_firm(claim, index, where, output, recorded)
            if low is not None and high is not None and low > high:
                continue  # the claim itself is wrong and says nothing about the output
            yield Limit(claim.name, automaton.name, where, edge, output, low, high, is_firm)


def _places(facts: Facts, automaton: HybridAutomaton, goal: Goal) -> Iterator[tuple[str, str, Frame]]:
    """Modes while dwelling, and where the goal speaks of jumps, edges: a place, the edge's name, how names are read."""
    scope, modes = facts.scope(automaton), facts.modes(automaton)
    for mode in automaton.modes:
        yield mode.name, "", Frame(scope, mode, jump="")
    if any(n.op == "pre" for n in nodes(goal.condition)):
        for edge in automaton.edges:
            yield f"{edge.source} -> {edge.target}", edge.name, Frame(scope, modes[edge.target], jump=edge.name)


def _is_firm(claim: Claim, index: int, where: str, output: str, recorded: Recorded) -> bool:
    """Whether a limit is to be met: the claim's proof is expected, or this part is not among those known to fail."""
    if _verdict(claim) == "proved":
        return True
    goal = [f"goal {index + 1}"] if len(claim.goals) > 1 else []
    part = " / ".join([claim.on or "-", where, output, *goal])
    return claim.name in recorded and part not in recorded[claim.name]


def _side(e: Expr, frame: Frame, at_edge: bool) -> _Side | None:
    """The bound that a conjunct puts on one output, or at an edge on its step."""
    if e.op == "implies":
        premise, conclusion = e.children
        return _side(conclusion, frame, at_edge) if _is_true(premise, frame) else None
    if e.op not in ("<", "<=", ">", ">="):
        return None
    left, right = e.children
    is_upper = e.op[0] == "<"
    value = number_of(right, frame)
    if value is None:
        left, right, is_upper, value = right, left, not is_upper, number_of(left, frame)
    return None if value is None else _bounded(left, value, is_upper, at_edge)


def _bounded(e: Expr, value: Q, is_upper: bool, at_edge: bool) -> _Side | None:
    is_absolute = e.op == "abs"
    inner = e.children[0] if is_absolute else e
    output = _step_of(inner) if at_edge else inner.name if inner.op == "let" else None
    if output is None or (is_absolute and not is_upper):
        return None
    if is_absolute:
        return _Side(output, at_edge, -value, value)
    return _Side(output, at_edge, None, value) if is_upper else _Side(output, at_edge, value, None)


def _step_of(e: Expr) -> str | None:
    """The output whose step `y - pre(y)` is."""
    if e.op != "-" or len(e.children) != 2:
        return None
    now, before = e.children
    is_step = now.op == "let" and before.op == "pre" and before.children[0] == now
    return now.name if is_step else None


def _is_true(premise: Expr, frame: Frame) -> bool:
    if any(n.op not in ("at", "jump", "jumped", "or", "and", "not", "true") for n in nodes(premise)):
        return False
    try:
        return cases(premise, frame) == [()]
    except TooManyCasesError:
        return False
