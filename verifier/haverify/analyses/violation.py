"""Runs that violate one part of a claim, or meet a condition; found by exploring, then walked again as a whole."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from itertools import islice

from haverify.analyses.clock_model import PI, ClockModel
from haverify.analyses.counterexample import MOST_NODES, TRIES, Explorer, Node, choices, the_run, worst_moment
from haverify.analyses.motion import Motion, State, Stretch, stretches
from haverify.analyses.questions import Setting
from haverify.evidence.run import Run
from haverify.model.expression import Expr
from haverify.obligations.circle import stronger, weaker
from haverify.obligations.denial import denial
from haverify.obligations.formula import Formula, conjunction, disjunction, holds, negation, variables
from haverify.obligations.parts import Part
from haverify.obligations.residual import Situation, residual
from haverify.obligations.translate import Scope
from haverify.text.record import field, holder

Q = Fraction
FEWEST = 8  # states that are followed whatever the budget
EXPLORATIONS = 4  # whole explorations that one search for a run may come to, over all choices of params
NEAR = 48  # nodes looked at for each choice of params before any is followed further


@holder
class Explorers:
    """Explorations shared by the claims on one automaton; `most` states are followed for one choice of params."""

    model: ClockModel
    known: dict[object, Explorer] = field(default_factory=dict)
    most: int = MOST_NODES

    def allow(self, share: Fraction) -> None:
        """Let every exploration go as far as this share of the usual."""
        self.most = max(FEWEST, int(MOST_NODES * share))
        for explorer in self.known.values():
            explorer.most = self.most

    def get(self, params: Mapping[str, Q], horizon: Q | None, jumps: int | None) -> Explorer:
        """The exploration for these params, up to a horizon."""
        key = (tuple(params.items()), horizon, jumps)
        if key not in self.known:
            self.known[key] = Explorer(Motion(self.model, params), horizon, horizon is not None, jumps, most=self.most)
        return self.known[key]


def violating_run(
    setting: Setting, part: Part, explorers: Explorers, wanted: Mapping[str, Q], time: Q | None
) -> Run | None:
    """A run to an instant at which one residual of the part is false, everything assumed holding on the way."""
    model = setting.model
    for params in choices(model, wanted, on_params(setting)):
        explorer = explorers.get(params, time, _jump_limit(setting))
        found = _in_mode(setting, part, explorer) if part.kind == "dwell" else _at_edge(setting, part, explorer)
        for node, last in found:
            run = the_run(model, node, params, last)
            if keeps_assumptions(setting, explorer.motion, node, last):
                return run
    return None


def _jump_limit(setting: Setting) -> int | None:
    """`within K jumps` alone is a horizon; beside a time K only limits the analysis (S24)."""
    return setting.claim.jumps if setting.time_limit() is None else None


def on_params(setting: Setting) -> Formula:
    """The assumptions that speak of params alone."""
    scope = setting.model.timed_scope(0)
    assumed = (*setting.model.spec.assumptions, *setting.claim.assume)
    formulas = [scope.formula(a) for a in assumed]
    names = set(setting.model.params)
    return conjunction(f for f in formulas if variables(f) <= names)


def keeps_assumptions(setting: Setting, motion: Motion, node: Node, last: Q) -> bool:
    """Whether every assumption holds at every instant of the run that goes to the node and dwells there."""
    assumed = (*setting.model.spec.assumptions, *setting.claim.assume)
    if not assumed:
        return True
    dwell: Q = last
    here: Node | None = node
    while here is not None:
        scope = setting.model.timed_scope(here.state.mode)
        f = motion.along(conjunction(scope.formula(a) for a in assumed), here.state)
        kept = stretches(f, dwell)
        if not (len(kept) == 1 and kept[0] == Stretch(Q(0), dwell, True, True)):
            return False
        dwell, here = (here.step.dwell if here.step else Q(0)), here.parent
    return True


def _in_mode(setting: Setting, part: Part, explorer: Explorer) -> Iterator[tuple[Node, Q]]:
    model = setting.model
    index = model.index[part.mode]
    scope = model.timed_scope(index)
    good = _unless_violated(setting, part, scope)
    for node in islice(explorer.in_mode(index), TRIES):
        moment = _bad_moment(setting, explorer, node, good)
        if moment is not None:
            yield node, moment


def _unless_violated(setting: Setting, part: Part, scope: Scope) -> Formula:
    """What is false only where the part is violated, all its quotients being defined, in the claim's time."""
    denied = [negation(scope.formula(denial(r))) for r in part.residuals]
    return disjunction([negation(setting.timing()), weaker(conjunction(denied), PI)])


def _bad_moment(setting: Setting, explorer: Explorer, node: Node, good: Formula) -> Q | None:
    stay = explorer.stay(node.state)
    if stay is None:
        return None
    if explorer.jumps is not None and node.state.jumps == explorer.jumps:
        stay = (Q(0), False)  # the claim ends with this jump
    return worst_moment(explorer.motion.along(good, node.state), Stretch(Q(0), stay[0], True, True), setting.ranges)


