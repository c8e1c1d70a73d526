"""Findings as the report and other programs read them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from haverify.diagnostics.codes import CATALOGUE, severity
from haverify.diagnostics.diagnostic import Diagnostic
from haverify.report.report import Finding
from haverify.text.source import Source


def finding(d: Diagnostic, sources: Mapping[str, Source], accepted: str | None = None) -> Finding:
    """A finding with its place in lines and columns; `accepted` is the reason that accepts it."""
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
    )


_COMMANDS = {"error": "error", "warning": "warning"}


def github(findings: Iterable[Finding]) -> str:
    """The findings that nobody accepted as workflow commands, which GitHub shows beside the lines."""
    lines = []
    for f in findings:
        if f.accepted is None:
            place = {"file": f.path, "line": f.line, "endLine": f.end_line, "col": f.column, "endColumn": f.end_column}
            shown = {key: str(value) for key, value in place.items() if value is not None} | {"title": f.code}
            properties = ",".join(f"{key}={_escape(value, ':,')}" for key, value in shown.items())
            lines.append(f"::{_COMMANDS.get(f.severity, 'notice')} {properties}::{_escape(f.message)}\n")
    return "".join(lines)


def _escape(text: str, more: str = "") -> str:
    for c in "%\r\n" + more:
        text = text.replace(c, f"%{ord(c):02X}")
    return text
