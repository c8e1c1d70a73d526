"""`replay.html`: a replay on one page with its pictures; it needs nothing else, neither scripts nor an address."""

from __future__ import annotations

from collections.abc import Sequence

from haverify.report.exit_codes import MEANING, OK, UNDECIDED
from haverify.report.html.element import Html, cell, element, joined, table
from haverify.report.html.style import page_css
from haverify.report.markup import clipped, escape
from haverify.report.replay import Check, Replay

_HEAD = ("check", "rests on", "verdict", "margin", "where")


def as_page(r: Replay, figures: Sequence[tuple[str, str]]) -> str:
    """The page; each figure has a caption and its SVG."""
    title = f"{r.source} on {r.robot}"
    kind = "good" if r.exit_code == OK else "open" if r.exit_code == UNDECIDED else "wrong"
    broken = [c for c in r.checks if c.met is False and not c.advice]
    text = f"{len(broken)} checks are not as expected" if broken else "Every check is as expected"
    meaning = element("small", f"exit code {r.exit_code}: {MEANING[r.exit_code]}")
    tiles = [(f"{r.mass_kg:.3f} kg", "mass"), (f"{r.cycle_s:.4g} s", "one cycle"), (str(r.samples), "instants sampled")]
    header = element(
        "header",
        element("h1", clipped(title, 200)),
        element("p", element("code", clipped(r.map, 300)), kind="soft"),
        element("p", text, meaning, kind=f"verdict {kind}"),
        element("ul", *[element("li", element("b", n), word) for n, word in tiles], kind="tiles"),
    )
    checks = element("section", element("h2", "Checks"), table(_HEAD, map(_row, r.checks), "checks"))
    notes = element("ul", *[element("li", note) for note in r.notes])
    link = element(
        "p", "The claims about the joints, with their certificates: ", element("a", "index.html", href="index.html")
    )
    drawn = [element("figure", element("figcaption", caption), Html(svg)) for caption, svg in figures]
    body = element("main", checks, notes, link if r.claims else "", element("h2", "Pictures"), *drawn)
    head = (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{escape(clipped(title, 200))}: haverify replay</title><style>{page_css()}</style></head>\n"
    )
    return f"{head}{element('body', header, body)}</html>\n"


def _row(c: Check) -> list[Html]:
    word = c.verdict if c.basis != "sampled" else "sampled"
    badge = element("span", word, kind=f"badge {word if c.basis != 'sampled' else 'plain'}")
    alert = element("span", "not as expected", kind="badge alert") if c.met is False and not c.advice else Html("")
    margin = f"{c.margin:.4g} {c.unit}" if c.margin is not None else ""
    if c.margin is None and c.value is not None:
        margin = f"(value {c.value:.4g} {c.unit})"
    when = f"{c.time_s:.4g} s, {c.mode}" if c.time_s is not None else c.mode
    basis = {"checked": "claim, hacheck", "enclosed": "enclosure, no certificate", "sampled": "samples"}[c.basis]
    name = joined([element("b", c.name), Html("<br>"), element("span", clipped(c.what, 160), kind="soft small")])
    where = when or "whole cycle"
    return [cell(name), cell(basis), cell(joined([badge, " ", alert])), cell(margin, kind="n"), cell(where, kind="n")]
