"""Claims about automata with flows and jumps, by the tree of stretches that encloses all their runs.

`always P`, `can reach P`, `reach P within T`, and `stl` with one temporal operator. What holds on every stretch holds
on every run. Where it does not, the box of starts is split. A start whose own stretches certainly exist and certainly
violate `P` refutes. Trust: `enclosed`.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from haverify.analyses.flow_model import Box
from haverify.analyses.flow_record import record_name
from haverify.analyses.hybrid.model import Start, hybrid_model
from haverify.analyses.hybrid.prove import margin, proved_by, undecided
from haverify.analyses.hybrid.question import Question, pair, question_of
from haverify.analyses.hybrid.recorded import tree_json
from haverify.analyses.hybrid.runs import by_a_run
from haverify.evidence.certificate import certificate, run_json, start_json
from haverify.evidence.evidence import Evidence, PartResult
from haverify.evidence.flowpipe import Stretch as Drawn
from haverify.evidence.flowpipe import flowpipe_json
from haverify.evidence.run import Run
from haverify.evidence.verdict import Proved, Refuted, Unknown, Verdict
from haverify.model.claim import Claim
from haverify.model.hybrid import HybridAutomaton
from haverify.model.spec import Spec
from haverify.obligations.constants import params_of
from haverify.obligations.obligation import hashes
from haverify.obligations.translate import OutsideFragmentError
from haverify.solvers.kernel import Pair, Stretch
from haverify.text.record import record, replace

Json = Any
METHOD = "taylor-reach"
Q = Fraction
RECORDED = ("always", "can_reach")


def decide_hybrid(spec: Spec, automaton: HybridAutomaton, claim: Claim, core: Json) -> Evidence:
    """What enclosures of all runs show of a claim on an automaton with flows and jumps.

    Raises
    ------
    OutsideFragmentError    if the automaton or the claim is not of that kind
    """
    if claim.inductive or claim.using or claim.kind == "invariant":
        raise OutsideFragmentError("invariants of flows need a proof of induction, which flowpipes are not")
    if claim.assume or spec.assumptions:
        raise OutsideFragmentError("assumptions beside a flow that is not clock-driven")
    model = hybrid_model(spec, automaton, [g.condition for g in claim.goals])
    answers = [_answered(question_of(model, claim, goal)) for goal in claim.goals]
    verdict = _combined([a.verdict for a in answers])
    parts = tuple(
        PartResult(i, "flow", model.modes[model.starts[0].mode].name, "", a.text, a.verdict, a.run)
        for i, a in enumerate(answers)
    )
    shown = next((a.drawing for a in answers if a.verdict is verdict), answers[0].drawing)
    if isinstance(verdict, Unknown):
        return Evidence(verdict, parts, METHOD, flowpipe=shown)
    known = hashes(spec, automaton, core)
    entries = []
    cells: dict[str, Json] = {}
    for number, (goal, answer) in enumerate(zip(claim.goals, answers, strict=True)):
        digest = known.part(known.goal(claim, goal), "flow", parts[0].where, "")
        entries.append({**answer.entry, "hash": digest} if answer.entry else {})
        if answer.record is not None:
            name = entries[-1]["flow"] = record_name(claim.name, number)
            cells[name] = answer.record
    word = "proved" if isinstance(verdict, Proved) else "refuted"
    run = next((a.run for a in answers if a.run is not None), None)
    made = certificate(claim.name, word, entries, None)
    return Evidence(verdict, parts, METHOD, made, cells, run=run, flowpipe=shown)


@record
class Answer:
    """The verdict on one goal, the part in words, its entry in the certificate, the run and the record that show it."""

    verdict: Verdict
    text: str = ""
    entry: Json = None
    run: Run | None = None
    drawing: Json = None
    record: Json = None


def _combined(verdicts: Sequence[Verdict]) -> Verdict:
    for kind in (Refuted, Unknown):
        found = next((v for v in verdicts if isinstance(v, kind)), None)
        if found is not None:
            return found
    margins = [v.margin for v in verdicts if isinstance(v, Proved) and v.margin is not None]
    return Proved(min(margins, key=lambda m: m.low, default=None))


def _answered(question: Question) -> Answer:
    answer = _decide(question)
    return replace(answer, drawing=drawing(question))


def _decide(question: Question) -> Answer:
    """The verdict on one goal."""
    kind = question.asked.kind
    start, run = by_a_run(question)
    if run is not None:
        shown: Json = {"kind": "flow_run", "run": run_json(run)}
        if kind == "can_reach":
            return Answer(Proved(), "a run reaches it", shown, run)
        return Answer(Refuted(), "violated" if kind == "always" else "never met", shown, run)
    if start is None:
        return Answer(Unknown("vacuous", "no start was found that is certainly admissible"))
    proof = proved_by(question)
    if proof is None:
        return Answer(undecided(question))
    entry = {"kind": "flowpipe", "start": _start_json(question, *start)}
    record = tree_json(question, [box for box, _ in question.shown]) if kind in RECORDED else None
    if kind == "can_reach":
        return Answer(Refuted(), "never reached", entry, record=record)
    text = "holds along every flowpipe" if kind == "always" else "met along every flowpipe"
    return Answer(Proved(margin(question, proof)), text, entry, record=record)


def _start_json(question: Question, start: Start, point: Sequence[Q]) -> Json:
    """An admissible start; params that nothing reads have any value in their range."""
    model = question.model
    count = len(model.automaton.vars)
    params = {p.name: model.values.interval(p.range)[0] for p in params_of(model.spec, model.automaton)}
    known = dict(zip(model.names[count:-1], point[count:-1], strict=True))
    values = dict(zip(model.names[:count], point[:count], strict=True))
    return start_json(model.modes[start.mode].name, values, {**params, **known})


def drawing(question: Question) -> Json:
    """The trees to draw, None where there are none."""
    model = question.model
    drawn = [
        Drawn(model.modes[s.mode].name, s.jumps, _first(s, box), [(g.time, g.states) for g in s.stages])
        for box, tree in question.shown
        for s in tree
        if s.stages
    ]
    return flowpipe_json(model.names, drawn) if drawn else None


def _first(s: Stretch, box: Box) -> Sequence[Pair]:
    """The box of a stretch where it starts."""
    if s.jump is not None:
        return s.jump.after
    return [pair(*ends) for ends in box] if s.parent is None else s.stages[0].states
