"""Findings as the report and other programs read them."""

from __future__ import annotations

from collections.abc import Container, Mapping

from haverify.diagnostics.codes import CATALOGUE, severity
from haverify.diagnostics.diagnostic import Diagnostic
from haverify.diagnostics.render import places
from haverify.report.baseline import identity
from haverify.report.report import Finding, Label
from haverify.text.source import Source
from haverify.text.span import Span


def finding(
    d: Diagnostic, sources: Mapping[str, Source], accepted: str | None = None, in_source: Container[Diagnostic] = ()
) -> Finding:
    """A finding with its place in lines and columns.

    `accepted` is the reason that accepts it, found in the spec itself for those `in_source`, else in `haverify.lock`.
    """
    line = column = end_line = end_column = None
    if d.span and d.span.path in sources:
        line, column = sources[d.span.path].position(d.span.start)
        end_line, end_column = sources[d.span.path].position(d.span.end)
    return Finding(
        code=d.code,
        name=CATALOGUE[d.code].name,
        severity=severity(d).value,
        message=d.message,
        path=d.span.path if d.span else None,
        line=line,
        column=column,
        end_line=end_line,
        end_column=end_column,
        notes=list(d.notes),
        help=d.help,
        fix=d.fix.description if d.fix else None,
        accepted=accepted,
        accepted_in=None if accepted is None else "source" if d in in_source else "lock",
        fingerprint=_fingerprint(d, sources),
        excerpt=places(d, sources),
        labels=[label for at in d.labels for label in _label(at.span, at.text, sources)],
        edits=[edit for e in (d.fix.edits if d.fix else ()) for edit in _label(e.span, e.text, sources)],
    )


def _fingerprint(d: Diagnostic, sources: Mapping[str, Source]) -> str:
    """A hash of what identifies a finding in `haverify.lock`: the same when lines move."""
    from hashlib import sha256

    return sha256("\0".join(identity(d, sources)).encode("utf-8", "backslashreplace")).hexdigest()[:32]


def _label(span: Span, text: str, sources: Mapping[str, Source]) -> list[Label]:
    """A place with a text, where its file is known."""
    source = sources.get(span.path)
    return [Label(span.path, *source.position(span.start), *source.position(span.end), text)] if source else []
