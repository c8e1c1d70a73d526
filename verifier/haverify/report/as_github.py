"""Workflow commands, which GitHub shows as annotations beside the lines they are about."""

from __future__ import annotations

from collections.abc import Iterable

from haverify.report.report import Claim, Finding, Report

_COMMANDS = {"error": "error", "warning": "warning"}


def as_github(report: Report) -> str:
    """The new errors and warnings, and each claim that is not as expected."""
    shown = [f for f in report.findings if f.severity in _COMMANDS or (f.severity == "verdict" and _counts(report, f))]
    told = {f.message.split(": ")[0] for f in shown if f.code.startswith("HA7")}
    silent = [c for c in report.claims if not c.ok and c.name not in told]
    return findings_as_github(shown) + "".join(_claim(report, c) for c in silent)


def _counts(report: Report, f: Finding) -> bool:
    """Whether a finding explains the verdict of a claim that is not as expected."""
    return f.message.split(": ")[0] in {c.name for c in report.claims if not c.ok}


def findings_as_github(findings: Iterable[Finding]) -> str:
    """The findings that nobody accepted."""
    return "".join(_finding(f) for f in findings if f.accepted is None)


def command(kind: str, path: str | None, line: int | None, title: str, message: str) -> str:
    """One annotation: `kind` is error, warning or notice."""
    return _command(kind, {"file": path, "line": line, "title": title}, message)


def _finding(f: Finding) -> str:
    place = {"file": f.path, "line": f.line, "endLine": f.end_line, "col": f.column, "endColumn": f.end_column}
    kind = "error" if f.severity == "verdict" else _COMMANDS.get(f.severity, "notice")
    return _command(kind, {**place, "title": f.code}, f.message)


def _claim(report: Report, c: Claim) -> str:
    reason = " ".join((c.reason or f"{c.verdict}, expected {c.expected}").split())
    return command("error", c.path or report.spec, c.line or 1, c.verdict, f"{c.name}: {reason}")


def _command(kind: str, properties: dict[str, str | int | None], message: str) -> str:
    known = {key: _escape(str(value), ":,") for key, value in properties.items() if value is not None}
    return f"::{kind} {','.join(f'{key}={value}' for key, value in known.items())}::{_escape(message)}\n"


def _escape(text: str, more: str = "") -> str:
    for c in "%\r\n" + more:
        text = text.replace(c, f"%{ord(c):02X}")
    return text
