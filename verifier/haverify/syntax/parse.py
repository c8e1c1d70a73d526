"""Text to tree, going on after errors."""

from __future__ import annotations

import re

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.syntax.language import language
from haverify.syntax.reader import Reader
from haverify.syntax.tree import Tree
from haverify.text.source import Source
from haverify.text.span import Span

MOST_CHARACTERS = 16_000_000
NOT_TEXT = re.compile(r"[\x00-\x08\x0b\x0e-\x1f\x7f]")


def parse(source: Source) -> tuple[Tree, list[Diagnostic]]:
    """The tree of a file and what is wrong with its text; every declaration that could be read is in the tree."""
    refusal = _refusal(source)
    if refusal is not None:
        return Tree(source.path, (), (), Span(source.path, 0, len(source.text))), [refusal]
    return Reader(source, language()).read()


def _refusal(source: Source) -> Diagnostic | None:
    """Why a file is not even looked at."""
    if len(source.text) > MOST_CHARACTERS:
        message = f"the file has {len(source.text)} characters; a spec has at most {MOST_CHARACTERS}"
        return Diagnostic("HA001", message, Span(source.path, 0, 0))
    if not source.text.strip():
        message = 'the file is empty: start with `spec "..." version "1.0"`, or run `haverify init`'
        return Diagnostic("HA001", message, Span(source.path, 0, 0))
    strange = NOT_TEXT.search(source.text)
    if strange:
        message = f"this is not a text file: it contains the control character {ord(strange[0]):#04x}"
        return Diagnostic("HA001", message, Span(source.path, strange.start(), strange.end()))
    return None
