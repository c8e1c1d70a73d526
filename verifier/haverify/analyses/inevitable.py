"""Deciding `reach P within T`: cells that all lead to P in time, or a run that never meets it.

The cells form a tree in time: each has a scaled dwell at which P certainly holds, or is certainly left through an edge,
for cells further on. A run that blocks, or goes on past T, without P is a counterexample.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import Any

from haverify.analyses.cell import Cell, Exit
from haverify.analyses.clocked import Cells, landed, leave, left_window, longest, starts
from haverify.analyses.context import Context, cells_json, state_json
from haverify.analyses.counterexample import Explorer, Node, choices, the_run
from haverify.analyses.goals import Answer, first_start
from haverify.analyses.motion import stretches
from haverify.analyses.opening import opening
from haverify.analyses.placement import Placement, place
from haverify.analyses.poly_range import Work
from haverify.analyses.questions import Setting
from haverify.analyses.stuck import certain_exit
from haverify.analyses.violation import keeps_assumptions, moments_met, on_params, stuck_after
from haverify.evidence.certificate import inevitable_goal, run_goal
from haverify.evidence.evidence import PartResult
from haverify.evidence.run import Run
from haverify.evidence.verdict import Proved, Refuted, Unknown
from haverify.model.expression import nodes
from haverify.obligations.formula import Formula, by_bounds, conjunction, negation, truth
from haverify.obligations.residual import Situation, residual
from haverify.text.record import field, holder, replace

Q = Fraction
Json = Any
MOST = 400


@holder
class Leading:
    """The cells found so far, and at which scaled dwell the goal is met in those where it is."""

    cells: Cells
    meets: dict[int, Q] = field(default_factory=dict)
    reason: str = ""


def decide_reach(context: Context, setting: Setting, number: int, work: Work) -> Answer:
    """A `reach` goal."""
    start = first_start(context, setting)
    if start is None:
        return Answer("unknown", {}, Unknown("vacuous", "no admissible start satisfies what is assumed"))
    digest = context.hashes.part(context.hashes.goal(setting.claim, setting.goal), "goal", "", "")
    found = leading(context, setting, work)
    result = PartResult(number, "goal", "", "", "every run meets it in time", Proved())
    if not found.reason:
        name = f"{context.automaton.name}-reach-{digest[:12]}"
        entry = inevitable_goal(name, state_json(context.model, *start), digest)
        answer = Answer("proved", entry, parts=[result])
        answer.cells[name] = cells_json(found.cells, found.meets)
        return answer
    run = missing_run(context, setting)
    if run is not None:
        refuted = replace(result, text="a run never meets it in time", verdict=Refuted(), run=run)
        return Answer("refuted", run_goal(run, digest), parts=[refuted], run=run)
    kind = "window" if left_window(found.cells) is not None else "budget"
    unknown = Unknown(kind, f"{found.reason}, and no run that misses it was found")
    return Answer("unknown", {}, unknown, parts=[replace(result, verdict=unknown)])


def leading(context: Context, setting: Setting, work: Work) -> Leading:
    """Cells that all lead to the goal in time; `reason` says where that fails."""
    model = context.model
    found = Leading(Cells(model, None, None, model.rho is not None))
    limit = setting.time_limit()
    if model.rho is None or limit is None:
        found.reason = "the modes do not share one rate, so time is not followed"
        return found
    cells = found.cells.cells
    cells.extend(starts(model, True, False))
    position = 0
    most = setting.scaled(MOST)
    while position < len(cells) and not found.reason:
        if len(cells) > most or not work.spend(1):
            found.reason = "too many cells before the goal is met"
        else:
            _follow(setting, found, position)
        position += 1
    window = left_window(found.cells)
    if window is not None and not found.reason:
        found.reason = window[1]
    return found


def _follow(setting: Setting, found: Leading, index: int) -> None:
    """Meet the goal in a cell, or add the cells that it leads to."""
    model, cell = setting.model, found.cells.cells[index]
    cell.dwell = longest(model, cell, None)
    at = meeting(setting, cell)
    if at is not None:
        found.meets[index] = at
        cell.dwell = at if cell.dwell is None or at < cell.dwell else cell.dwell
    name = model.automaton.modes[cell.mode].name
    if at is None and (
        model.mode(cell.mode).terminal or not any(certain_exit(found.cells, index, k) for k in model.leaving[cell.mode])
    ):
        found.reason = f"a run may stay in mode {name}, or block there, before the goal is met"
        return
    limit = setting.time_limit()
    first = None if cell.sigma is None else cell.sigma.low
    if at is None and first is not None and limit is not None and first > limit * model.rho_range[1]:
        found.reason = f"time is over in mode {name} before the goal is met"
        return
    short = cell if at is None else replace(cell, dwell=at)
    for k in model.leaving[cell.mode]:
        out = leave(model, short, model.edge(k), None)
        is_later = out is not None and at is not None and out.dwell[0] >= at  # the goal is met before the jump
        if out is not None and not is_later and not met_by_landing(setting, short, out):
            found.cells.cells.extend(landed(cell, out, model))


def met_by_landing(setting: Setting, cell: Cell, out: Exit) -> bool:
    """Whether the goal certainly holds, in time, at the instant at which an exit lands, whatever its outcome."""
    model = setting.model
    edge = model.automaton.edges[out.edge]
    folded = residual(setting.goal.condition, Situation(edge.target, edge.source, edge.name))
    if folded.op == "false":
        return False
    landing = model.landing(out.edge)
    met = conjunction([landing.formula(folded), setting.timing()])
    excused = negation(setting.assumptions(landing))
    placement = place(model, cell, out, {})
    return _shown(setting, placement, met) or (excused is not False and _shown(setting, placement, excused))


def meeting(setting: Setting, cell: Cell) -> Q | None:
    """A scaled dwell at which the goal certainly holds in the cell, in time, the domain holding until then."""
    model = setting.model
    name = model.automaton.modes[cell.mode].name
    folded = residual(setting.goal.condition, Situation(name))
    if folded.op == "false":
        return None
    scope = model.timed_scope(cell.mode)
    goal = scope.formula(folded)
    begins = opening(goal, model, cell)
    wanted = [Q(0), None if begins is None else begins.last, cell.dwell]
    assumed = (*model.spec.assumptions, *setting.claim.assume)
    late = negation(conjunction(scope.formula(a) for a in assumed))
    for at in dict.fromkeys(w for w in wanted if w is not None):
        if (cell.dwell is None or at <= cell.dwell) and (at == 0 or not model.mode(cell.mode).terminal):
            met = conjunction([goal, setting.timing()])
            fits = _certain(setting, cell, at, at, met) or (bool(assumed) and _certain(setting, cell, at, at, late))
            if fits and _certain(setting, cell, Q(0), at, model.mode(cell.mode).domain):
                return at
    return None


def _certain(setting: Setting, cell: Cell, first: Q, last: Q, f: Formula) -> bool:
    """Whether signs alone show the formula for all states of the cell at these scaled dwells."""
    if first == last:
        slopes = setting.model.mode(cell.mode).slopes
        entry = {
            v: replace(x, low=_plus(x.low, slopes[v] * first), high=_plus(x.high, slopes[v] * first))
            for v, x in cell.entry.items()
        }
        sigma = cell.sigma and replace(cell.sigma, low=_plus(cell.sigma.low, first), high=_plus(cell.sigma.high, first))
        cell = replace(cell, entry=entry, sigma=sigma, dwell=Q(0))
    else:
        cell = replace(cell, dwell=last)
    return _shown(setting, place(setting.model, cell, None, {}), f)


def _shown(setting: Setting, placement: Placement, f: Formula) -> bool:
    placed = placement.place(f)
    if not placement.bounded:
        return placed is True
    return (
        truth(placed, lambda leaf: by_bounds(leaf.op, *setting.ranges.bounds(leaf.polynomial, placement.box))) is True
    )


def _plus(end: Q | None, way: Q) -> Q | None:
    return None if end is None else end + way


def missing_run(context: Context, setting: Setting) -> Run | None:
    """A run without the goal that goes on past the bound, or blocks."""
    ends = [setting.model.values.number(e) for e in (setting.claim.time, setting.goal.within) if e is not None]
    if not ends or setting.claim.jumps is not None or any(n.op == "stuck" for n in nodes(setting.goal.condition)):
        return None
    bound = max(ends)
    for params in choices(context.model, {}, on_params(setting)):
        explorer = context.explorers.get(params, bound + 1, None)
        for state in explorer.motion.starts():
            run = _search(setting, explorer, Node(state, None, None), bound)
            if run is not None:
                node, last = run
                if keeps_assumptions(setting, explorer.motion, node, last):
                    return the_run(context.model, node, params, last)
    return None


def _search(setting: Setting, explorer: Explorer, first: Node, bound: Q) -> tuple[Node, Q] | None:
    stack, seen = [first], set[object]()
    while stack and len(seen) < setting.scaled(MOST // 4):
        node = stack.pop()
        key = (node.state.mode, tuple(node.state.values.items()), node.state.time, node.step and node.step.edge)
        if key in seen:
            continue
        seen.add(key)
        end = _missed_end(setting, explorer, node, bound)
        if end is not None:
            return node, end
        stack.extend(_escapes(setting, explorer, node))
    return None


def _missed_end(setting: Setting, explorer: Explorer, node: Node, bound: Q) -> Q | None:
    """A dwell after which the run has missed the goal, if it may end in this node."""
    if next(moments_met(setting, setting.goal.condition, explorer, node), None) is not None:
        return None
    stay = explorer.stay(node.state)
    if stay is None:
        return None
    left = bound - node.state.time
    if stay[0] > left:
        return left + min(stay[0] - left, Q(1)) / 2 if left >= 0 else Q(0)
    return stuck_after(explorer, node.state)


def _escapes(setting: Setting, explorer: Explorer, node: Node) -> Iterator[Node]:
    """The next nodes that are entered before the goal is met."""
    model, state = setting.model, node.state
    name = model.automaton.modes[state.mode].name
    folded = residual(setting.goal.condition, Situation(name))
    first: Q | None = None
    if node.step is not None and next(moments_met(setting, setting.goal.condition, explorer, node), None) == 0:
        return
    if folded.op != "false":
        f = conjunction([model.timed_scope(state.mode).formula(folded), setting.timing()])
        stay = explorer.stay(state)
        met = [] if stay is None else stretches(explorer.motion.along(f, state), stay[0])
        first = met[0].low if met else None
    for child in explorer.children(node):
        assert child.step is not None, "a child has a step"
        if first is None or child.step.dwell < first:
            yield child
