"""Verdicts against expectations, violated parts against those on record."""

from __future__ import annotations

import re
from fractions import Fraction
from math import prod
from operator import eq, ge, gt, le, lt

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.evidence.evidence import Evidence, PartResult
from haverify.evidence.verdict import Proved, Refuted, Unknown, Verdict
from haverify.model.claim import Claim
from haverify.report.exit_codes import OK, UNDECIDED, WRONG
from haverify.report.expected import margin_problem
from haverify.report.report import Word
from haverify.text.record import record

_WORDS: dict[type[Verdict], Word] = {Proved: "proved", Refuted: "refuted", Unknown: "unknown"}
_CODE_OF_UNKNOWN = {"inductive": "HA605", "budget": "HA702", "enclosure": "HA703", "window": "HA707", "jumps": "HA708"}


def word(verdict: Verdict) -> Word:
    """`proved`, `refuted` or `unknown`."""
    return _WORDS[type(verdict)]


@record
class Judgement:
    """How a verdict compares with what is expected: its exit code, what is wrong, and remarks that change nothing."""

    exit_code: int
    problems: tuple[Diagnostic, ...] = ()
    notes: tuple[str, ...] = ()


def expected(claim: Claim) -> str:
    """The verdict a claim expects: `proved` when it states none."""
    return claim.expect.verdict if claim.expect else "proved"


def part_name(claim: Claim, part: PartResult) -> str:
    """The name of a part in `haverify.lock`: automaton, mode or jump, output, and the goal where there are several."""
    goal = [f"goal {part.goal + 1}"] if len(claim.goals) > 1 else []
    return " / ".join([claim.on or "-", part.where or "-", part.output or "-", *goal])


def violated(claim: Claim, evidence: Evidence) -> tuple[str, ...]:
    """The names of the violated parts, in order."""
    return tuple(part_name(claim, p) for p in evidence.parts if isinstance(p.verdict, Refuted))


def judge(claim: Claim, evidence: Evidence, on_record: tuple[str, ...] | None) -> Judgement:
    """Compare the granted verdict of a claim with its `expect` line and with the violated parts on record."""
    got, wanted = word(evidence.verdict), expected(claim)
    if isinstance(evidence.verdict, Unknown):
        explanation = _unknown(claim, evidence.verdict)
        return Judgement(OK if wanted == "unknown" else UNDECIDED, explanation)
    if got != wanted:
        return Judgement(WRONG, (_problem(claim, _difference(claim, got)),))
    return _agree(claim, evidence, on_record)


def _agree(claim: Claim, evidence: Evidence, on_record: tuple[str, ...] | None) -> Judgement:
    messages = [text for text in (margin_problem(claim, evidence.verdict), _share_problem(claim, evidence)) if text]
    undecided: list[str] = []
    if isinstance(evidence.verdict, Refuted) and on_record is not None:
        messages += _new_causes(claim, evidence, on_record)
        undecided = _lost_causes(claim, evidence, on_record)
    code = WRONG if messages else UNDECIDED if undecided else OK
    return Judgement(code, tuple(_problem(claim, m) for m in messages), tuple(undecided))


def _new_causes(claim: Claim, evidence: Evidence, on_record: tuple[str, ...]) -> list[str]:
    """A known violation must not hide a new one, and one that is gone must be struck off."""
    now = violated(claim, evidence)
    still_open = {part_name(claim, p) for p in evidence.parts if isinstance(p.verdict, Unknown)}
    gone = [p for p in on_record if p not in now and p not in still_open]
    messages = [f"newly violated: {p}" for p in now if p not in on_record]
    return messages + [f"no longer violated: {p}; remove it from haverify.lock" for p in gone]


def _lost_causes(claim: Claim, evidence: Evidence, on_record: tuple[str, ...]) -> list[str]:
    still_open = {part_name(claim, p) for p in evidence.parts if isinstance(p.verdict, Unknown)}
    return [f"on record as violated, but undecided now: {p}" for p in on_record if p in still_open]


def _difference(claim: Claim, got: str) -> str:
    if claim.expect is None:
        return f'{got}, and nothing says that this is known; if it is: `expect {got} because "..."`'
    if got == "proved" and claim.expect.verdict == "refuted":
        return "expected refuted, got proved: remove the expectation or the fix"
    return f"expected {claim.expect.verdict}, got {got}"


_SIDE = re.compile(r"in \[(-?\d+(?:/\d+)?), (-?\d+(?:/\d+)?)\]")


def _share_problem(claim: Claim, evidence: Evidence) -> str | None:
    if claim.expect is None or claim.expect.share is None:
        return None
    share = proved_share(evidence)
    if share is None:
        return "expected a share of the parameter range, but this claim was not decided box by box"
    op, wanted = claim.expect.share
    holds = {"<": lt, "<=": le, ">": gt, ">=": ge, "==": eq}[op](share, wanted)
    return None if holds else f"expected a share {op} {wanted}, got {float(share):.6g}"


def proved_share(evidence: Evidence) -> Fraction | None:
    """The proved part of the volume that `for which` asks about (LANGUAGE S27); None for other claims."""
    pieces = [p for p in evidence.parts if p.kind == "piece"]
    whole, proved = Fraction(0), Fraction(0)
    for p in pieces:
        sides = [Fraction(b) - Fraction(a) for a, b in _SIDE.findall(p.where)]
        volume = prod((side for side in sides if side), start=Fraction(1))
        whole += volume
        proved += volume if isinstance(p.verdict, Proved) else 0
    return proved / whole if pieces else None


def _problem(claim: Claim, message: str) -> Diagnostic:
    span = claim.expect.span if claim.expect and claim.expect.span else claim.span
    return Diagnostic("HA701", f"{claim.name}: {message}", span, key=f"{claim.name}: {message}")


def _unknown(claim: Claim, verdict: Unknown) -> tuple[Diagnostic, ...]:
    code = _CODE_OF_UNKNOWN.get(verdict.kind)
    if code is None:
        return ()
    return (Diagnostic(code, f"{claim.name}: {verdict.reason}", claim.span, help=verdict.next_step or None),)
