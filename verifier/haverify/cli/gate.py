"""`haverify gate`: the exit code of a report, and what changed since another one."""

from __future__ import annotations

import argparse
import json
import re
from fractions import Fraction
from pathlib import Path

from haverify.cli.output import put
from haverify.errors import UsageError
from haverify.report.as_github import command, findings_as_github
from haverify.report.audit import contradictions, exit_code
from haverify.report.compare import Change, compare
from haverify.report.exit_codes import FAULT, INTERRUPTED, MEANING, WRONG, worst
from haverify.report.report import Claim, Finding, Report
from haverify.run.report_file import read_report

_SHOWN = 20  # contradictions of a report


def run(called: argparse.Namespace) -> int:
    """The exit code that the claims of a report earn; at least 1 where something is worse than in the baseline.

    Raises
    ------
    UsageError      if a report cannot be read, is incomplete or contradicts itself
    """
    most = _share(called.max_margin_loss)
    if most is not None and called.baseline is None:
        raise UsageError("--max-margin-loss compares with a report: name it with --baseline")
    new = _report(Path(called.report))
    changes = compare(_report(Path(called.baseline)), new, most) if called.baseline else []
    codes = [exit_code(new), *([new.summary.exit_code] if new.summary.exit_code == FAULT else [])]
    code = worst([*codes, *([WRONG] if any(c.is_worse for c in changes) else [])])
    put(_FORMS[called.format or "text"](new, changes, code))
    return code


def _report(path: Path) -> Report:
    """A report that is complete and does not contradict itself."""
    r = read_report(path)
    if not r.complete or r.summary.exit_code == INTERRUPTED:
        raise UsageError(f"{path}: the run was interrupted, so this report tells nothing of what it left out")
    found = contradictions(r)
    if found:
        lines = [f"  {text}" for text in found[:_SHOWN]]
        lines += [f"  ... and {len(found) - _SHOWN} more"] if len(found) > _SHOWN else []
        raise UsageError("\n".join([f"{path}: contradicts itself, so it is not believed:", *lines]))
    return r


def _share(text: str | None) -> Fraction | None:
    """`5%` or `0.05` as a share."""
    if text is None:
        return None
    m = re.fullmatch(r"\s*(\d{1,9}(?:\.\d{1,9})?)\s*(%?)\s*", text)
    if m is None:
        raise UsageError(f"--max-margin-loss '{text}': write a share such as 5% or 0.05")
    return Fraction(m[1]) / (100 if m[2] else 1)


def _missed(r: Report) -> list[tuple[Claim, str]]:
    """The claims that are not as expected, each with why."""
    return [(c, c.problems[0] if c.problems else c.reason or f"expected {c.expected}") for c in r.claims if not c.ok]


def _errors(r: Report) -> list[Finding]:
    """The error findings that nobody accepted, those aside that tell of claims."""
    return [f for f in r.findings if f.severity == "error" and f.accepted is None and not f.code.startswith("HA7")]


def _place(f: Finding) -> str:
    return f"{f.path}:{f.line}:{f.column}" if f.path and f.line else f.path or "-"


def _text(r: Report, changes: list[Change], code: int) -> str:
    lines = [f"{r.spec}: {len(r.claims)} claims, {sum(c.ok for c in r.claims)} as expected"]
    lines += [f"  !! {c.verdict:<7}  {c.name}: {_line(why)}" for c, why in _missed(r)]
    lines += [f"  !! {f.severity}[{f.code}]  {_place(f)}: {_line(f.message)}" for f in _errors(r)]
    for title, wanted in (("worse than the baseline", True), ("changed", False)):
        some = [c for c in changes if c.is_worse is wanted and c.kind != "cause"]
        lines += [f"{title}:", *(f"  {c.kind:<8} {c.name}: {_line(c.text)}" for c in some)] if some else []
    causes = [c for c in changes if c.kind == "cause"]
    lines += ["what differs:", *(f"  {c.name:<8} {_line(c.text)}" for c in causes)] if causes else []
    said = (
        "worse than the baseline"
        if code == WRONG and not _missed(r) and not _errors(r)
        else MEANING.get(code, "failed")
    )
    return "\n".join([*lines, f"exit code {code}: {said}"]) + "\n"


def _line(text: str) -> str:
    return " ".join(text.split())


def _json(r: Report, changes: list[Change], code: int) -> str:
    missed = [{"name": c.name, "verdict": c.verdict, "expected": c.expected, "why": why} for c, why in _missed(r)]
    errors = [{"code": f.code, "place": _place(f), "message": f.message} for f in _errors(r)]
    shown = [{"kind": c.kind, "name": c.name, "text": c.text, "worse": c.is_worse} for c in changes]
    whole = {
        "schema": "haverify.gate/1",
        "spec": r.spec,
        "missed": missed,
        "errors": errors,
        "changes": shown,
        "exit_code": code,
    }
    return json.dumps(whole, indent=1, sort_keys=True) + "\n"


def _github(r: Report, changes: list[Change], code: int) -> str:
    lines = [command("error", c.path or r.spec, c.line, c.verdict, f"{c.name}: {why}") for c, why in _missed(r)]
    lines.append(findings_as_github(_errors(r)))
    for c in changes:
        kind = "error" if c.is_worse else "notice"
        lines.append(command(kind, c.path or r.spec, c.line, f"gate: {c.kind}", f"{c.name}: {c.text}"))
    return "".join(lines)


_FORMS = {"text": _text, "json": _json, "github": _github}
