"""One goal of a claim, decided: certificate entry, parts, margin, run."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from fractions import Fraction
from typing import Any

from haverify.analyses.always import Judged, judge
from haverify.analyses.clock_model import reads_time
from haverify.analyses.clocked import Cells
from haverify.analyses.context import Context, cells_name, state_json
from haverify.analyses.counterexample import choices
from haverify.analyses.motion import Motion, State
from haverify.analyses.poly_range import ENOUGH, Work
from haverify.analyses.quantities import facts_about
from haverify.analyses.questions import Setting
from haverify.analyses.telling import constants_read, decimal, has_quotient, part_text, place_text, unit_of
from haverify.analyses.unreached import why_unreached
from haverify.analyses.violation import meeting_run, on_params, stuck_run, violating_run
from haverify.evidence.certificate import cells_goal, run_goal, run_json
from haverify.evidence.evidence import PartResult
from haverify.evidence.run import Run
from haverify.evidence.verdict import Margin, Proved, Refuted, Unknown, Verdict
from haverify.maths.exact import leading_exponent
from haverify.model.claim import Goal
from haverify.model.expression import Expr
from haverify.obligations.formula import conjunction, holds
from haverify.obligations.parts import Part, conjuncts, parts, pushed
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import field, holder, replace

Q = Fraction
Json = Any
FEW_CELLS = 64  # so many may go further than a goal needs


@holder
class Answer:
    """What was found out about one goal."""

    verdict: str  # "proved", "refuted", "unknown"
    entry: Json
    unknown: Unknown | None = None
    parts: list[PartResult] = field(default_factory=list)
    judged: list[Judged] = field(default_factory=list)
    run: Run | None = None
    margin: Margin | None = None
    worst: int | None = None  # position in `parts` of the part that sets the margin
    cells: dict[str, Json] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def decide_always(context: Context, setting: Setting, number: int, work: Work) -> Answer:
    """An `always` goal, or (`can_reach` by its negation) that a condition is never met."""
    if not setting.has_instants():
        return vacuous("its window holds no instant")
    asked = list(parts(condition_of(setting.goal), context.automaton, context.model.index))
    cells, judged = _on_cells(context, setting, asked, work)
    start = known_start(context, setting)
    if start is None:
        return vacuous("no admissible start satisfies what is assumed")
    if setting.goal.kind == "always":
        empty = _vacuity(setting, asked, judged, cells)
        if empty is not None:
            return empty
    answer = Answer("unknown", {}, judged=judged)
    entries = [_part(context, setting, number, j, cells, answer) for j in judged]
    verdicts = {type(p.verdict) for p in answer.parts}
    answer.verdict = "refuted" if Refuted in verdicts else "unknown" if Unknown in verdicts else "proved"
    if answer.verdict == "unknown":
        answer.unknown = next(p.verdict for p in answer.parts if isinstance(p.verdict, Unknown))
        return answer
    name = cells_name(context.automaton.name, cells.time, cells.jumps)
    answer.entry = cells_goal(name, state_json(context.model, *start), entries)
    if any("proof" in e for e in entries):
        answer.cells[name] = context.cells_value(cells)
    _total_margin(answer)
    return answer


def condition_of(goal: Goal) -> Expr:
    """What has to hold always: the goal's condition, or its negation for `can_reach`."""
    return goal.condition if goal.kind == "always" else Expr("not", (goal.condition,), None, goal.condition.span)


def _on_cells(context: Context, setting: Setting, asked: list[Part], work: Work) -> tuple[Cells, list[Judged]]:
    """The parts judged on the cells of all runs, or else on those up to the horizon."""
    best: tuple[Cells, list[Judged]] | None = None
    for time, jumps in _horizons(context, setting):
        cells = context.cells(time, jumps)
        found = [judge(setting, p, cells, work) for p in asked] if cells.trouble is None else []
        if cells.trouble is None and all(j.proved for j in found):
            return cells, found
        if best is None or best[0].trouble is not None or _no_worse(found, best[1]):
            best = (cells, found)
    assert best is not None, "there is at least one horizon to try"
    if best[0].trouble is not None:
        best = best[0], [Judged(p, proved=False, reason=best[0].trouble[1], touched=True) for p in asked]
    return best


def _no_worse(found: list[Judged], before: list[Judged]) -> bool:
    """Whether cells of a shorter time show as much: their margins are those of the claim's horizon."""
    return bool(found) and all(j.proved or not b.proved for j, b in zip(found, before, strict=True))


