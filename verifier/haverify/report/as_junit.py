"""`junit.xml`: a claim is a test case, and one that is not as expected is a failure, `unknown` included."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from haverify.report.exit_codes import MEANING, OK
from haverify.report.markup import clipped, escape
from haverify.report.report import Claim, Finding, Report
from haverify.report.terminal import details, with_unit
from haverify.text.record import record

_TEXT = 20_000  # characters of one failure
_FINDINGS = 100  # that one case tells of


@record
class _Case:
    """A test case; `fault` is `failure` or `error` with a type, a message and a text."""

    name: str
    group: str
    seconds: float
    fault: tuple[str, str, str, str] | None = None
    said: str = ""


def as_junit(reports: Sequence[Report], unread: Iterable[tuple[str, str]] = ()) -> str:
    """The text of `junit.xml`: a suite for each spec; `unread` are files that could not be read, and why.

    Where the exit code is not 0 and no claim accounts for it (findings, faults, interruptions, nothing checked), one
    more case of the suite does, so that no reader of the file alone takes it for a success.
    """
    suites = [_suite(r.spec, _cases(r), r.wall_s, _properties(r)) for r in reports]
    return _document(suites + [_suite(path, [_unread(path, message)]) for path, message in unread])


def findings_as_junit(specs: Iterable[tuple[str, list[Finding]]], unread: Iterable[tuple[str, str]] = ()) -> str:
    """Findings alone, for `lint`: an error that nobody accepted is a failure, and a spec without one a passed case."""
    suites = [_suite(spec, [_errors(spec, found) or _Case("findings", spec, 0.0)]) for spec, found in specs]
    return _document(suites + [_suite(path, [_unread(path, message)]) for path, message in unread])


def _unread(path: str, message: str) -> _Case:
    return _Case("read", path, 0.0, ("error", "unreadable", message, ""))


def _cases(r: Report) -> list[_Case]:
    cases = [_case(r, c) for c in r.claims]
    errors = _errors(r.spec, [f for f in r.findings if not f.code.startswith("HA7")])
    cases += [errors] if errors else []
    if r.summary.exit_code != OK and not any(c.fault for c in cases):
        cases.append(_Case("check", r.spec, 0.0, ("error", "check", MEANING.get(r.summary.exit_code, "failed"), "")))
    return cases


def _case(r: Report, c: Claim) -> _Case:
    margin = f"margin {with_unit(c.margin)}" if c.margin else ""
    said = "; ".join(
        text for text in (c.verdict, f"expected {c.expected}", f"trust {c.trust or 'none'}", margin) if text
    )
    fault = None
    if not c.ok:
        kind = c.verdict if c.verdict != c.expected else "changed"
        message = c.problems[0] if c.problems else c.reason or f"{c.verdict}, expected {c.expected}"
        fault = ("failure", kind, message, details(c))
    return _Case(c.name, f"{r.spec}.{c.automaton}" if c.automaton else r.spec, c.wall_s, fault, said)


def _errors(spec: str, found: list[Finding]) -> _Case | None:
    """The errors that nobody accepted as one case; None without any."""
    new = [f for f in found if f.severity == "error" and f.accepted is None]
    if not new:
        return None
    lines = [f"{f.path or spec}:{f.line or 1}:{f.column or 1}: error[{f.code}]: {f.message}" for f in new[:_FINDINGS]]
    lines += [f"... and {len(new) - _FINDINGS} more"] if len(new) > _FINDINGS else []
    plural = "s" if len(new) > 1 else ""
    message = f"{len(new)} new error finding{plural}: {', '.join(sorted({f.code for f in new}))}"
    return _Case("findings", spec, 0.0, ("failure", "findings", message, "\n".join(lines)))


def _properties(r: Report) -> dict[str, str]:
    return {"tool": f"{r.tool.name} {r.tool.version}", "hash": r.hash, "exit_code": str(r.summary.exit_code)}


def _document(suites: list[str]) -> str:
    return "\n".join(
        ['<?xml version="1.0" encoding="UTF-8"?>', '<testsuites name="haverify">', *suites, "</testsuites>\n"]
    )


def _suite(name: str, cases: list[_Case], seconds: float = 0.0, properties: dict[str, str] | None = None) -> str:
    kinds = [c.fault[0] for c in cases if c.fault]
    counts = f'tests="{len(cases)}" failures="{kinds.count("failure")}" errors="{kinds.count("error")}" skipped="0"'
    lines = [f' <testsuite name="{escape(name)}" {counts} time="{seconds:.3f}">']
    if properties:
        inner = [f'   <property name="{escape(k)}" value="{escape(v)}"/>' for k, v in properties.items()]
        lines += ["  <properties>", *inner, "  </properties>"]
    return "\n".join([*lines, *map(_testcase, cases), " </testsuite>"])


def _testcase(c: _Case) -> str:
    head = f'  <testcase name="{escape(c.name)}" classname="{escape(c.group)}" time="{c.seconds:.3f}"'
    inner = []
    if c.fault:
        tag, kind, message, text = c.fault
        told = escape(clipped(text, _TEXT))
        inner.append(f'   <{tag} type="{escape(kind)}" message="{escape(clipped(message, 500))}">{told}</{tag}>')
    inner += [f"   <system-out>{escape(c.said)}</system-out>"] if c.said else []
    return "\n".join([head + ">", *inner, "  </testcase>"]) if inner else head + "/>"
