"""What a goal asks of an automaton with flows and jumps: a condition, and at which instants."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from haverify.analyses.hybrid.conditions import Atom, Condition, Every, Some, condition
from haverify.analyses.hybrid.listing import Judged, landing_condition
from haverify.analyses.hybrid.model import HybridModel
from haverify.model.claim import Claim, Goal
from haverify.model.expression import Expr, nodes
from haverify.obligations.residual import Situation, residual
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import record

Q = Fraction
MOST_JUMPS = 200
ENDLESS = Q(10**6)  # s; what is bounded by jumps alone has to be shown before this
TIME = Expr("time")


@record
class Asked:
    """A goal as one condition on instants from `first` to `last`.

    `jumps` is how many jumps a run may make: a budget of the analysis, or where `last_jump`, what the claim is about.
    Where `to_the_end`, a run that is stuck before `last` keeps the goal from being proved (LANGUAGE S21).
    """

    kind: str
    condition: Expr
    first: Q
    last: Q
    jumps: int
    last_jump: bool = False
    to_the_end: bool = False


def asked_of(model: HybridModel, claim: Claim, goal: Goal) -> Asked:
    """The goal as a condition on a window of instants.

    Raises
    ------
    OutsideFragmentError    if the goal is of another kind, or has no horizon
    """
    if goal.kind == "stl":
        return _signal(model, claim, goal.condition)
    if goal.kind not in ("always", "can_reach", "reach"):
        raise OutsideFragmentError(f"`{goal.kind.replace('_', ' ')}` about a flow that is not clock-driven")
    ends = [model.values.number(e) for e in (claim.time, goal.within) if e is not None]
    first = Q(0)
    if goal.window is not None:
        first = max(first, model.values.number(goal.window[0]))
        ends.append(model.values.number(goal.window[1]))
    if not ends and claim.jumps is not None and goal.kind != "reach":
        if claim.jumps == 0:
            raise OutsideFragmentError("a horizon of no jumps, which holds the start alone")
        _fit_for_ends(model, goal, first)
        return Asked(goal.kind, goal.condition, first, ENDLESS, claim.jumps, last_jump=True)
    if not ends:
        raise OutsideFragmentError("a flow without a horizon; add `within T`")
    if min(ends) < first:
        raise OutsideFragmentError("the window holds no instant")
    _fit_for_ends(model, goal, first)
    jumps = MOST_JUMPS if claim.jumps is None else claim.jumps
    return Asked(goal.kind, goal.condition, first, min(ends), jumps)


def _signal(model: HybridModel, claim: Claim, e: Expr) -> Asked:
    """A formula of one temporal operator: `globally` is `always during`, `eventually` is `reach` in a window.

    Raises
    ------
    OutsideFragmentError    if there are more
    """
    temporal = [n for n in nodes(e) if n.op in ("globally", "eventually", "until")]
    if len(temporal) != 1 or e.op not in ("globally", "eventually"):
        raise OutsideFragmentError("`stl` of more than one `globally` or `eventually`, about a flow")
    low, high, inner = e.children
    first, last = model.values.number(low), model.values.number(high)
    kind = "always" if e.op == "globally" else "reach"
    _fit_for_ends(model, Goal(kind, inner), first)
    jumps = MOST_JUMPS if claim.jumps is None else claim.jumps
    return Asked(kind, inner, first, last, jumps, to_the_end=True)


def _fit_for_ends(model: HybridModel, goal: Goal, first: Q) -> None:
    """A run that ends in a terminal mode stays as it is: what speaks of time may become true (or false) later.

    Raises
    ------
    OutsideFragmentError    if the claim may depend on that
    """
    if any(m.terminal for m in model.modes) and (
        goal.kind == "reach" or first > 0 or any(n.op == "time" for n in nodes(goal.condition))
    ):
        raise OutsideFragmentError("a run may end in a terminal mode, and the claim speaks of later instants")


def judged_of(model: HybridModel, asked: Asked) -> Judged:
    """What the kernel judges: `always` and the denial of `can reach` outside the instants not asked for as well."""
    is_denied = asked.kind == "can_reach"

    def timed(c: Condition) -> Condition:
        if asked.last_jump:
            return c
        after = Atom(Expr("-", (TIME, Expr("num", (asked.last,)))), ">")
        before = Atom(Expr("-", (TIME, Expr("num", (asked.first,)))), "<")
        if asked.kind == "reach":
            return Every((c, Atom(after.quantity, "<="), Atom(before.quantity, ">=")))
        return Some((c, after, before) if asked.first > 0 else (c, after))

    dwelling = []
    for mode, known in zip(model.modes, model.definitions, strict=True):
        dwelling.append(timed(condition(residual(asked.condition, Situation(mode.name)), known, is_denied)))
    names = {m.name for m in model.modes}
    landing = {
        k: timed(landing_condition(model, e, asked.condition, is_denied))
        for k, e in enumerate(model.automaton.edges)
        if e.source in names
    }
    return Judged(tuple(dwelling), landing, Every(tuple(_window(model))))


def _window(model: HybridModel) -> Iterator[Condition]:
    """The declared ranges of the variables, as bounds."""
    for v in model.automaton.vars:
        if v.range is not None:
            low, high = (Expr("num", (q,)) for q in model.values.interval(v.range))
            yield Atom(Expr("-", (Expr("var", (v.name,)), low)), ">=")
            yield Atom(Expr("-", (Expr("var", (v.name,)), high)), "<=")
