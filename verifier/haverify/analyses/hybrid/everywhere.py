"""One start, other values chosen, from which a goal is violated along a flow for all values of some params."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from haverify.analyses.hybrid.inputs import choices
from haverify.analyses.hybrid.listing import listings
from haverify.analyses.hybrid.model import hybrid_model
from haverify.analyses.hybrid.question import Question, question_of
from haverify.analyses.hybrid.runs import certainly_admissible, violated_by_all
from haverify.evidence.certificate import certificate, run_json
from haverify.evidence.evidence import Evidence, PartResult
from haverify.evidence.verdict import Refuted
from haverify.model.claim import Claim
from haverify.model.hybrid import HybridAutomaton
from haverify.model.spec import Spec
from haverify.obligations.obligation import hashes
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import replace

Q = Fraction
METHOD = "taylor-reach"


def refuted_everywhere(spec: Spec, automaton: HybridAutomaton, claim: Claim, names: Sequence[str]) -> Evidence | None:
    """The refutation of a claim for all values of some params, from the middle of all else; None where it is none."""
    goals = [g.condition for g in claim.goals]
    if len(goals) != 1 or claim.using:
        return None
    try:
        question = question_of(hybrid_model(spec, automaton, goals, claim.assume), claim, claim.goals[0])
    except OutsideFragmentError:
        return None
    return _refuted(question, names) if question.asked.kind == "always" else None


def _refuted(question: Question, names: Sequence[str]) -> Evidence | None:
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
        found = violated_by_all(driven, start, box) if certainly_admissible(driven, start, box) else None
        if found is None:
            continue
        known = hashes(model.spec, model.automaton)
        where = model.places[start.mode].mode
        digest = known.part(known.goal(question.claim, question.claim.goals[0]), "flow", where, "")
        entry = {"kind": "flow_run", "run": run_json(found), "hash": digest}
        part = PartResult(0, "flow", where, "", "violated for all values", Refuted(), found)
        return Evidence(Refuted(), (part,), METHOD, certificate(question.claim.name, "refuted", [entry], None))
    return None
