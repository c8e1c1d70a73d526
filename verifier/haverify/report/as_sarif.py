"""`report.sarif` (SARIF 2.1.0): findings, and claims that are not as expected, for code scanning and editors.

A run has a rule for each code it reports, with the manual page as its help. Accepted findings are suppressed with
their reason. Columns count Unicode code points, as everywhere in haverify.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Sequence
from typing import Any

from haverify.diagnostics.codes import CATALOGUE, Code, page, pages
from haverify.diagnostics.diagnostic import Severity
from haverify.report.exit_codes import FAULT, INTERRUPTED, MEANING, worst
from haverify.report.report import Claim, Finding, InputFile, Label, Report
from haverify.report.terminal import details
from haverify.report.version import VERSION

SCHEMA = "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json"

_LEVELS = {"error": "error", "warning": "warning"}
_SAFE = frozenset(b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._~/")
_UNDECIDED = Code("unknown", "claim undecided", Severity.ERROR, "", "", False)
_PAGE_OF_UNDECIDED = (
    "# unknown: a claim that was to be decided is not\n\nNeither a proof nor a counterexample was found within the "
    "limits. This is no success: the exit code is 3. The message says how far the proof got and what to try next."
)

Json = dict[str, Any]


def as_sarif(reports: Sequence[Report], unread: Iterable[tuple[str, str]] = ()) -> str:
    """The text of `report.sarif`: one run for all specs; `unread` are files that could not be read, and why."""
    results = [r for report in reports for r in _results(report)]
    inputs = [i for report in reports for i in report.inputs]
    said = [_unread(path, message) for path, message in unread]
    codes = [r.summary.exit_code for r in reports] + [2] * len(said)
    return _log(results, inputs, _invocation(worst(codes), said), {"hashes": {r.spec: r.hash for r in reports}})


def findings_as_sarif(found: Iterable[Finding], exit_code: int, unread: Iterable[tuple[str, str]] = ()) -> str:
    """Findings alone, for `lint`."""
    said = [_unread(path, message) for path, message in unread]
    return _log([_of_finding(f) for f in found], [], _invocation(exit_code, said), {})


def _log(results: list[Json], inputs: Iterable[InputFile], invocation: Json, properties: Json) -> str:
    """One run as text, its rules those that its results name, in order of their codes."""
    codes = sorted({str(r["ruleId"]) for r in results})
    for r in results:
        r["ruleIndex"] = codes.index(r["ruleId"])
    driver = {"name": "haverify", "version": VERSION, "semanticVersion": VERSION, "rules": [_rule(c) for c in codes]}
    files = {i.path: i.sha256 for i in inputs}
    run = {
        "tool": {"driver": driver},
        "columnKind": "unicodeCodePoints",
        "invocations": [invocation],
        "artifacts": [{"location": {"uri": _uri(path)}, "hashes": {"sha-256": h}} for path, h in files.items()],
        "results": results,
        "properties": properties,
    }
    log = {"$schema": SCHEMA, "version": "2.1.0", "runs": [run]}
    return json.dumps(log, sort_keys=True, separators=(",", ":")) + "\n"


def _rule(code: str) -> Json:
    entry = CATALOGUE.get(code, _UNDECIDED)
    manual = page(code) if code in pages() else _PAGE_OF_UNDECIDED if code == "unknown" else f"# {code}: {entry.name}"
    text = _first_paragraph(manual) or entry.name
    return {
        "id": code,
        "name": "".join(word.capitalize() for word in _words(entry.name)),
        "shortDescription": {"text": entry.name},
        "fullDescription": {"text": text},
        "help": {"text": manual, "markdown": manual},
        "defaultConfiguration": {"level": _LEVELS.get(entry.severity.value, "note")},
    }


def _words(name: str) -> list[str]:
    return "".join(c if c.isalnum() else " " for c in name).split()


def _first_paragraph(manual: str) -> str:
    blocks = [block for block in manual.split("\n\n") if block.strip() and not block.startswith("#")]
    return " ".join(blocks[0].split()) if blocks else ""


def _results(report: Report) -> list[Json]:
    told = {f.message.split(": ")[0] for f in report.findings if f.code.startswith("HA7")}
    known = {c.name for c in report.claims if c.ok}
    results = [_of_finding(f, _is_meant(f, known)) for f in report.findings]
    return results + [_of_claim(report, c) for c in report.claims if not c.ok and c.name not in told]


def _is_meant(f: Finding, known: set[str]) -> bool:
    """Whether a finding only explains a verdict that is as expected."""
    return f.severity == "verdict" and f.message.split(": ")[0] in known


def _of_finding(f: Finding, is_meant: bool = False) -> Json:
    level = _LEVELS.get(f.severity, "note")
    if f.severity == "verdict" and not is_meant:
        level = "error"
    text = "\n".join([f.message, *f.notes, *([f"help: {f.help}"] if f.help else [])])
    result: Json = {"ruleId": f.code, "level": level, "message": {"text": text}}
    if f.path:
        result["locations"] = [{"physicalLocation": _place(f.path, f.line, f.column, f.end_line, f.end_column)}]
    if f.fingerprint:
        result["partialFingerprints"] = {"haverify/v1": f.fingerprint}
    if f.labels:
        result["relatedLocations"] = [_related(k, label) for k, label in enumerate(f.labels)]
    if f.edits:
        result["fixes"] = [_fix(f)]
    if f.accepted is not None:
        kind = "inSource" if f.accepted_in == "source" else "external"
        result["suppressions"] = [{"kind": kind, "status": "accepted", "justification": f.accepted}]
    return result


def _of_claim(report: Report, c: Claim) -> Json:
    """A claim that is not as expected and of which no finding tells: one that is undecided."""
    place = _place(c.path or report.spec, c.line, 1, c.line, None)
    text = f"{c.name}: {c.verdict}, expected {c.expected}"
    text += f": {c.reason}" if c.reason else ""
    return {
        "ruleId": "unknown" if c.verdict == "unknown" else "HA701",
        "level": "error",
        "message": {"text": text, "markdown": f"```\n{details(c)[:5000]}\n```"},
        "locations": [{"physicalLocation": place}],
        "partialFingerprints": {"haverify/v1": f"claim/{c.name}/{c.verdict}"},
    }


def _place(path: str, line: int | None, column: int | None, end_line: int | None, end: int | None) -> Json:
    region = {"startLine": line, "startColumn": column, "endLine": end_line, "endColumn": end}
    known = {key: value for key, value in region.items() if value is not None}
    return {"artifactLocation": {"uri": _uri(path)}, **({"region": known} if line else {})}


def _at(label: Label) -> Json:
    return _place(label.path, label.line, label.column, label.end_line, label.end_column)


def _related(number: int, label: Label) -> Json:
    return {"id": number, "physicalLocation": _at(label), **({"message": {"text": label.text}} if label.text else {})}


def _fix(f: Finding) -> Json:
    """The fix as replacements, file by file."""
    paths = dict.fromkeys(e.path for e in f.edits)
    changes = [
        {
            "artifactLocation": {"uri": _uri(path)},
            "replacements": [
                {"deletedRegion": _at(e)["region"], "insertedContent": {"text": e.text}}
                for e in f.edits
                if e.path == path
            ],
        }
        for path in paths
    ]
    return {"description": {"text": f.fix or "as edited"}, "artifactChanges": changes}


def _invocation(exit_code: int, notifications: list[Json]) -> Json:
    told: Json = {"toolExecutionNotifications": notifications} if notifications else {}
    is_whole = exit_code not in (FAULT, INTERRUPTED) and not notifications
    return {
        "executionSuccessful": is_whole,
        "exitCode": exit_code,
        "exitCodeDescription": MEANING.get(exit_code, "failed"),
        **told,
    }


def _unread(path: str, message: str) -> Json:
    return {
        "level": "error",
        "message": {"text": message},
        "locations": [{"physicalLocation": {"artifactLocation": {"uri": _uri(path)}}}],
    }


def _uri(path: str) -> str:
    """A path as a URI reference: `/` between folders, everything but letters, digits and `-._~` escaped."""
    raw = os.fsencode(path.replace(os.sep, "/"))
    text = "".join(chr(b) if b in _SAFE else f"%{b:02X}" for b in raw)
    return f"file://{text}" if text.startswith("/") else text
