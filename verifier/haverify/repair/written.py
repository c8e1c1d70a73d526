"""Changes in the text of a spec: slips in its numbers, signs between terms, strict bounds, bits of codes."""

from __future__ import annotations

import re
from collections.abc import Iterator

from haverify.diagnostics.diagnostic import Edit
from haverify.repair.change import Change
from haverify.repair.slips import slips
from haverify.text.source import Source
from haverify.text.span import Span

_TOKEN = re.compile(
    r"(?P<skip>//[^\n]*|\"[^\"\n]*\")"
    r"|(?P<code>0b[01]+)"
    r"|(?P<word>[A-Za-z_]\w*'?)"
    r"|(?P<number>\d+(?:\.\d+)?(?:[eE][+-]?\d+)?)"
    r"|(?P<arrow><->|->|=>|:=|\+-|\+\+|\.\.)"
    r"|(?P<compare><=|>=|<|>)"
    r"|(?P<sign>[+-])"
    r"|(?P<other>\S)",
    re.ASCII,
)
_STRICTNESS = {"<": "<=", "<=": "<", ">": ">=", ">=": ">"}
_BEFORE_TERMS = (
    *("and", "or", "not", "implies", "in", "when", "where", "with", "then", "else", "do", "is", "if", "from"),
    *("always", "never", "reach", "until", "holds", "during", "within", "assume"),
)
"""Words after which a sign belongs to the number that follows."""


def written_changes(source: Source, span: Span) -> list[Change]:
    """The small changes of what a span says, in the order of the text."""
    found: list[Change] = []
    before: re.Match[str] | None = None
    for token in _tokens(source, span):
        found += _of_token(source, token, before)
        before = token
    return found


def _tokens(source: Source, span: Span) -> Iterator[re.Match[str]]:
    for m in _TOKEN.finditer(source.text, span.start, span.end):
        if m.lastgroup != "skip":
            yield m


def _of_token(source: Source, m: re.Match[str], before: re.Match[str] | None) -> Iterator[Change]:
    start, end, kind = m.start(), m.end(), m.lastgroup
    if kind == "number":
        if before is not None and before[0] == "-" and before.end() == start and _opens(source, before.start()):
            start -= 1
        yield from _slips(source, start, end)
    elif kind == "compare":
        yield _change(source, "strictness", start, end, _STRICTNESS[m[0]])
    elif kind == "code":
        for k in range(start + 2, end):
            flipped = "10"[int(source.text[k])]
            yield _change(source, "bit", start, end, m[0][: k - start] + flipped + m[0][k + 1 - start :])
    elif kind == "sign" and not _opens(source, start):
        yield _change(source, "sign", start, end, "+" if m[0] == "-" else "-")


def _opens(source: Source, at: int) -> bool:
    """Whether a sign stands before a term, not between two."""
    head = source.text[:at].rstrip(" \t")
    word = re.search(r"[A-Za-z_]\w*$", head[-40:], re.ASCII)
    if word is not None:
        return word[0] in _BEFORE_TERMS
    return not head or (head[-1] not in ")]}'" and not head[-1].isalnum())


def _slips(source: Source, start: int, end: int) -> Iterator[Change]:
    for slip in slips(source.text[start:end]):
        yield _change(source, slip.kind, start, end, slip.text)


def _change(source: Source, kind: str, start: int, end: int, text: str) -> Change:
    line = source.position(start)[0]
    return Change(kind, (Edit(Span(source.path, start, end), text),), f"line {line}")
