"""`summary.md`: one screen, what is not as expected first."""

from __future__ import annotations

from haverify.report.exit_codes import MEANING
from haverify.report.markup import visible
from haverify.report.report import Claim, Report
from haverify.report.terminal import with_unit

_ROWS = 30


def as_markdown(report: Report) -> str:
    """The text of `summary.md`. It holds no times, so it is the same for the same facts."""
    s = report.summary
    lines = [f"# {_cell(report.title or report.spec)}", ""]
    if not report.complete:
        lines += ["**Incomplete: the run was interrupted.**", ""]
    lines += [
        f"{_cell(report.spec)}: {s.proved} proved, {s.refuted} refuted, {s.unknown} unknown; "
        f"{s.ok} of {len(report.claims)} as expected; {s.errors} errors, {s.warnings} warnings.",
        f"Exit code {s.exit_code}: {MEANING[s.exit_code]}.",
        "",
        "| claim | verdict | expected | trust | margin |",
        "|---|---|---|---|---|",
    ]
    ordered = sorted(report.claims, key=lambda c: c.ok)
    lines += [_row(c) for c in ordered[:_ROWS]]
    if len(ordered) > _ROWS:
        lines += ["", f"... and {len(ordered) - _ROWS} more in `report.json`."]
    lines += [
        "",
        f"Reproducibility hash `{report.hash}`; check the certificates with `haverify recheck` on this folder.",
    ]
    return "\n".join(lines) + "\n"


def _row(c: Claim) -> str:
    margin = with_unit(c.margin) if c.margin else ""
    verdict = c.verdict if c.ok else f"**{c.verdict}**"
    return f"| {_cell(c.name)} | {verdict} | {c.expected} | {c.trust or ''} | {_cell(margin)} |"


def _cell(text: str) -> str:
    """A text within a line or a cell of a table; what would be markup there is written as it reads."""
    plain = visible(" ".join(text.split()))
    for sign, written in (("&", "&amp;"), ("<", "&lt;"), ("|", "\\|"), ("`", "\\`")):
        plain = plain.replace(sign, written)
    return plain
