"""One start, other values chosen, from which a goal is violated along a flow for all values of some params."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from haverify.analyses.hybrid.inputs import choices
from haverify.analyses.hybrid.listing import listings
from haverify.analyses.hybrid.model import hybrid_model
from haverify.analyses.hybrid.question import Question, question_of
from haverify.analyses.hybrid.runs import certainly_admissible, never_met_by_all, violated_by_all
from haverify.evidence.certificate import certificate, run_json
from haverify.evidence.evidence import Evidence, PartResult
from haverify.evidence.run import Run
from haverify.evidence.verdict import Refuted
from haverify.model.claim import Claim
from haverify.model.hybrid import HybridAutomaton
from haverify.model.spec import Spec
from haverify.obligations.obligation import hashes
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import replace

Q = Fraction
Json = Any
METHOD = "taylor-reach"
WAYS = {
    "always": (violated_by_all, "violated for all values"),
    "reach": (never_met_by_all, "never met for all values"),
}


def refuted_everywhere(spec: Spec, automaton: HybridAutomaton, claim: Claim, names: Sequence[str]) -> Evidence | None:
    """The refutation of a claim for all values of some params, from the middle of all else; None where it is none.

    One of its goals is violated for all of them: at an instant, or by never being met.
    """
    if claim.using:
        return None
    conditions = [g.condition for g in claim.goals]
    try:
        model = hybrid_model(spec, automaton, conditions, claim.assume)
        questions = [question_of(model, claim, g) for g in claim.goals]
    except OutsideFragmentError:
        return None
    asked = (_refuted(q, k, names) for k, q in enumerate(questions) if q.asked.kind in WAYS)
    return next((found for found in asked if found is not None), None)


def _refuted(question: Question, number: int, names: Sequence[str]) -> Evidence | None:
    model = question.model
    chosen = next(choices(model), None)
    if chosen is None:
        return None
    modes = listings(model, question.judged, chosen=chosen) if chosen else question.modes
    driven = replace(question, modes=modes, driven=chosen)
    for start in model.starts:
        box = tuple(
            ends if n in names else ((ends[0] + ends[1]) / 2,) * 2
            for n, ends in zip(model.names, start.box, strict=True)
        )
        way, text = WAYS[question.asked.kind]
        found = way(driven, start, box) if certainly_admissible(driven, start, box) else None
        if found is not None:
            return _told(question, number, model.places[start.mode].mode, found, text)
    return None


def _told(question: Question, number: int, mode: str, run: Run, text: str) -> Evidence:
    claim = question.claim
    known = hashes(question.model.spec, question.model.automaton)
    digest = known.part(known.goal(claim, claim.goals[number]), "flow", mode, "")
    entries: list[Json] = [{} for _ in claim.goals]
    entries[number] = {"kind": "flow_run", "run": run_json(run), "hash": digest}
    part = PartResult(number, "flow", mode, "", text, Refuted(), run)
    return Evidence(Refuted(), (part,), METHOD, certificate(claim.name, "refuted", entries, None))
