"""Ends of runs from the states after some jumps: closer ones than from the starts, and what is true of all instants."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import Any

from haverify.analyses.hybrid.model import hybrid_model
from haverify.analyses.hybrid.question import question_of
from haverify.analyses.hybrid.runs import admissible, params_at
from haverify.analyses.induction.refute import Effort
from haverify.analyses.zeno.closings import closings, shown_by
from haverify.analyses.zeno.followed import JUMPS, TRUE, Followed, followed, from_landings
from haverify.evidence.certificate import start_json
from haverify.model.claim import Claim, Goal
from haverify.model.expression import Expr, rebuild
from haverify.model.hybrid import HybridAutomaton
from haverify.model.spec import Spec
from haverify.obligations.induction import Induction
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import record, replace

Q = Fraction
Json = Any
CLOCK = "time of the last jump followed"
NEAR = Q(1, 1000)  # of the end: closer brackets are not looked for


@record
class Bracket:
    """When jumps accumulate, in all runs: not before `low`, and no instant is after `high`; `jumps` were followed."""

    low: Q
    high: Q
    jumps: int


def bracket(spec: Spec, automaton: HybridAutomaton, claim: Claim, end: Q) -> Bracket | None:
    """The closest bracket that was found, where no instant is after `end`; None where there is no lower end.

    Trust               `enclosed`: the flowpipes through the jumps are the kernel's
    """
    goal, low, high, most = Goal("always", TRUE), Q(0), end, 0
    plain = replace(claim, goals=(goal,), time=None, jumps=None, using=(), which=())
    for found in _through(spec, automaton, plain, goal, end):
        after = _end_after(spec, automaton, plain, found)
        last, before = max(x.time[1] for x in found.landings), (low, high)
        low, most = max(low, found.low), found.jumps
        high = high if after is None else min(high, max(last + after, found.ended))
        if high - low <= NEAR * high or (low, high) == before:
            break
    return Bracket(low, high, most) if most else None


def _through(spec: Spec, automaton: HybridAutomaton, claim: Claim, goal: Goal, end: Q) -> Iterator[Followed]:
    """Flowpipes through more and more jumps, as far as they go."""
    for jumps in JUMPS:
        try:
            found = followed(spec, automaton, claim, goal, end + 1, jumps)
        except OutsideFragmentError:
            return
        if found is None:
            return
        yield found


def _end_after(spec: Spec, automaton: HybridAutomaton, claim: Claim, found: Followed) -> Q | None:
    """How long runs go on at most from the landings."""
    after, own = from_landings(spec, automaton, found)
    induction = Induction(after, own, claim, claim.goals[0])
    shown = (c for c in closings(induction) if shown_by(induction, c, Effort()).is_proved())
    return next((c.end for c in shown), None)


@record
class Tail:
    """That a goal holds at all instants: through some jumps along flowpipes, and then by an end of all runs."""

    jumps: int
    high: Q
    start: Json
    mode: str


def by_tail(spec: Spec, automaton: HybridAutomaton, claim: Claim, goal: Goal, end: Q, effort: Effort) -> Tail | None:
    """A proof of an `always` goal by flowpipes through some jumps, and an invariant that ends all runs after them."""
    if goal.kind != "always" or goal.window is not None:
        return None
    start = _start(spec, automaton, claim, goal, end)
    if start is None:
        return None
    for found in _through(spec, automaton, claim, goal, end):
        if not found.holds:
            return None
        after, own = from_landings(spec, automaton, found, CLOCK)
        later = replace(goal, condition=_later(goal.condition), within=None)
        alone = replace(claim, goals=(later,), time=None, jumps=None, using=())
        induction = Induction(after, own, alone, later)
        induction.check()
        closing = next((c for c in closings(induction) if shown_by(induction, c, effort).is_proved()), None)
        if closing is not None:
            high = max(max(x.time[1] for x in found.landings) + closing.end, found.ended)
            return Tail(found.jumps, high, *start)
    return None


def _later(e: Expr) -> Expr:
    """A condition in which the time is counted from the landings."""
    if e.op == "time":
        return Expr("+", (e, Expr("param", (CLOCK,))))
    return rebuild(e, _later)


def _start(spec: Spec, automaton: HybridAutomaton, claim: Claim, goal: Goal, end: Q) -> tuple[Json, str] | None:
    """A start that is certainly admissible, and the mode that flowpipes begin in."""
    timed = replace(claim, goals=(goal,), time=Expr("num", (end,)), using=())
    model = hybrid_model(spec, automaton, [goal.condition])
    found = admissible(question_of(model, timed, goal))
    if found is None:
        return None
    start, point = found
    values = dict(zip([v.name for v in model.automaton.vars], point, strict=False))
    told = start_json(model.places[start.mode].mode, values, params_at(model, point))
    return told, model.places[model.starts[0].mode].mode
