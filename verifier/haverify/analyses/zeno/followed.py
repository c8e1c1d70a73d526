"""When jumps accumulate, from both sides: flowpipes through some jumps, and a time to go from the states after them.

A run makes infinitely many jumps before it accumulates, so not before the first of its jumps that are followed is over;
and from the states right after the last of them an end of all runs is shown as from any starts, a closer one, since
there the speeds are small and what bends the flow hardly varies.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from haverify.analyses.hybrid.goal import reads_time
from haverify.analyses.hybrid.model import HybridModel, hybrid_model
from haverify.analyses.hybrid.model import Start as FlowStart
from haverify.analyses.hybrid.question import Question, question_of, settings_of, sides
from haverify.maths.interval import Interval
from haverify.model.claim import Claim, Goal
from haverify.model.expression import Expr
from haverify.model.hybrid import HybridAutomaton, Init, Param, Range
from haverify.model.spec import Spec
from haverify.solvers.kernel import Budget, Jump, Pair, Stretch, reach
from haverify.text.record import record, replace

Q = Fraction
TRUE = Expr("true")
JUMPS = (2, 4, 6, 8, 12, 16, 24, 32)  # how many are followed, one after the other, as far as that works
ROOM, EACH = 24, 4  # stretches that may be followed for them, and for each of them more
CUTS = 2
LEFT_OUT = "the stretches allowed were used up"
STEPS = 100  # of one stretch; a tree has at most twice as many


@record
class Landing:
    """Where all runs of a stretch are right after the last jump that was followed: mode, instants, ranges."""

    mode: str
    time: tuple[Q, Q]
    states: tuple[tuple[str, Q, Q], ...]


@record
class Followed:
    """Flowpipes through `jumps` jumps: no run accumulates before `low`; the landings all runs come to that go on.

    `ended` is the latest instant of runs that may end on the way. `holds` says whether a goal held all the way.
    """

    jumps: int
    low: Q
    ended: Q
    landings: tuple[Landing, ...]
    holds: bool


def followed(
    spec: Spec, automaton: HybridAutomaton, claim: Claim, goal: Goal, horizon: Q, jumps: int
) -> Followed | None:
    """Flowpipes from all starts through so many jumps, None where a run may go on to the horizon without them.

    `goal` is of kind `always`; what it claims is looked at up to the last of these jumps, whatever its own horizon.

    Raises
    ------
    OutsideFragmentError    if the automaton is not of the kind that flowpipes follow
    """
    asked = replace(goal, kind="always", window=None, within=None)
    timed = replace(claim, goals=(asked,), time=_number(horizon), jumps=jumps, using=(), which=())
    model = hybrid_model(spec, automaton, [asked.condition])
    if not model.is_plain or reads_time(model, replace(asked, condition=TRUE)):
        return None
    question = question_of(model, timed, asked)
    landings, lows, ended, holds = list[Landing](), list[Q](), Q(0), True
    for start in model.starts:
        tree = _tree(question, start, horizon, jumps)
        last = _last_ones(tree, jumps)
        if last is None:
            return None
        found = [(s, j) for s in last if (j := s.jump) is not None]
        landings += [_landing(model, s, j) for s, j in found]
        lows += [Q(j.time[0]) for _, j in found]
        ended = max([ended, *(Q(s.stages[-1].time[1]) for s in tree if s.end == "left" and s.stages)])
        holds = holds and all(_holds(s, jumps) for s in tree)
    return Followed(jumps, max(min(lows), Q(0)), ended, _joined(landings), holds) if landings else None


def _tree(question: Question, start: FlowStart, horizon: Q, jumps: int) -> list[Stretch]:
    budget = Budget(jumps, ROOM + EACH * jumps, CUTS)
    until = Interval.at(horizon).high
    settings = replace(settings_of(question, start.box, False), steps=STEPS)
    return reach(question.modes, (start.mode, sides(start.box), []), until, "horizon", settings, budget)


def _joined(landings: Sequence[Landing]) -> tuple[Landing, ...]:
    """One box for each mode, around all landings in it."""
    found: dict[str, Landing] = {}
    for x in landings:
        y = found.get(x.mode, x)
        around = ((n, min(a, c), max(b, d)) for (n, a, b), (_, c, d) in zip(x.states, y.states, strict=True))
        time = min(x.time[0], y.time[0]), max(x.time[1], y.time[1])
        found[x.mode] = Landing(x.mode, time, tuple(around))
    return tuple(found.values())


def _last_ones(tree: Sequence[Stretch], jumps: int) -> list[Stretch] | None:
    """The stretches that begin with the last jump; None where runs may go on without it, or stretches are missing."""
    if any(s.end == LEFT_OUT for s in tree):
        return None
    parents = {s.parent for s in tree}
    for number, s in enumerate(tree):
        goes_on = s.end in ("jumped", "cut") or (s.end == "left" and number in parents)
        if s.jumps < jumps and not goes_on and s.end != "left":
            return None
    return [s for s in tree if s.jumps == jumps and s.jump is not None]


def _holds(s: Stretch, jumps: int) -> bool:
    """Whether what is claimed holds in a stretch, right after its jump, and in the declared ranges."""
    landed = s.jump is None or s.jump.claim.holds
    return landed and (s.jumps == jumps or all(g.claim.holds and g.keeps_window for g in s.stages))


def _landing(model: HybridModel, s: Stretch, jump: Jump) -> Landing:
    count = len(model.automaton.vars)
    states = tuple((n, *_exact(pair)) for n, pair in zip(model.names[:count], jump.after[:count], strict=True))
    return Landing(model.places[s.mode].mode, _exact(jump.time), states)


def _exact(pair: Pair) -> tuple[Q, Q]:
    return Q(pair[0]), Q(pair[1])


def from_landings(
    spec: Spec, automaton: HybridAutomaton, found: Followed, clock: str | None = None
) -> tuple[Spec, HybridAutomaton]:
    """The spec in which the automaton starts at the landings at time 0; the param `clock` is when they are."""
    first, last = min(x.time[0] for x in found.landings), max(x.time[1] for x in found.landings)
    lines = tuple(Init(x.mode, _inside(x), ()) for x in found.landings)
    more = () if clock is None else (Param(clock, None, Range(_number(first), _number(last)), None),)
    own = replace(automaton, init=lines, params=(*automaton.params, *more))
    return replace(spec, automata=tuple(own if a is automaton else a for a in spec.automata)), own


def _inside(x: Landing) -> Expr:
    bounds = []
    for name, low, high in x.states:
        v = Expr("var", (name,))
        bounds += [Expr(">=", (v, _number(low))), Expr("<=", (v, _number(high)))]
    return Expr("and", tuple(bounds))


def _number(q: Q) -> Expr:
    return Expr("num", (q,))