def _horizons(context: Context, setting: Setting) -> Iterator[tuple[Q | None, int | None]]:
    """How far cells may go to decide a goal, to be tried in this order."""
    limit = setting.time_limit()
    timed = setting.goal.window is not None or _reads_time(setting)
    if timed and setting.model.rho is None:
        raise OutsideFragmentError("the claim speaks of time, but the modes do not share one rate")
    if timed and limit is None:
        raise OutsideFragmentError("the claim reads `time` without a horizon; add `within T`")
    if not timed:
        yield None, None
    if limit is not None and setting.model.rho is not None:
        last = _last_instant(context, setting)
        if timed and last > limit and _are_few(context.cells(last)):
            yield last, None
        yield limit, None
    elif limit is None and setting.claim.jumps is not None:
        yield None, setting.claim.jumps


def _last_instant(context: Context, setting: Setting) -> Q:
    """The last instant that a goal of the claim asks cells for: one file of them may do for all its goals."""
    name = setting.claim.name
    if name not in context.instants:
        goals = [replace(setting, goal=g) for g in setting.claim.goals if g.kind in ("always", "can_reach")]
        ends = [s.time_limit() for s in goals if s.goal.window is not None or _reads_time(s)]
        context.instants[name] = max((e for e in ends if e is not None), default=Q(0))
    return context.instants[name]


def _are_few(cells: Cells) -> bool:
    return cells.trouble is None and len(cells.cells) <= FEW_CELLS


def _reads_time(setting: Setting) -> bool:
    read = [setting.goal.condition, *setting.claim.assume, *setting.model.spec.assumptions]
    return any(reads_time(e, setting.model.timed_lets) for e in read)


def known_start(context: Context, setting: Setting) -> tuple[State, dict[str, Q]] | None:
    """`first_start`, kept for the claims that assume the same."""
    if setting.claim.assume not in context.starts:
        context.starts[setting.claim.assume] = first_start(context, setting)
    return context.starts[setting.claim.assume]


def first_start(context: Context, setting: Setting) -> tuple[State, dict[str, Q]] | None:
    """An admissible start under which everything assumed holds."""
    model = context.model
    assumed = (*model.spec.assumptions, *setting.claim.assume)
    for params in choices(model, {}, on_params(setting)):
        motion = Motion(model, params)
        for state in motion.starts():
            scope = model.timed_scope(state.mode)
            if not assumed or holds(conjunction(scope.formula(a) for a in assumed), motion.known(state)):
                return state, params
    return None


def vacuous(reason: str) -> Answer:
    """The answer to a claim that speaks of nothing."""
    return Answer(
        "unknown", {}, Unknown("vacuous", reason, next_step="correct the premise, the init line or the assumption")
    )


def _vacuity(setting: Setting, asked: list[Part], judged: list[Judged], cells: Cells) -> Answer | None:
    """Nothing is proved of nothing: a claim whose whole premise is never true is not decided (rule of verdicts 3)."""
    if cells.trouble is not None or not all(j.proved for j in judged):
        return None
    members = conjuncts(pushed(setting.goal.condition))
    if not all(c.op == "implies" for c in members):
        return None
    if any(j.touched for j in judged):
        premises = tuple(dict.fromkeys(c.children[0] for c in members))
        key = (premises, setting.claim.assume, setting.claim.time, setting.goal.window, setting.goal.within)
        if key not in cells.never:
            cells.never[key] = _never_true(setting, premises, cells)
        return vacuous("the premise is never true on any run") if cells.never[key] else None
    if not asked:
        return vacuous("the premise is never true, whatever the run")
    places = ", ".join(dict.fromkeys(p.where for p in asked[:6]))
    return vacuous(f"the premise is never true: no run comes to {places}")


