"""The rows of a replay's table: of claims, of enclosures, of samples, and what each earns."""

from __future__ import annotations

from fractions import Fraction

from haverify.report import exit_codes
from haverify.report import replay as facts
from haverify.report.report import Word
from haverify.robot import checks
from haverify.robot.mapping import Map
from haverify.robot.verdicts import Decided
from haverify.run.pipeline import Outcome

Q = Fraction


def claim_rows(outcome: Outcome) -> list[facts.Check]:
    """The claims as rows of the table."""
    rows = []
    for c in outcome.report.claims:
        margin = next((p.margin for p in c.parts if p.verdict == c.verdict and p.margin), c.margin)
        margin = c.margin or margin
        violated = [p for p in c.parts if p.verdict == "refuted"]
        where = violated[0].mode if violated else ""
        note = violated[0].facts[0] if violated and violated[0].facts else ""
        rows.append(
            facts.Check(
                name=c.name,
                what=note or "whole cycle, every param",
                basis="checked" if c.trust == "checked" else "enclosed",
                verdict=c.verdict,
                expected=c.expected,
                met=c.ok,
                advice=False,
                value=None,
                limit=None,
                margin=float(Q(margin.decimal)) if margin and not violated else None,
                unit=margin.unit if margin else "",
                time_s=None,
                mode=where,
                note=note,
            )
        )
    return rows


DECIDED = frozenset(  # by enclosures, under names that tell more
    ("swing sole above ground", "ground pushes", "friction cone", "zero moment point", "centre of mass over sole")
)
_BY_CLAIMS = frozenset(("joint position", "joint speed"))


def enclosed_row(c: Decided, m: Map) -> facts.Check:
    """What enclosures decide as a row."""
    expected: Word = "refuted" if c.name in m.expected else "proved"
    verdict: Word = "proved" if c.verdict == "proved" else "refuted" if c.verdict == "refuted" else "unknown"
    margin = c.high if verdict == "refuted" else c.low
    return facts.Check(
        name=c.name,
        what=c.what,
        basis="enclosed",
        verdict=verdict,
        expected=expected,
        met=verdict == expected,
        advice=False,
        value=None,
        limit=None,
        margin=_finite(margin),
        unit=c.unit,
        time_s=c.start,
        mode=c.mode,
        note=f"the least margin lies between {c.low:.6g} and {c.high:.6g} {c.unit}",
    )


def sampled_row(c: checks.Sampled, is_claimed: bool = True) -> facts.Check:
    """A sampled check as a row; `is_claimed` where claims decide the joints' own limits."""
    met = None if c.margin is None else bool(c.margin >= 0)
    return facts.Check(
        name=c.name,
        what=c.what,
        basis="sampled",
        verdict="unknown",
        expected=None,
        met=met,
        advice=c.advice or (is_claimed and c.name in _BY_CLAIMS),
        value=_finite(c.value),
        limit=c.limit,
        margin=_finite(c.margin),
        unit=c.unit,
        time_s=c.time,
        mode=c.mode,
        note=c.note,
    )


def _finite(x: float | None) -> float | None:
    return None if x is None or x != x or abs(x) == float("inf") else x


def code(c: facts.Check) -> int:
    """What a check earns; samples that break a limit leave it undecided, and of claims the report says it."""
    if c.basis == "enclosed" and c.time_s is not None:
        return exit_codes.OK if c.met else exit_codes.UNDECIDED if c.verdict == "unknown" else exit_codes.WRONG
    is_broken = c.basis == "sampled" and c.met is False and not c.advice
    return exit_codes.UNDECIDED if is_broken else exit_codes.OK