def _at_edge(setting: Setting, part: Part, explorer: Explorer) -> Iterator[tuple[Node, Q]]:
    model = setting.model
    assert part.edge is not None, "a jump part has an edge"
    landing = model.landing(part.edge)
    good = _unless_violated(setting, part, landing)
    for node in islice(explorer.in_mode(model.edge(part.edge).source), TRIES):
        if explorer.jumps is None or node.state.jumps < explorer.jumps:
            for stretch in explorer.openings(node.state, part.edge):
                for child in _bad_jumps(setting, explorer, node, part.edge, stretch, good):
                    yield child, Q(0)


def _bad_jumps(
    setting: Setting, explorer: Explorer, node: Node, k: int, stretch: Stretch, good: Formula
) -> Iterator[Node]:
    moments = dict.fromkeys(stretch.rationals())
    if not any(v.endswith("'") for v in variables(good)):
        worst = worst_moment(explorer.motion.along(good, node.state), stretch, setting.ranges)
        moments = {} if worst is None else {worst: None}
    for t in moments:
        for child in explorer.jump(node, k, t):
            assert child.step is not None, "a jump is a step"
            before = explorer.motion.known(explorer.motion.at(node.state, t))
            chosen = {f"{v}'": x for v, x in child.step.values}
            if not holds(good, {**before, **chosen}):
                yield child


def meeting_run(setting: Setting, condition: Expr, explorers: Explorers, time: Q | None) -> Run | None:
    """A run to an instant at which the condition holds: first near the start, whatever the params, then further on."""
    left = EXPLORATIONS * explorers.most
    for most in (NEAR, explorers.most):
        for params in choices(setting.model, {}, on_params(setting)):
            explorer = explorers.get(params, time, _jump_limit(setting))
            for node in islice(explorer.everywhere(), min(most, left)):
                left -= 1
                for last in moments_met(setting, condition, explorer, node):
                    if keeps_assumptions(setting, explorer.motion, node, last):
                        return the_run(setting.model, node, params, last)
    return None


def moments_met(setting: Setting, condition: Expr, explorer: Explorer, node: Node) -> Iterator[Q]:
    """Some dwells in a node at which the condition holds: right after the jump first, then later."""
    model, state = setting.model, node.state
    if node.step is not None and _met_at_landing(setting, condition, explorer, node):
        yield Q(0)
        return
    folded = residual(condition, Situation(model.automaton.modes[state.mode].name))
    if folded.op == "false":
        return
    f = conjunction([stronger(model.timed_scope(state.mode).formula(folded), PI), setting.timing()])
    if f is False:
        return
    stay = explorer.stay(state)
    if stay is not None:
        for stretch in stretches(explorer.motion.along(f, state), stay[0]):
            yield from islice(stretch.rationals(), 1)


def _met_at_landing(setting: Setting, condition: Expr, explorer: Explorer, node: Node) -> bool:
    model = setting.model
    assert node.step is not None and node.parent is not None, "a landing has a step"
    edge = model.automaton.edges[node.step.edge]
    folded = residual(condition, Situation(edge.target, edge.source, edge.name))
    if folded.op in ("true", "false"):
        f: Formula = folded.op == "true"
    else:
        f = stronger(model.landing(node.step.edge).formula(folded), PI)
    before = explorer.motion.known(explorer.motion.at(node.parent.state, node.step.dwell))
    chosen = {f"{v}'": x for v, x in node.step.values}
    return holds(conjunction([f, setting.timing()]), {**before, **chosen})


def stuck_run(setting: Setting, mode: int, explorers: Explorers, time: Q | None) -> Run | None:
    """A run to a state of the mode in which no time can pass and no edge is enabled."""
    model = setting.model
    if model.mode(mode).terminal:
        return None
    for params in choices(model, {}, on_params(setting)):
        explorer = explorers.get(params, time, _jump_limit(setting))
        for node in islice(explorer.in_mode(mode), TRIES):
            end = stuck_after(explorer, node.state)
            if end is not None and keeps_assumptions(setting, explorer.motion, node, end):
                return the_run(model, node, params, end)
    return None


def stuck_after(explorer: Explorer, state: State) -> Q | None:
    """The dwell after which a state is stuck, None where it need not be."""
    stay = explorer.stay(state)
    if stay is None or not stay[1]:
        return None
    end = stay[0]
    for k in explorer.motion.model.leaving[state.mode]:
        if any(s.low <= end <= s.high and (end < s.high or s.high_closed) and (end > s.low or s.low_closed)
               for s in explorer.openings(state, k)):  # fmt: skip
            return None
    beyond = explorer.motion.stay(explorer.motion.at(state, end), None)
    return end if beyond is not None and beyond[0] == 0 else None
