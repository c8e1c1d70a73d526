"""The baseline of a spec: accepted findings, and the violated parts of claims that are expected to be refuted."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from haverify.diagnostics.diagnostic import Diagnostic, Edit, Fix
from haverify.report.allow import can_be_accepted
from haverify.text.record import record
from haverify.text.source import Source
from haverify.text.span import Span

if TYPE_CHECKING:
    from datetime import date


@record
class FindingEntry:
    """An accepted finding of `spec`: `key` is its message or stands for it, `text` is what it marks. Lines may move."""

    spec: str
    code: str
    key: str
    text: str
    reason: str
    expires: date | None = None
    span: Span | None = None  # of the entry itself

    def identity(self) -> tuple[str, str, str]:
        """What a finding must have to be this one."""
        return (self.code, self.key, self.text)


@record
class RefutedEntry:
    """The parts in which a claim is known to be violated."""

    spec: str
    claim: str
    parts: tuple[str, ...]
    reason: str
    span: Span | None = None


@record
class Baseline:
    """The entries of one lock file; those of all its specs."""

    findings: tuple[FindingEntry, ...] = ()
    refuted: tuple[RefutedEntry, ...] = ()

    def of(self, spec: str) -> Baseline:
        """The entries of one spec."""
        return Baseline(
            tuple(e for e in self.findings if e.spec == spec), tuple(e for e in self.refuted if e.spec == spec)
        )

    def parts(self, claim: str) -> tuple[str, ...] | None:
        """The violated parts on record for a claim of the one spec these entries are about; None without an entry."""
        return next((e.parts for e in self.refuted if e.claim == claim), None)


def identity(d: Diagnostic, sources: Mapping[str, Source]) -> tuple[str, str, str]:
    """What identifies a finding when lines move: code, key, marked text."""
    text = sources[d.span.path].at(d.span) if d.span and d.span.path in sources else ""
    return (d.code, d.key or d.message, text)


def accept(
    found: Iterable[Diagnostic], entries: Iterable[FindingEntry], sources: Mapping[str, Source], today: date | None
) -> dict[Diagnostic, str]:
    """The findings on record, each with its reason. An entry accepts one finding and nothing after its last day."""
    left: dict[tuple[str, str, str], list[str]] = {}
    for entry in entries:
        if entry.reason and not _is_over(entry, today):
            left.setdefault(entry.identity(), []).append(entry.reason)
    accepted = {}
    for d in found:
        reasons = left.get(identity(d, sources))
        if reasons and can_be_accepted(d):
            accepted[d] = reasons.pop(0)
    return accepted


def stale(
    baseline: Baseline,
    found: Iterable[Diagnostic],
    expected_refuted: set[str],
    sources: Mapping[str, Source],
    today: date | None,
) -> list[Diagnostic]:
    """HA801 for each entry that is over or matches nothing any more."""
    there = Counter(identity(d, sources) for d in found)
    stale = []
    for entry in baseline.findings:
        if _is_over(entry, today):
            stale.append(_stale(entry.span, f"{entry.code} in {entry.spec} was accepted until {entry.expires}"))
        elif there[entry.identity()] == 0:
            stale.append(_stale(entry.span, f"{entry.code} in {entry.spec} no longer occurs; remove the entry"))
        there[entry.identity()] -= 1
    for claim in baseline.refuted:
        if claim.claim not in expected_refuted:
            message = f"no claim `{claim.claim}` with `expect refuted` in {claim.spec}; remove the entry"
            stale.append(_stale(claim.span, message))
    return stale


def _is_over(entry: FindingEntry, today: date | None) -> bool:
    return entry.expires is not None and today is not None and entry.expires < today


def _stale(span: Span | None, message: str) -> Diagnostic:
    fix = Fix("remove the entry", (Edit(span, ""),), safe=True) if span else None
    return Diagnostic("HA801", f"haverify.lock: {message}", span, fix=fix)
