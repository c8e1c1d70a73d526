"""`@allow(CODE, reason = "...")`: findings a spec accepts where they occur."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from haverify.diagnostics.codes import CATALOGUE, is_meaningless, pages
from haverify.diagnostics.diagnostic import Diagnostic, Edit, Fix
from haverify.model.spec import Allowed
from haverify.text.span import Span

_NEVER = ("HA7", "HA8")  # verdicts and bookkeeping are not findings about the model


def can_be_accepted(d: Diagnostic) -> bool:
    """Whether a reason can accept a finding: not where a part of the spec has no meaning, not for verdicts."""
    return not is_meaningless(d) and not d.code.startswith(_NEVER)


def covers(a: Allowed, d: Diagnostic) -> bool:
    """Whether `a` speaks of `d`: same code, and its place (for a cell of a data file: a label) inside the span."""
    if a.code != d.code or d.span is None:
        return False
    places = [d.span] if d.span.path == a.span.path else [label.span for label in d.labels]
    return any(_inside(place, a.span) for place in places)


def _inside(inner: Span, outer: Span) -> bool:
    return inner.path == outer.path and outer.start <= inner.start and inner.end <= outer.end


def allow(found: Iterable[Diagnostic], allowed: Sequence[Allowed]) -> dict[Diagnostic, str]:
    """The findings that an `@allow` with a reason accepts, each with that reason."""
    reasons = {}
    for d in found:
        reason = next((a.reason for a in allowed if a.reason and covers(a, d)), None)
        if reason and can_be_accepted(d):
            reasons[d] = reason
    return reasons


def about(allowed: Iterable[Allowed], found: Sequence[Diagnostic]) -> list[Diagnostic]:
    """HA802 for each `@allow` without a reason or a code, or that covers nothing although its code can be reported."""
    checked = set(pages())
    return [d for a in allowed if (d := _complaint(a, found, checked)) is not None]


def _complaint(a: Allowed, found: Sequence[Diagnostic], checked: set[str]) -> Diagnostic | None:
    if a.code not in CATALOGUE:
        return Diagnostic("HA802", f"@allow({a.code}): there is no such code", a.at, fix=_removal(a.at))
    if not a.reason:
        help_ = f'@allow({a.code}, reason = "why this is meant")'
        message = f'@allow({a.code}) needs reason = "..."; without one it accepts nothing'
        return Diagnostic("HA802", message, a.at, help=help_)
    covered = [d for d in found if covers(a, d)]
    if any(not can_be_accepted(d) for d in covered):
        message = f"@allow({a.code}): this error leaves a part without meaning; no reason accepts it"
        return Diagnostic("HA802", message, a.at)
    if not covered and a.code in checked:
        message = f"@allow({a.code}) accepts nothing: {a.code} does not occur here"
        return Diagnostic("HA802", message, a.at, fix=_removal(a.at))
    return None


def _removal(at: Span) -> Fix:
    return Fix("remove the attribute", (Edit(at, ""),), safe=True)
