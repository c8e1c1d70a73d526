"""The rows of a replay's table: of claims, of enclosures, of samples, and what each earns."""

from __future__ import annotations

import re
from collections.abc import Mapping
from fractions import Fraction

from haverify.report import exit_codes
from haverify.report import replay as facts
from haverify.report.report import Word
from haverify.robot import checks
from haverify.robot.cycle import Cycle
from haverify.robot.mapping import Map
from haverify.robot.slack import Slack
from haverify.robot.verdicts import Decided
from haverify.run.pipeline import Outcome

Q = Fraction


def claim_rows(outcome: Outcome, cycle: Cycle, slacks: Mapping[str, Slack]) -> list[facts.Check]:
    """The claims as rows of the table, each with its margin and where that is."""
    rows = []
    for c in outcome.report.claims:
        slack = slacks.get(c.name)
        violated = [p for p in c.parts if p.verdict == "refuted"]
        where = slack.mode if slack else violated[0].mode if violated else ""
        note = _own(violated[0].facts[0], cycle) if violated and violated[0].facts else ""
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
                margin=float(slack.margin) if slack else None,
                unit=slack.unit if slack else "",
                time_s=float(slack.time) if slack else None,
                mode=where,
                note=note,
            )
        )
    return rows


def _own(text: str, cycle: Cycle) -> str:
    """What is said of the claims, with params called as in the gait's own spec, which the claims import as `gait`."""
    return re.sub(rf"\bgait_({'|'.join(map(re.escape, cycle.params))})\b", r"\1", text) if cycle.params else text


DECIDED = frozenset(  # by enclosures, under names that tell more
    ("swing sole above ground", "ground pushes", "friction cone", "zero moment point", "centre of mass over sole")
)
_PLACEHOLDERS = frozenset(("joint torques",))  # checks whose limits are advice where the robot says so
_BY_CLAIMS = frozenset(("joint position", "joint speed"))


def enclosed_row(c: Decided, m: Map, cycle: Cycle, are_placeholders: bool) -> facts.Check:
    """What enclosures decide as a row; limits of torque may be placeholders."""
    expected: Word = "refuted" if c.name in m.expected else "proved"
    verdict: Word = "proved" if c.verdict == "proved" else "refuted" if c.verdict == "refuted" else "unknown"
    margin = c.high if verdict == "refuted" else c.low
    return facts.Check(
        name=c.name,
        what=f"{c.what}{_coverage(c, cycle)}",
        basis="enclosed",
        verdict=verdict,
        expected=expected,
        met=verdict == expected,
        advice=are_placeholders and c.name in _PLACEHOLDERS,
        value=None,
        limit=None,
        margin=_finite(margin),
        unit=c.unit,
        time_s=c.start,
        mode=c.mode,
        note=f"the least margin lies between {c.low:.6g} and {c.high:.6g} {c.unit}{_worst(c, cycle)}",
    )


def _coverage(c: Decided, cycle: Cycle) -> str:
    """For which values of the params it is proved, where these are not all."""
    if c.verdict == "proved":
        return "" if cycle.steady else ", for the params' defaults alone"
    kept = []
    if c.holds is not None and not cycle.box:
        low, high = (_pace(p, cycle) for p in c.holds)
        kept.append(f"{cycle.pacer or 'the pace'} in [{low:g}, {high:g}]")
    kept += [" and ".join(f"{n} in [{float(a):g}, {float(b):g}]" for n, (a, b) in box.items()) for box in c.boxes]
    return f"; proved for {', '.join(kept)}" if kept else ""


def _worst(c: Decided, cycle: Cycle) -> str:
    return "" if c.pace == 1 else f", at {cycle.pacer or 'the pace'} = {_pace(c.pace, cycle):g}"


def _pace(p: Q, cycle: Cycle) -> float:
    """A pace as a value of the param that makes it, else as a multiple of the gait's."""
    return float(p * cycle.params[cycle.pacer]) if cycle.pacer else float(p)


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
    """What a check that is no claim earns: samples that break a limit leave it undecided, advice decides nothing."""
    if c.basis == "enclosed" and not c.advice:
        return exit_codes.OK if c.met else exit_codes.UNDECIDED if c.verdict == "unknown" else exit_codes.WRONG
    is_broken = c.basis == "sampled" and c.met is False and not c.advice
    return exit_codes.UNDECIDED if is_broken else exit_codes.OK
