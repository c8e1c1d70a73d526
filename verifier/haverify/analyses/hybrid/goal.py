"""What a goal asks of an automaton with flows and jumps: a condition, and at which instants."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from fractions import Fraction

from haverify.analyses.hybrid.conditions import Atom, Condition, Every, Some, closed, condition, members
from haverify.analyses.hybrid.conserved import Conserved
from haverify.analyses.hybrid.listing import Judged, landing_condition
from haverify.analyses.hybrid.model import HybridModel
from haverify.analyses.signals_formula import TEMPORAL, formula_of, is_temporal
from haverify.model.claim import Claim, Goal
from haverify.model.expression import Expr, nodes
from haverify.model.hybrid import Range
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import record

Q = Fraction
MOST_JUMPS = 200
ENDLESS = Q(10**6)  # s; what is bounded by jumps alone has to be shown before this
LONG = Q(100)  # s; so far runs are followed that may violate what has no horizon
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
    # Whether all instants are asked for; `last` is then how far runs are looked at that may violate it.
    endless: bool = False
    # Whether the condition itself says up to when: what is claimed later holds because its premise does not.
    by_premise: bool = False


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
        if None in model.origins:
            raise OutsideFragmentError("a horizon of jumps alone, beside `abs`, `min`, `max` or `if` in a flow")
        _fit_for_ends(model, goal, first)
        return Asked(goal.kind, goal.condition, first, ENDLESS, claim.jumps, last_jump=True)
    if not ends and goal.kind != "reach" and goal.window is None and not reads_time(model, goal):
        _fit_for_ends(model, goal, first)
        return Asked(goal.kind, goal.condition, first, LONG, MOST_JUMPS, endless=True)
    premised = _last_of_premise(model, goal.condition) if goal.kind == "always" and not ends else None
    if premised is not None and premised >= first:
        return Asked(goal.kind, goal.condition, first, premised, _budget(model, claim), by_premise=True)
    if not ends:
        raise OutsideFragmentError("a flow without a horizon; add `within T`")
    if min(ends) < first:
        raise OutsideFragmentError("the window holds no instant")
    _fit_for_ends(model, goal, first)
    return Asked(goal.kind, goal.condition, first, min(ends), _budget(model, claim))


def _last_of_premise(model: HybridModel, e: Expr) -> Q | None:
    """The last instant at which the premise of an implication may hold, as a bound of `time` among its conjuncts."""
    if e.op != "implies":
        return None
    bounds = [c for c in members(e.children[0]) if c.op in ("<", "<=", ">", ">=")]
    sides = [c.children if c.op[0] == "<" else c.children[::-1] for c in bounds]
    found = [most for least, most in sides if least.op == "time"]
    try:
        return min((model.values.number(bound) for bound in found), default=None)
    except OutsideFragmentError:
        return None


def _budget(model: HybridModel, claim: Claim) -> int:
    """How many jumps are followed; changes of side count as well."""
    changes = MOST_JUMPS if None in model.origins else 0
    return (MOST_JUMPS if claim.jumps is None else claim.jumps) + changes


def reads_time(model: HybridModel, goal: Goal) -> bool:
    """Whether anything depends on the time since the start."""
    edges = [e for e in model.automaton.edges if any(m.name == e.source for m in model.modes)]
    told = [goal.condition, *model.assumed, *model.used, *(e.guard for e in edges), *(m.domain for m in model.modes)]
    ranges = [line.rate for m in model.modes for line in m.flow] + [a.to for e in edges for a in e.resets]
    told += [e for r in ranges for e in ((r.low, r.high) if isinstance(r, Range) else (r,))]
    told += [e for of in model.definitions for e in of.values()]
    return any(n.op == "time" for e in told for n in nodes(e))


def _signal(model: HybridModel, claim: Claim, e: Expr) -> Asked:
    """A formula of one temporal operator: `globally` is `always during`, `eventually` is `reach` in a window.

    One of several is asked as a whole, from the start to as far as it looks.
    """
    if sum(n.op in TEMPORAL for n in nodes(e)) != 1 or e.op not in ("globally", "eventually"):
        return _formula(model, claim, e)
    low, high, inner = e.children
    first, last = model.values.number(low), model.values.number(high)
    kind = "always" if e.op == "globally" else "reach"
    _fit_for_ends(model, Goal(kind, inner), first)
    return Asked(kind, inner, first, last, _budget(model, claim), to_the_end=True)


def _formula(model: HybridModel, claim: Claim, e: Expr) -> Asked:
    """A formula of several temporal operators.

    Raises
    ------
    OutsideFragmentError    if runs may end in a terminal mode, or are judged up to an assumption only
    """
    if any(m.terminal for m in model.modes):
        raise OutsideFragmentError("`stl` of several temporal operators, beside a terminal mode")
    if model.assumed:
        raise OutsideFragmentError("`stl` of several temporal operators, beside assumptions on states")
    horizon = formula_of(e, model.values.number).horizon
    return Asked("signal", e, Q(0), horizon, _budget(model, claim), to_the_end=True)


def _fit_for_ends(model: HybridModel, goal: Goal, first: Q) -> None:
    """A run that ends in a terminal mode stays as it is: what speaks of time may become true (or false) later.

    Raises
    ------
    OutsideFragmentError    if the claim may depend on that
    """
    terminal = [number for number, m in enumerate(model.modes) if m.terminal]
    # A run that ends where the goal is met whatever the state has met it.
    is_met = all(model.dwelling(goal.condition, number).op == "true" for number in terminal)
    is_late = first > 0 or any(n.op == "time" for n in nodes(goal.condition))
    if terminal and (is_late or (goal.kind == "reach" and not is_met)):
        raise OutsideFragmentError("a run may end in a terminal mode, and the claim speaks of later instants")


def judged_of(model: HybridModel, asked: Asked, laws: Conserved | None = None) -> Judged:
    """What the kernel judges: `always` and the denial of `can reach` outside the instants not asked for as well.

    Comparisons of what all runs keep by `laws` are decided by the starts.
    Runs are judged as long as assumptions hold (LANGUAGE S25); invariants that are used hold on all of them.
    """
    is_denied = asked.kind == "can_reach"
    told_of = Expr("true") if is_temporal(asked.condition) else asked.condition  # a formula is judged by its atoms

    def timed(c: Condition) -> Condition:
        if asked.last_jump or asked.endless or asked.kind == "signal":
            return c
        after = Atom(Expr("-", (TIME, Expr("num", (asked.last,)))), ">")
        before = Atom(Expr("-", (TIME, Expr("num", (asked.first,)))), "<")
        if asked.kind == "reach":
            return Every((c, Atom(after.quantity, "<="), Atom(before.quantity, ">=")))
        return Some((c, after, before) if asked.first > 0 else (c, after))

    def told(c: Condition, number: int) -> Condition:
        return timed(c if laws is None else laws.simpler(c, number))

    dwelling = []
    for number, known in enumerate(model.definitions):
        dwelling.append(told(condition(model.dwelling(told_of, number), known, is_denied), number))
    names = {m.name for m in model.modes}
    landing = {
        k: told(landing_condition(model, k, told_of, is_denied), model.mode(e.target))
        for k, e in enumerate(model.automaton.edges)
        if e.source in names
    }
    assumed = tuple(tuple(_held(model, k, model.assumed)) for k in range(len(model.modes)))
    used = [tuple(_held(model, k, model.used)) for k in range(len(model.modes))]
    facts = tuple(tuple(a for c in (*x, *y) for a in _members(closed(c))) for x, y in zip(assumed, used, strict=True))
    return Judged(tuple(dwelling), landing, Every(tuple(window(model))), facts, assumed)


def _held(model: HybridModel, number: int, conditions: Iterable[Expr]) -> Iterator[Condition]:
    """Conditions on the state while dwelling in a mode.

    Raises
    ------
    OutsideFragmentError    if one reads jumps
    """
    for e in conditions:
        if any(n.op in ("jump", "jumped", "pre") for n in nodes(e)):
            raise OutsideFragmentError("assumptions and invariants about jumps, beside a flow")
        yield condition(model.dwelling(e, number), model.definitions[number])


def _members(c: Condition) -> Iterator[Atom]:
    """The comparisons that a conjunction has as members."""
    if isinstance(c, Atom):
        yield c
    elif isinstance(c, Every):
        for member in c.members:
            yield from _members(member)


def window(model: HybridModel) -> Iterator[Condition]:
    """The declared ranges of the variables, as bounds; those of variables that keep their value are kept anyway."""
    for number, v in enumerate(model.automaton.vars):
        if v.range is None or _keeps_its_range(model, number):
            continue
        low, high = model.values.interval(v.range)
        yield Atom(_beyond(v.name, low), ">=")
        yield Atom(_beyond(v.name, high), "<=")


def _beyond(name: str, q: Q) -> Expr:
    """How far a variable is beyond a number, written as in a comparison with it."""
    variable = Expr("var", (name,))
    return Expr("-", (variable, Expr("num", (q,)))) if q else variable


def _keeps_its_range(model: HybridModel, number: int) -> bool:
    """Whether a variable starts in its declared range, and neither flows nor jumps change it."""
    v = model.automaton.vars[number]
    assert v.range is not None
    low, high = model.values.interval(v.range)
    rates = [line.rate for m in model.modes for line in m.flow if line.var == v.name]
    is_set = any(a.var == v.name for e in model.automaton.edges for a in e.resets)
    is_inside = all(low <= s.box[number][0] and s.box[number][1] <= high for s in model.starts)
    return is_inside and not is_set and all(isinstance(r, Expr) and _is_zero(r) for r in rates)


def _is_zero(e: Expr) -> bool:
    return e.op == "num" and e.args[0] == 0
