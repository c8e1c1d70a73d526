"""A report's own summary held against its claims: what was edited by hand or cut short is not believed."""

from __future__ import annotations

from haverify.diagnostics.codes import CATALOGUE
from haverify.report.exit_codes import FAULT, INTERRUPTED, NOTHING, OK, UNDECIDED, UNREADABLE, WRONG, worst
from haverify.report.numbers import ends
from haverify.report.report import Claim, Finding, Report


def exit_code(r: Report) -> int:
    """The exit code that the claims and findings of a report earn, whatever its summary says."""
    return worst([*([_of_claim(c) for c in r.claims] or [NOTHING]), *map(_of_finding, r.findings)])


def contradictions(r: Report) -> list[str]:
    """Where a report contradicts itself; a fault or an interruption is only in its summary."""
    s = r.summary
    found = [f"claim {c.name} {text}" for c in r.claims for text in _of_verdict(c)]
    if len({c.name for c in r.claims}) < len(r.claims):
        found.append("two claims have one name")
    counted = [sum(c.verdict == word for c in r.claims) for word in ("proved", "refuted", "unknown")]
    if counted != [s.proved, s.refuted, s.unknown]:
        told = f"{s.proved} proved, {s.refuted} refuted, {s.unknown} unknown"
        found.append(f"the summary counts {told}, there are {', '.join(map(str, counted))}")
    if s.ok != sum(c.ok for c in r.claims):
        found.append(f"the summary counts {s.ok} claims as expected, {sum(c.ok for c in r.claims)} say so")
    new = [sum(f.severity == word and f.accepted is None for f in r.findings) for word in ("error", "warning")]
    if new != [s.errors, s.warnings]:
        found.append(f"the summary counts {s.errors} errors and {s.warnings} warnings, there are {new[0]} and {new[1]}")
    earned = exit_code(r)
    if s.exit_code != earned and s.exit_code not in (FAULT, INTERRUPTED):
        found.append(f"its summary says exit code {s.exit_code}, its claims and findings come to {earned}")
    return found


def _of_verdict(c: Claim) -> list[str]:
    """What cannot be of one claim."""
    found = []
    if c.ok and c.verdict != c.expected:
        found.append(f"is {c.verdict} where {c.expected} is expected, and passes as expected")
    if c.ok and c.problems:
        found.append("has problems and passes as expected")
    if c.verdict != "unknown" and c.trust is None:
        found.append(f"is {c.verdict} and says nothing of its trust")
    if c.trust == "checked" and c.certificate is None:
        found.append("is checked and has no certificate")
    return found + ([] if c.margin is None or ends(c.margin) else ["has a margin that is no number"])


def _of_claim(c: Claim) -> int:
    """What a claim comes to: one that is not as expected is wrong if a verdict says so, else undecided."""
    if c.ok:
        return OK
    return WRONG if c.problems else UNDECIDED


def _of_finding(f: Finding) -> int:
    if f.severity != "error" or f.accepted is not None:
        return OK
    code = CATALOGUE.get(f.code)
    return UNREADABLE if code is None or code.is_meaningless else WRONG
