"""`index.html`: the whole report on one page that needs nothing else, neither scripts nor another address.

The page stays under a megabyte: what does not fit is left out and said, claims that are not as expected go in first.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial

from haverify.report.exit_codes import MEANING, OK, UNDECIDED
from haverify.report.figures import plots
from haverify.report.figures.material import Figure, Material
from haverify.report.figures.of_claims import of_claim
from haverify.report.html import times
from haverify.report.html.claims import badge, claim_section, figure
from haverify.report.html.element import Html, cell, element, joined, table
from haverify.report.html.findings import findings_section
from haverify.report.html.prose import inline
from haverify.report.html.style import page_css
from haverify.report.markup import clipped, escape
from haverify.report.report import Claim, Report
from haverify.report.terminal import with_unit

_CLAIMS = 860_000  # bytes of the page up to which claims are told of in full
_FIGURES = 600_000  # and up to which they have figures
_FULL = 850_000  # from here on nothing more is tried
_INPUTS = 60

_ROUNDING = {"proved": "holds", "refuted": "violated", "unknown": "unknown"}


def as_html(report: Report, material: Material) -> str:
    """The text of `index.html`."""
    anchors = {c.name: f"claim-{k}" for k, c in enumerate(report.claims, 1)}
    figures = material.drawn_once("model", lambda: plots.of_model(material))
    told = [f for f in report.findings if not (f.code.startswith("HA7") and f.message.split(": ")[0] in anchors)]
    new, accepted = ([f for f in told if (f.accepted is None) is b] for b in (True, False))
    top = [_header(report), _verdicts(report, anchors), findings_section("Findings", new)]
    end = [findings_section("Accepted findings", accepted), _model(figures), _repeat(report)]
    used = sum(len(part.encode("utf-8", "replace")) for part in (*top, *end))
    middle = _claims(report, anchors, material, used)
    title = escape(clipped(report.title or report.spec, 200))
    head = (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f'<meta name="generator" content="haverify {report.tool.version}"><title>{title}: haverify report</title>'
        f"<style>{page_css()}</style></head>\n"
    )
    body = element("body", top[0], element("main", *top[1:], middle, *end), _footer(report))
    return f"{head}{body}</html>\n"


def _header(r: Report) -> Html:
    s = r.summary
    wrong = [c for c in r.claims if not c.ok]
    kind = "good" if s.exit_code == OK else "open" if s.exit_code == UNDECIDED else "wrong"
    text = f"All {len(r.claims)} claims are as expected" if r.claims else "No claim was decided"
    if wrong:
        text = f"{len(wrong)} of {len(r.claims)} claims {'is' if len(wrong) == 1 else 'are'} not as expected"
    if s.errors and not wrong:
        text += f"; {s.errors} error finding{'s are' if s.errors > 1 else ' is'} new"
    text = text if r.complete else f"Incomplete: the run was interrupted. {text}"
    meaning = element("small", f"exit code {s.exit_code}: {MEANING.get(s.exit_code, 'failed')}")
    checked = sum(c.trust == "checked" for c in r.claims)
    tiles = [(s.proved, "proved"), (s.refuted, "refuted"), (s.unknown, "unknown"), (checked, "re-checked")]
    tiles += [(s.errors, "errors"), (s.warnings, "warnings"), (s.accepted, "accepted findings")]
    return element(
        "header",
        element("h1", clipped(r.title or r.spec, 200)),
        element("p", element("code", clipped(r.spec, 300)), f" \N{MIDDLE DOT} haverify {r.tool.version}", kind="soft"),
        element("p", text, meaning, kind=f"verdict {kind}"),
        element("ul", *[element("li", element("b", str(n)), word) for n, word in tiles], kind="tiles"),
    )


def _verdicts(r: Report, anchors: Mapping[str, str]) -> Html:
    """The table of claims, those first that are not as expected."""
    if not r.claims:
        return Html("")
    has_rounding = any(c.rounding for c in r.claims)
    remark = "margin" if any(c.margin for c in r.claims) else "remark"
    head = ["claim", "verdict", "expected", remark, *(["rounding"] if has_rounding else []), "trust", "time"]
    rows = [_row(c, anchors, has_rounding) for c in times.in_table(r)]
    blocks = [element("h2", "Claims"), table(head, rows, "claims")]
    left = len(r.claims) - len(rows)
    blocks += [element("p", f"{left} more claims are in report.json.", kind="soft")] if left else []
    return element("section", *blocks)


def _row(c: Claim, anchors: Mapping[str, str], has_rounding: bool) -> list[Html]:
    expected = badge(c.expected, "plain") if c.ok else badge(f"expected {c.expected}", "alert")
    name = element("a", clipped(c.name, 120), href=f"#{anchors[c.name]}")
    known = "known" if c.ok and c.verdict != "proved" else ""
    cells = [cell(name, kind="text"), cell(badge(c.verdict, f"{c.verdict} {known}".strip()))]
    cells.append(cell(expected, kind="wanted" if c.ok else ""))
    at = element("span", f" at {c.margin.at}", kind="soft small") if c.margin and c.margin.at else Html("")
    remark = (c.because if c.ok else next(iter(c.problems), c.reason)) or ""
    why = element("div", inline(clipped(remark, 160)), kind="soft small") if remark else Html("")
    cells.append(cell(with_unit(c.margin) if c.margin else "", at, why, kind="room"))
    cells += [cell(_ROUNDING[c.rounding.verdict] if c.rounding else "", kind="n rounding")] if has_rounding else []
    return [*cells, cell(c.trust or "", kind="n"), cell(times.of_claim(c), kind="time")]


def _model(figures: Sequence[Figure]) -> Html:
    if not figures:
        return Html("")
    return element("section", element("h2", "Model"), *map(figure, figures), id="model")


def _claims(r: Report, anchors: Mapping[str, str], material: Material, used: int) -> Html:
    """The sections of the claims in order, as many as fit; those not as expected are the last to be left out."""
    kept: dict[str, Html] = {}
    for c in sorted(r.claims, key=lambda c: c.ok):
        if used > _FULL:
            break
        drawn = material.drawn_once(f"claim {c.name}", partial(of_claim, material, c)) if used < _FIGURES else []
        section = claim_section(c, anchors[c.name], drawn, _command(r, c))
        size = len(section.encode("utf-8", "replace"))
        if used + size <= _CLAIMS:
            kept[c.name] = section
            used += size
    left = len(r.claims) - len(kept)
    said = f"{left} claims are left out to keep this page small; all are in report.json and summary.md."
    blocks = [kept[c.name] for c in r.claims if c.name in kept]
    blocks += [element("p", said, kind="soft")] if left else []
    return element("section", element("h2", "Claim by claim"), *blocks) if blocks else Html("")


def _command(r: Report, c: Claim) -> str:
    return f"haverify check {quoted(r.spec)} -p {quoted(c.name)}"


def quoted(text: str) -> str:
    """A word of a command line as a POSIX shell reads it back."""
    is_plain = text and all(ch.isalnum() or ch in "._/-+=:@%," for ch in text) and not text.startswith("-")
    return text if is_plain else "'" + text.replace("'", "'\\''") + "'"


def _repeat(r: Report) -> Html:
    options = [f"--budget {r.options['budget'].replace(' ', '')}"] if r.options.get("budget") else []
    options += [f"--grade {r.options['grade']}"] if r.options.get("grade") else []
    options += [f"-p {quoted(r.options['property'])}"] if r.options.get("property") else []
    lines = [f"haverify check {quoted(r.spec)} {' '.join(options)}", "haverify recheck .    # in this folder's place"]
    rows = [[cell(element("code", clipped(i.path, 200))), cell(element("code", i.sha256))] for i in r.inputs[:_INPUTS]]
    left = len(r.inputs) - len(rows)
    blocks = [
        element("h2", "To repeat"),
        element("pre", "\n".join(lines)),
        element("p", "Reproducibility hash ", element("code", r.hash), ": same hash, same verdicts."),
        table(["input", "SHA-256"], rows, "inputs"),
    ]
    blocks += [element("p", f"{left} more inputs are in report.json.", kind="soft")] if left else []
    return element("section", *blocks)


def _footer(r: Report) -> Html:
    took = element("b", times.of_report(r), kind="time")
    said = "A margin is the signed distance to the bound, in its unit; times are wall-clock times of the engines. "
    more = "Exact numbers are in report.json, certificates beside it. Figures illustrate; nothing rests on them. Took "
    return joined([element("footer", said, more, took, ".")])
