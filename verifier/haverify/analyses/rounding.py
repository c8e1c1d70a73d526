"""The second verdict: does a claim hold for every model that rounds to the printed numbers, or for none
(LANGUAGE S28)?"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from haverify.analyses.always import Judged, judge
from haverify.analyses.clock_model import PI
from haverify.analyses.context import Context, cells_name
from haverify.analyses.goals import Answer, margin_of
from haverify.analyses.motion import Motion, State
from haverify.analyses.poly_range import Ranges, Work, surely
from haverify.analyses.questions import Setting
from haverify.evidence.evidence import PartResult, Rounding
from haverify.evidence.run import Run
from haverify.evidence.verdict import Margin, Proved, Refuted, Unknown
from haverify.model.expression import nodes
from haverify.obligations.circle import weaker
from haverify.obligations.denial import denial
from haverify.obligations.formula import conjunction, negation, transform
from haverify.obligations.parts import Part
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import replace

Q = Fraction
Json = Any


def decide_rounding(
    context: Context, settings: Sequence[Setting], answers: Sequence[Answer], word: str, units: int
) -> tuple[Json, Rounding | None]:
    """What the certificate says about rounding, and the verdict; nothing where the claim reads no rounded constant."""
    if any(a.entry.get("kind") == "signals" for a in answers):
        return None, _over_time(context, settings)
    read = {n for a in answers for p in a.parts for n in p.constants}
    if not read & set(context.rounding):
        return None, None
    if context.rounded is None:
        return None, Rounding(Unknown("fragment", "rounded constants occur in guards, domains or flows"), None)
    try:
        if word == "proved":
            return _for_all(context, settings, answers, units)
        return _for_none(context, settings, answers)
    except OutsideFragmentError as e:
        return None, Rounding(Unknown("fragment", str(e)), None)


def _over_time(context: Context, settings: Sequence[Setting]) -> Rounding | None:
    """Claims over time that may read rounded constants are decided for the numbers as printed only."""
    read = any(n.op in ("let", "const") for s in settings for n in nodes(s.goal.condition))
    reason = "claims over time are decided for the numbers as printed"
    return Rounding(Unknown("fragment", reason), None) if read and context.rounding else None


def _for_all(
    context: Context, settings: Sequence[Setting], answers: Sequence[Answer], units: int
) -> tuple[Json, Rounding]:
    entries: list[Json] = []
    worst: list[tuple[Q, Setting, Judged]] = []
    failed: list[str] = []
    for setting, answer in zip(settings, answers, strict=True):
        entry = dict(answer.entry)
        if entry.get("kind") == "cells":
            found = _parts(context, setting, answer, units)
            failed += [j.part.where for j in found if not j.proved]
            worst += [(j.low.low, setting, j) for j in found if j.low is not None]
            entry["parts"] = [{**e, "proof": j.trees} for e, j in zip(answer.entry["parts"], found, strict=True)]
        entries.append(entry)
    least = min(worst, key=lambda w: w[0], default=None)
    margin = None if least is None else margin_of(least[1], least[2])
    if failed:
        places = ", ".join(dict.fromkeys(failed))
        reason = f"some values that round to the printed ones keep the claim, others may not ({places})"
        return None, Rounding(Unknown("rounding", reason), margin)
    return {"verdict": "proved", "goals": entries}, Rounding(Proved(margin), margin)


def _parts(context: Context, setting: Setting, answer: Answer, units: int) -> list[Judged]:
    """The parts once more, with the rounded constants as unknowns."""
    assert context.rounded is not None, "asked for only where cells do not depend on rounding"
    wide = replace(setting, model=context.rounded, extra=context.rounding)
    cells = _cells_of(context, answer)
    work = Work(units)
    return [
        j if not set(p.constants) & set(context.rounding) else judge(wide, j.part, cells, work)
        for j, p in zip(answer.judged, answer.parts, strict=True)
    ]


def _cells_of(context: Context, answer: Answer) -> Any:
    wanted = answer.entry["cells"]
    for (time, jumps), cells in context.known_cells():
        if cells_name(context.automaton.name, time, jumps) == wanted:
            return cells
    return context.cells()


def _for_none(context: Context, settings: Sequence[Setting], answers: Sequence[Answer]) -> tuple[Json, Rounding]:
    """Whether a run that violates the claim does so for every value."""
    for g, (setting, answer) in enumerate(zip(settings, answers, strict=True)):
        if answer.verdict != "refuted":
            continue
        certain = [i for i, (j, p) in enumerate(zip(answer.judged, answer.parts, strict=True))
                   if p.run is not None and violates_all(context, setting, j.part, p.run)]  # fmt: skip
        if not certain:
            continue
        entries: list[Json] = [{} for _ in answers]
        entries[g] = _only_runs(answer.entry, certain)
        worst = max(
            (m for i in certain if (m := _margin(answer.parts[i])) is not None), key=lambda m: -m.low, default=None
        )
        return {"verdict": "refuted", "goals": entries}, Rounding(Refuted(worst), worst)
    reason = "violated by the printed numbers, but not for every value that rounds to them"
    return None, Rounding(Unknown("rounding", reason), None)


def _margin(part: PartResult) -> Margin | None:
    return None if isinstance(part.verdict, Unknown) else part.verdict.margin


def _only_runs(entry: Json, certain: Sequence[int]) -> Json:
    """The goal's entry with nothing but the runs that hold for every value."""
    kept = []
    for i, e in enumerate(entry["parts"]):
        kept.append(e if i in certain else {k: v for k, v in e.items() if k not in ("run", "proof")})
    return {**entry, "parts": kept}


def violates_all(context: Context, setting: Setting, part: Part, run: Run) -> bool:
    """Whether the run's last instant violates the part for every value of the rounded constants."""
    model = context.rounded
    assert model is not None, "asked for only where runs do not depend on rounding"
    if part.kind == "stuck":
        return True
    motion = Motion(context.model, dict(run.params))
    state = end_of(motion, run, before_last_jump=part.kind == "jump")
    scope = model.landing(part.edge) if part.edge is not None else model.timed_scope(model.index[part.mode])
    body = weaker(conjunction(negation(scope.formula(denial(r))) for r in part.residuals), PI)
    values = {**motion.known(state), **({f"{v}'": x for v, x in run.steps[-1].values} if part.kind == "jump" else {})}
    wrong = transform(negation(body), lambda p: p.fix(values))
    return surely(wrong, context.rounding, Ranges())


def end_of(motion: Motion, run: Run, before_last_jump: bool) -> State:
    """The last state of a run, or the one just before its last jump."""
    model = motion.model
    state = State(model.index[run.mode], dict(run.values), Q(0))
    for i, step in enumerate(run.steps):
        state = motion.at(state, step.dwell)
        if before_last_jump and i == len(run.steps) - 1:
            return state
        edge = model.edge(step.edge)
        known = motion.known(state)
        assigned = {v: r.low.value(known) for v, r in edge.resets.items() if not r.is_set}
        state = State(edge.target, {**state.values, **assigned, **dict(step.values)}, state.time, state.jumps + 1)
    return motion.at(state, run.last)