def _never_true(setting: Setting, premises: Iterable[Expr], cells: Cells) -> bool:
    """Whether it is proved that no state of the cells satisfies one of the premises."""
    model, work = setting.model, Work(ENOUGH // 10)
    denied = Expr("and", tuple(Expr("not", (p,)) for p in premises))
    asked = parts(denied, model.automaton, model.index)
    return all(judge(setting, part, cells, work, with_margin=False).proved for part in asked)


def _part(context: Context, setting: Setting, number: int, j: Judged, cells: Cells, answer: Answer) -> Json:
    """The certificate's entry of a part; its result is added to the answer."""
    part = j.part
    digest = context.hashes.part(goal_hash(context, setting), part.kind, part.where, part.output)
    entry: dict[str, Json] = {"kind": part.kind, "where": part.where, "output": part.output, "hash": digest}
    run = None
    margin = margin_of(setting, j)
    verdict: Verdict
    if j.proved:
        entry["proof"] = j.trees
        margin = margin if margin is None else replace(margin, low=max(margin.low, Q(0)))
        verdict = Proved(margin)
    else:
        run = _run_against(context, setting, j)
        run = None if run is not None and _is_late(setting, run) else run
        if run is not None:
            entry["run"] = run_json(run)
            answer.run = answer.run if answer.run is not None and len(answer.run.steps) <= len(run.steps) else run
            verdict = Refuted(margin if margin is None or margin.low <= 0 else None)
        else:
            verdict = _undecided(j, cells)
    facts = facts_about(setting, j) if run is not None else ()
    text, read = part_text(part, isinstance(verdict, Refuted)), constants_read(setting.model, part)
    answer.parts.append(PartResult(number, part.kind, part.where, part.output, text, verdict, run, facts, read))
    return entry


def goal_hash(context: Context, setting: Setting) -> str:
    """The hash of a goal, computed once."""
    known = setting.hash
    if known is None:
        known = setting.hash = context.hashes.goal(setting.claim, setting.goal)
    return known


def _is_late(setting: Setting, run: Run) -> bool:
    """Whether a run ends after the last jump that the claim speaks of (S24: beside a time, jumps are no horizon)."""
    if setting.claim.jumps is None or setting.time_limit() is not None:
        return False
    made = len(run.steps)
    return (made, made > 0 and run.last > 0) > (setting.claim.jumps, False)


def _run_against(context: Context, setting: Setting, j: Judged) -> Run | None:
    limit = setting.time_limit()
    if j.part.kind == "stuck":
        return stuck_run(setting, context.model.index[j.part.mode], context.explorers, limit)
    if j.low is not None and j.low.low > 0 and j.reason != "":
        return None
    wanted = dict(j.low.point) if j.low is not None else {}
    if setting.goal.kind != "always":
        return None
    return violating_run(setting, j.part, context.explorers, wanted, limit)


def _undecided(j: Judged, cells: Cells) -> Unknown:
    kind = cells.trouble[0] if cells.trouble is not None else "budget"
    near = "" if j.low is None else f"the least margin seen is {decimal(j.low.high)}"
    return Unknown(kind, f"{part_text(j.part)}: {j.reason}, and no run that violates it was found", nearest=near)


def margin_of(setting: Setting, j: Judged) -> Margin | None:
    """The margin of a part in words and numbers."""
    if j.low is None or j.question is None or abs(j.low.low) >= 10**9:
        return None
    unit = unit_of(j.part)
    if unit is None or has_quotient(setting.model, j.part):
        return None
    strict = j.margin_strict
    return Margin(rounded_down(j.low.low), -rounded_down(-j.low.high), unit, place_text(setting.model, j), strict)


def rounded_down(q: Q) -> Q:
    """A number not above `q`, with at most 12 significant decimal digits; `q` itself where it is that short."""
    if q.denominator <= 10**9 and abs(q.numerator) <= 10**15:
        return q
    places = min(max(11 - leading_exponent(q), 0), 40)
    return Q(q.numerator * 10**places // q.denominator, 10**places)


def _total_margin(answer: Answer) -> None:
    """The worst of the parts' margins, where they share a unit with the worst."""
    listed = [(p.verdict.margin, i) for i, p in enumerate(answer.parts) if not isinstance(p.verdict, Unknown)]
    found = [(m, i) for m, i in listed if m is not None]
    if found:
        answer.margin, answer.worst = min(found, key=lambda x: x[0].low)


def decide_can_reach(context: Context, setting: Setting, number: int, work: Work) -> Answer:
    """A `can_reach` goal: a run proves it, cells that never meet it refute it."""
    if first_start(context, setting) is None:
        return vacuous("no admissible start satisfies what is assumed")
    limit = setting.time_limit()
    if setting.goal.condition.op == "stuck":
        modes = range(len(context.automaton.modes))
        run = next((r for m in modes if (r := stuck_run(setting, m, context.explorers, limit)) is not None), None)
    else:
        run = meeting_run(setting, setting.goal.condition, context.explorers, limit)
    run = None if run is not None and _is_late(setting, run) else run
    text = "a run reaches it"
    if run is not None:
        digest = context.hashes.part(goal_hash(context, setting), "goal", "", "")
        result = PartResult(number, "goal", "", "", text, Proved(), run)
        return Answer("proved", run_goal(run, digest), parts=[result], run=run)
    answer = decide_always(context, setting, number, work)
    if answer.verdict == "proved":
        answer.verdict = "refuted"
        answer.parts = [_reversed(p) for p in answer.parts]
        answer.notes = (*answer.notes, *why_unreached(setting.goal.condition, context.cells()))
    else:
        answer.verdict, answer.entry = "unknown", {}
        answer.unknown = answer.unknown or Unknown(
            "budget", "no run that reaches it was found, nor a proof that there is none"
        )
    return answer


def _reversed(p: PartResult) -> PartResult:
    margin = p.verdict.margin if isinstance(p.verdict, Proved) else None
    return replace(p, verdict=Proved(margin))
