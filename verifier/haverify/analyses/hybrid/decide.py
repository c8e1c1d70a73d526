"""Claims about automata with flows, by the tree of stretches between jumps that encloses all their runs.

`always P`, `can reach P`, `reach P within T`, and `stl`, whose formulas of several temporal operators are read off
timelines. What holds on every stretch holds
on every run. Where it does not, the box of starts is split. A start whose own stretches certainly exist and certainly
violate `P` refutes. Trust: `enclosed`.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from haverify.analyses.hybrid.conserved import conserved
from haverify.analyses.hybrid.counted import proved_by_counting
from haverify.analyses.hybrid.drawing import drawing
from haverify.analyses.hybrid.endless import not_for_ever, proved_for_ever
from haverify.analyses.hybrid.formulas import broken_by_one, kept_by_all, open_formula
from haverify.analyses.hybrid.inputs import fields
from haverify.analyses.hybrid.margin import margin
from haverify.analyses.hybrid.model import Start, hybrid_model, written_out
from haverify.analyses.hybrid.prove import proved_at_once, proved_by, undecided
from haverify.analyses.hybrid.question import Question, question_of
from haverify.analyses.hybrid.record import proof_record, record_name, run_record
from haverify.analyses.hybrid.runs import admissible, admissible_points, by_a_run, params_at
from haverify.analyses.hybrid.shared import Trees
from haverify.evidence.certificate import certificate, run_json, start_json
from haverify.evidence.evidence import Evidence, PartResult
from haverify.evidence.run import Run
from haverify.evidence.verdict import Proved, Refuted, Unknown, Verdict
from haverify.model.claim import Claim
from haverify.model.hybrid import HybridAutomaton
from haverify.model.spec import Spec
from haverify.obligations.obligation import Hashes, hashes
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import record, replace

Json = Any
METHOD = "taylor-reach"
Q = Fraction
RECORDED = ("always", "can_reach", "reach")
USUAL = Q(1)


def decide_flow(
    spec: Spec,
    automaton: HybridAutomaton,
    claim: Claim,
    core: Json,
    budget: Q = USUAL,
    trees: Trees | None = None,
    with_laws: bool = False,
    stated: tuple[Hashes, Claim] | None = None,
) -> Evidence:
    """What enclosures of all runs show of a claim on an automaton with flows; `budget` is the work allowed, 1 is usual.

    `trees` are those of other claims on the automaton. With laws comparisons of what all runs keep are decided by the
    starts, which a record does not show. `stated` are the hashes and the claim as written, where these are others.

    Raises
    ------
    OutsideFragmentError    if the automaton or the claim is not of that kind
    """
    if claim.inductive:
        raise OutsideFragmentError("invariants of flows need a proof of induction, which flowpipes are not")
    used = [g.condition for c in spec.claims if c.name in claim.using for g in c.goals]
    shared = Trees() if trees is None else trees
    written = shared.written(automaton, lambda: written_out(spec, automaton))
    model = hybrid_model(spec, automaton, [g.condition for g in claim.goals], claim.assume, used, written)
    model.compiled = shared.compiled
    laws = conserved(model) if with_laws and not model.open else None
    questions = [question_of(model, claim, goal, laws) for goal in claim.goals]
    answers = [_answered(replace(q, budget=budget, trees=shared)) for q in questions]
    verdict = _combined([a.verdict for a in answers])
    parts = tuple(
        PartResult(i, "flow", model.places[model.starts[0].mode].mode, "", a.text, a.verdict, a.run)
        for i, a in enumerate(answers)
    )
    shown = next((a.drawing for a in answers if a.verdict is verdict), answers[0].drawing)
    if isinstance(verdict, Unknown):
        return Evidence(verdict, parts, METHOD, flowpipe=shown)
    known, written_claim = stated or (hashes(spec, automaton, core), claim)
    entries = []
    cells: dict[str, Json] = {}
    for number, (goal, answer) in enumerate(zip(written_claim.goals, answers, strict=True)):
        digest = known.part(known.goal(written_claim, goal), "flow", parts[0].where, "")
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
    """The verdict on one goal: what is likely is tried first, a proof from whole boxes before runs or after them."""
    start = admissible(question)
    if start is None:
        return Answer(Unknown("vacuous", "no start was found that is certainly admissible"))
    kind, entry = question.asked.kind, {"kind": "flowpipe", "start": _start_json(question, *start)}
    if kind == "signal":
        return _by_its_signal(question, entry)
    is_counted = proved_by_counting(question)
    if is_counted:
        return Answer(Proved(), "holds along flowpipes, on which jumps are counted", entry)
    is_endless = question.asked.endless
    proof = None if is_endless or is_counted is False or _is_run_likely(question) else proved_at_once(question)
    _, run = by_a_run(question) if proof is None else (None, None)
    if run is not None:
        return _by_the_run(question, run)
    if is_counted is False:
        return Answer(undecided(question))
    proof = proved_for_ever(question) if is_endless else proof or proved_by(question)
    if proof is None:
        return Answer(not_for_ever(question) if is_endless else undecided(question))
    record = proof_record(question, proof) if _may_be_recorded(question) else None
    if kind == "can_reach":
        return Answer(Refuted(), "never reached", entry, record=record)
    text = "holds along every flowpipe" if kind == "always" else "met along every flowpipe"
    if is_endless:
        return Answer(Proved(), "holds along flowpipes that return into themselves", entry)
    return Answer(Proved(margin(question, proof, *start)), text, entry, record=record)


def _by_its_signal(question: Question, entry: Json) -> Answer:
    """The verdict on a formula of several temporal operators: what the author expects is tried first."""
    for is_run in (True, False) if _is_run_likely(question) else (False, True):
        run = broken_by_one(question, admissible_points(question)) if is_run else None
        if run is not None:
            return _by_the_run(question, run)
        if not is_run and kept_by_all(question):
            return Answer(Proved(), "holds along every flowpipe", entry)
    return Answer(open_formula(question))


def _is_run_likely(question: Question) -> bool:
    """Whether the author expects that a run decides the goal."""
    is_reach = question.asked.kind == "can_reach"
    expected = question.claim.expect
    return is_reach if expected is None else (expected.verdict == "proved") == is_reach


def _may_be_recorded(question: Question) -> bool:
    """Whether the second checker may follow: it knows neither inputs nor assumptions, and needs a horizon."""
    model = question.model
    is_told = model.used or model.spec.assumptions or question.claim.assume
    is_plain = model.is_plain and not (
        is_told or question.asked.endless or question.asked.by_premise or any(fields(model, m)[1] for m in model.modes)
    )
    return is_plain and question.asked.kind in RECORDED


def _by_the_run(question: Question, run: Run) -> Answer:
    """The verdict that a run shows."""
    kind, shown = question.asked.kind, {"kind": "flow_run", "run": run_json(run)}
    piece = question.shown[0]
    until = question.asked.last if kind == "reach" else sum((s.dwell for s in run.steps), run.last)
    is_told = _may_be_recorded(question) and not question.hurried
    record = run_record(question, piece.start, piece.box, until) if is_told else None
    if kind == "can_reach":
        return Answer(Proved(), "a run reaches it", shown, run, record=record)
    return Answer(Refuted(), "never met" if kind == "reach" else "violated", shown, run, record=record)


def _start_json(question: Question, start: Start, point: Sequence[Q]) -> Json:
    """An admissible start."""
    model = question.model
    values = dict(zip([v.name for v in model.automaton.vars], point, strict=False))
    values |= dict(model.discrete(start.mode))
    return start_json(model.places[start.mode].mode, values, params_at(model, point))
