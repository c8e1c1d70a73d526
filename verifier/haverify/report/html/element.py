"""HTML put together from elements: plain text is escaped, only what was made here counts as markup."""

from __future__ import annotations

from collections.abc import Iterable

from haverify.report.markup import escape


class Html(str):
    """A text that is markup already."""

    __slots__ = ()


def element(name: str, *content: str, kind: str = "", **attributes: str) -> Html:
    """An element with its content; `kind`, its class, is a word of ours.

    >>> element("p", "a < b", element("b", "!"), kind="note")
    '<p class="note">a &lt; b<b>!</b></p>'
    """
    head = f' class="{kind}"' if kind else ""
    for key, value in attributes.items():
        head += f' {key}="{escape(value)}"'
    return Html(f"<{name}{head}>{joined(content)}</{name}>")


def joined(content: Iterable[str]) -> Html:
    """Pieces one after the other, plain text escaped."""
    return Html("".join([c if type(c) is Html else escape(c) for c in content if c]))


def table(head: Iterable[str], rows: Iterable[Iterable[Html]], kind: str) -> Html:
    """A table that scrolls by itself where the page is narrow; the rows are made of cells."""
    top = element("tr", *[element("th", h, scope="col") for h in head])
    body = [element("tr", *row) for row in rows]
    inner = element("table", element("thead", top), element("tbody", *body), kind=kind)
    return element("div", inner, kind="wide")


def cell(*content: str, kind: str = "") -> Html:
    """A cell of a table."""
    return element("td", *content, kind=kind)
