"""Reports, claims and findings of all kinds, to be seen in every format."""

from haverify.report import report

HOSTILE = "<script>alert(1)</script>\"'&\x00\x1b[31m\u202e|`*x*`]]>--\n\ttail"

LABEL = report.Label("spec/a b.ha", 3, 5, 3, 9, "said here")


def finding(**changes: object) -> report.Finding:
    values: dict[str, object] = {
        "code": "HA303", "name": "time-lock", "severity": "error", "message": "mode M is stuck", "path": "spec/a b.ha",
        "line": 3, "column": 5, "end_line": 3, "end_column": 9, "notes": ["at x = 1 s"], "help": "add an edge",
        "fix": None, "accepted": None, "fingerprint": "00ff",
        "excerpt": ["  --> spec/a b.ha:3:5", " 3 | mode M", "   | ^^^^"],
    }  # fmt: skip
    return report.Finding(**{**values, **changes})  # type: ignore[arg-type]


def part(verdict: str = "proved", **changes: object) -> report.Part:
    values: dict[str, object] = {
        "mode": "M", "output": "y", "kind": "dwell", "goal": 1, "text": "y in mode M", "verdict": verdict,
        "margin": margin("1" if verdict == "proved" else "-1"), "facts": [], "cells": [], "reason": None,
        "sensitivities": [],
    }  # fmt: skip
    return report.Part(**{**values, **changes})  # type: ignore[arg-type]


def margin(value: str | list[str], unit: str = "deg", at: str = "M, x = 1 s") -> report.Margin:
    return report.Margin(value, value if isinstance(value, str) else value[0], unit, at)


def claim(name: str = "low", verdict: str = "proved", **changes: object) -> report.Claim:
    """A claim that is decided as expected unless the changes say otherwise."""
    is_open = verdict == "unknown"
    values: dict[str, object] = {
        "name": name, "automaton": "A", "text": f"property {name} on A {{ always y <= 3 deg }}", "path": "spec/a b.ha",
        "line": 9, "doc": "", "verdict": verdict, "expected": verdict, "because": None, "ok": True,
        "trust": None if is_open else "checked", "parts": [] if is_open else [part(verdict)], "rounding": None,
        "method": "clocked", "margin": None if is_open else part(verdict).margin, "horizon": None, "assumptions": [],
        "using": [], "certificate": None if is_open else f"certificates/{name}.json", "run": None, "witness": None,
        "kind": "budget" if is_open else None, "reason": "stopped" if is_open else None, "reached": None,
        "nearest": None, "next_step": None, "problems": [], "notes": [], "wall_s": 0.25, "cpu_s": 0.25,
    }  # fmt: skip
    return report.Claim(**{**values, **changes})  # type: ignore[arg-type]


def wrong(name: str = "low", verdict: str = "refuted", expected: str = "proved") -> report.Claim:
    problems = [] if verdict == "unknown" else [f"expected {expected}, got {verdict}"]
    return claim(name, verdict, expected=expected, ok=False, problems=problems)


def whole(*claims: report.Claim, findings: list[report.Finding] | None = None, **changes: object) -> report.Report:
    """A report whose summary is what its claims and findings come to."""
    found = findings or []
    words = [c.verdict for c in claims]
    new = [f.severity for f in found if f.accepted is None]
    code = 1 if "error" in new or any(c.problems for c in claims) else 3 if not all(c.ok for c in claims) else 0
    counts = report.Summary(
        words.count("proved"), words.count("refuted"), words.count("unknown"), sum(c.ok for c in claims),
        new.count("error"), new.count("warning"), len(found) - len(new), code if claims or code else 5,
    )  # fmt: skip
    values: dict[str, object] = {
        "schema": "haverify.report/1", "spec": "spec/a b.ha", "title": "Example",
        "tool": report.Tool("haverify", "0.1.0", "k" * 64, {}), "inputs": [report.InputFile("spec/a b.ha", "ab" * 32)],
        "options": {"budget": "60 s", "grade": "enclosed", "property": ""}, "hash": "cd" * 32, "complete": True,
        "wall_s": 1.5, "cpu_s": 1.25, "findings": found, "claims": list(claims), "summary": counts,
    }  # fmt: skip
    return report.Report(**{**values, **changes})  # type: ignore[arg-type]


def hostile() -> report.Report:
    """A report that tries to break out of every format, wherever text can stand."""
    run = report.Run(
        [HOSTILE], [HOSTILE], ["0", "1"], ["0", HOSTILE], [{HOSTILE: "0"}, {HOSTILE: "1"}],
        [{HOSTILE: "0"}, {HOSTILE: HOSTILE}], {HOSTILE: "1"}, {HOSTILE: HOSTILE}, HOSTILE,
    )  # fmt: skip
    bad = part("refuted", mode=HOSTILE, output=HOSTILE, text=HOSTILE, facts=[HOSTILE], cells=[HOSTILE], reason=HOSTILE)
    refuted = claim(
        HOSTILE, "refuted", automaton=HOSTILE, text=HOSTILE, path=HOSTILE, doc=HOSTILE, expected="proved", ok=False,
        parts=[bad], margin=margin("-1", HOSTILE, HOSTILE), because=HOSTILE, problems=[HOSTILE], notes=[HOSTILE],
        assumptions=[HOSTILE], using=[HOSTILE], horizon=HOSTILE, method=HOSTILE, certificate=HOSTILE, run=run,
        witness={HOSTILE: HOSTILE},
    )  # fmt: skip
    undecided = wrong("open", "unknown")
    found = finding(
        message=HOSTILE, path=HOSTILE, notes=[HOSTILE], help=HOSTILE, fix=HOSTILE, accepted=HOSTILE,
        accepted_in="lock", excerpt=[HOSTILE], labels=[report.Label(HOSTILE, 1, 1, 1, 2, HOSTILE)],
        edits=[report.Label(HOSTILE, 1, 1, 1, 2, HOSTILE)],
    )  # fmt: skip
    return whole(refuted, undecided, findings=[found], title=HOSTILE, spec=HOSTILE)
