"""Proofs along flows checked by runs beside them, for at most a tenth of the time that the proof took."""

from __future__ import annotations

from haverify.evidence.evidence import Evidence
from haverify.evidence.verdict import Proved, Unknown
from haverify.model.claim import Claim
from haverify.model.spec import Spec
from haverify.run.executors import Solved
from haverify.text.record import replace

SHARE = 0.1  # of the time of the proof
LEAST = 0.2  # s; a proof that was quicker is not worth a simulator's start
METHODS = ("taylor", "induction")


def beside(spec: Spec, solved: Solved) -> Solved:
    """The evidence with what runs show against it: a fault where enclosures confirm it, else a note."""
    found, faults = dict(solved.evidence), list(solved.faults)
    for claim in spec.claims:
        evidence = found.get(claim.name)
        seconds = solved.seconds.get(claim.name, (0.0, 0.0))[1]
        if evidence is None or not _is_checked(evidence) or seconds < LEAST:
            continue
        shown = _shown(spec, claim, evidence, SHARE * seconds)
        if shown is None:
            continue
        text, is_certain = shown
        if is_certain:
            faults.append(f"{claim.name}: HA705 two engines disagree: {evidence.method}: proved; {text}")
            doubt = Unknown("internal", f"two engines disagree: {text}")
            found[claim.name] = replace(evidence, verdict=doubt, certificate=None, cells={})
        else:
            note = f"{text}; enclosures do not confirm it, and a run in floats is no judge of a proof"
            found[claim.name] = replace(evidence, notes=(*evidence.notes, note))
    return Solved(found, solved.seconds, faults, solved.is_interrupted)


def _is_checked(evidence: Evidence) -> bool:
    return isinstance(evidence.verdict, Proved) and evidence.method.startswith(METHODS)


def _shown(spec: Spec, claim: Claim, evidence: Evidence, seconds: float) -> tuple[str, bool] | None:
    """What runs show against a claim, and whether it is certain."""
    from haverify.obligations.translate import OutsideFragmentError
    from haverify.simulate.crosscheck import Beside

    if len(claim.goals) != 1:
        return None
    try:
        if any(s.name == claim.on for s in spec.systems):
            from haverify.analyses.networks.whole import whole_of
            from haverify.model.core import to_core

            left = (evidence.certificate or {}).get("whole")
            spec = whole_of(spec, claim.on or "", to_core(spec), left if isinstance(left, list) else None)
            claim = next(c for c in spec.claims if c.name == claim.name)
        automaton = next((a for a in spec.automata if a.name == claim.on), None)
        if automaton is None:
            return None
        found = Beside(spec, automaton, claim, evidence.flowpipe).disagreement(seconds)
    except OutsideFragmentError:
        return None
    return None if found is None else (found.text, found.is_certain)
