"""The findings as cards: what is wrong, where, with the source and carets, and what helps."""

from __future__ import annotations

from collections.abc import Sequence

from haverify.report.html.claims import badge
from haverify.report.html.element import Html, element, joined
from haverify.report.html.prose import inline
from haverify.report.markup import clipped
from haverify.report.report import Finding

_MOST, _LINES, _TEXT = 60, 24, 600

_BADGES = {"error": "refuted", "warning": "unknown"}


def findings_section(title: str, found: Sequence[Finding]) -> Html:
    """Some findings under a title; nothing where there is none."""
    if not found:
        return Html("")
    blocks = [element("h2", title), *map(_card, found[:_MOST])]
    left = len(found) - _MOST
    more = f"{left} more findings are in report.json and report.sarif."
    return element("section", *blocks, *([element("p", more, kind="soft")] if left > 0 else []))


def _card(f: Finding) -> Html:
    kind = "accepted" if f.accepted is not None else f.severity
    place = f"{f.path}:{f.line}:{f.column}" if f.path and f.line else f.path or ""
    head = element(
        "h3",
        badge(f"{f.severity} {f.code}", _BADGES.get(f.severity, "plain")),
        element("span", inline(clipped(f.message, _TEXT))),
    )
    blocks = [head, element("p", clipped(place, 200), kind="soft small")] if place else [head]
    if f.excerpt:
        more = [f"... {len(f.excerpt) - _LINES} more lines"] if len(f.excerpt) > _LINES else []
        blocks.append(element("pre", "\n".join(clipped(line, 200) for line in [*f.excerpt[:_LINES], *more])))
    blocks += [element("p", inline(clipped(n, _TEXT)), kind="small") for n in f.notes[:8]]
    blocks += (
        [element("p", element("strong", "Help: "), inline(clipped(f.help, _TEXT)), kind="small")] if f.help else []
    )
    blocks += (
        [element("p", element("strong", "Accepted: "), clipped(f.accepted, _TEXT), kind="small")] if f.accepted else []
    )
    return joined([element("article", *blocks, kind=f"finding {kind}")])
