"""Doc comments as HTML: paragraphs, lists, code, emphasis; links stay text, and HTML within is shown as it stands."""

from __future__ import annotations

import re
from collections.abc import Iterator

from haverify.report.html.element import Html, element, joined
from haverify.report.markup import clipped

_MOST = 6000
_INLINE = re.compile(r"`([^`\n]{1,500})`|\*\*([^*\n]{1,500})\*\*|(?<![\w*])\*([^*\s][^*\n]{0,500})\*(?![\w*])")
_ITEM = re.compile(r"\s{0,3}[-*] +(.*)")


def prose(text: str) -> Html:
    """The text of a doc comment."""
    return joined(_blocks(clipped(text, _MOST).splitlines()))


def _blocks(lines: list[str]) -> Iterator[Html]:
    at = 0
    while at < len(lines):
        end = at + 1
        if lines[at].strip().startswith("```"):
            while end < len(lines) and not lines[end].strip().startswith("```"):
                end += 1
            yield element("pre", "\n".join(lines[at + 1 : end]))
            end += 1
        elif lines[at].strip():
            while end < len(lines) and lines[end].strip() and not lines[end].strip().startswith("```"):
                end += 1
            yield from _paragraph(lines[at:end])
        at = end


def _paragraph(lines: list[str]) -> Iterator[Html]:
    """A paragraph; from the first line on that is an item, a list."""
    first = next((k for k, line in enumerate(lines) if _ITEM.fullmatch(line)), len(lines))
    if first:
        yield element("p", inline(" ".join(line.strip().lstrip("#").strip() for line in lines[:first])))
    items: list[str] = []
    for line in lines[first:]:
        m = _ITEM.fullmatch(line)
        if m:
            items.append(m[1])
        else:
            items[-1] += f" {line.strip()}"
    if items:
        yield element("ul", *[element("li", inline(item)) for item in items])


def inline(text: str) -> Html:
    """A line with its code and emphasis."""
    pieces, at = list[str](), 0
    for m in _INLINE.finditer(text):
        code, strong, soft = m.groups()
        inner = element("code", code) if code else element("strong", strong) if strong else element("em", soft)
        pieces += [text[at : m.start()], inner]
        at = m.end()
    return joined([*pieces, text[at:]])
