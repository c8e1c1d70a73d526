"""From what an analysis proposes to what is granted: the only place where a verdict gets its trust."""

from __future__ import annotations

from typing import Literal

from haverify.evidence.evidence import Evidence, PartResult
from haverify.evidence.verdict import Proved, Refuted, Trust, Unknown, Verdict
from haverify.text.record import record, replace


@record
class Answer:
    """What `hacheck` says of a claim's certificate; `beyond`: its work budget or its kinds do not reach that far."""

    word: Literal["accepted", "refused", "beyond"]
    reason: str = ""


def grant(evidence: Evidence, answer: Answer | None, grade: Trust) -> Evidence:
    """The evidence with its verdict granted: CHECKED where `hacheck` accepted, else as its kind earns, else unknown.

    Proved and refuted need a certificate that was accepted, or one beyond the checker (ENCLOSED), or none at all but
    the word of a solver (SOLVER); below `grade` the verdict is `Unknown(grade)`. A refused certificate leaves nothing,
    and so does an invariant beyond the checker: what looked for it encloses nothing, it proposes.
    """
    if isinstance(evidence.verdict, Unknown):
        return evidence
    if answer is not None and answer.word == "refused":
        return _withdrawn(evidence, Unknown("refused", f"hacheck refused the certificate: {answer.reason}"))
    if answer is not None and answer.word == "beyond" and _is_by_invariant(evidence):
        return _withdrawn(
            evidence, Unknown("invariant", f"an invariant was found that is not checked: {answer.reason}")
        )
    trust = _trust(evidence, answer)
    if trust < grade:
        return _withdrawn(evidence, _below(trust, grade))
    parts = tuple(replace(p, verdict=_with_trust(p.verdict, trust)) for p in evidence.parts)
    notes = (f"not checked again: {answer.reason}",) if answer is not None and answer.word == "beyond" else ()
    verdict = _with_trust(evidence.verdict, trust)
    return replace(evidence, verdict=verdict, parts=parts, notes=(*evidence.notes, *notes))


def _is_by_invariant(evidence: Evidence) -> bool:
    """Whether a goal is shown by an invariant, which nobody but the checker looked at twice."""
    return any(entry.get("kind") in ("invariant", "unmet") for entry in (evidence.certificate or {}).get("goals", ()))


def _trust(evidence: Evidence, answer: Answer | None) -> Trust:
    if evidence.certificate is None or answer is None:
        return Trust.SOLVER
    return Trust.CHECKED if answer.word == "accepted" else Trust.ENCLOSED


def _below(trust: Trust, grade: Trust) -> Unknown:
    reason = f"decided, but the trust is only `{trust.name.lower()}` and `{grade.name.lower()}` is asked for"
    return Unknown("grade", reason, next_step=f"accept it by `--grade {trust.name.lower()}`")


def _with_trust(verdict: Verdict, trust: Trust) -> Verdict:
    return verdict if isinstance(verdict, Unknown) else replace(verdict, trust=trust)


def _withdrawn(evidence: Evidence, verdict: Unknown) -> Evidence:
    """Nothing of a proposal that was not granted is shown as decided."""
    parts = tuple(_undecided(p, verdict) for p in evidence.parts)
    return replace(evidence, verdict=verdict, parts=parts, certificate=None, run=None, rounding=None, flowpipe=None)


def _undecided(part: PartResult, verdict: Unknown) -> PartResult:
    if isinstance(part.verdict, Proved | Refuted):
        return replace(part, verdict=Unknown(verdict.kind, verdict.reason), run=None, facts=())
    return part
