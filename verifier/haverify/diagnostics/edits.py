"""Texts with edits made."""

from __future__ import annotations

from collections.abc import Iterable

from haverify.diagnostics.diagnostic import Edit
from haverify.text.source import Source


def edited(text: str, edits: Iterable[Edit]) -> str:
    """The text with edits that do not overlap."""
    for e in sorted(edits, key=lambda e: e.span.start, reverse=True):
        text = text[: e.span.start] + e.text + text[e.span.end :]
    return text


def edited_source(source: Source, edits: Iterable[Edit]) -> Source:
    """The source with edits made; its bytes keep their byte order mark and their kind of line ends."""
    text = edited(source.text, edits)
    mark = b"\xef\xbb\xbf" if source.raw.startswith(b"\xef\xbb\xbf") else b""
    ends = text.replace("\n", "\r\n") if b"\r\n" in source.raw else text
    return Source(source.path, text, mark + ends.encode())
