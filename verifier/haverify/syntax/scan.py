"""A text cut into the pieces a parser reads: words, numbers, symbols; comments are set aside."""

from __future__ import annotations

from typing import NamedTuple

from haverify.syntax.language import Language

NO_GAP, LINE_END, SEMICOLON = 0, 1, 2


class Piece(NamedTuple):
    """A piece of text: its kind (a group of the scanner), its place, and what separates it from the one before."""

    kind: str
    text: str
    start: int
    end: int
    gap: int


class Scanner:
    """Reads a text piece by piece; `comments` collects (start, end) of every comment passed."""

    def __init__(self, text: str, language: Language) -> None:
        self.text = text
        self.position = 1 if text.startswith("\ufeff") else 0
        self.comments: list[tuple[int, int]] = []
        self._match = language.scanner.match
        self._unit = language.unit.match

    def next(self, unit: bool) -> Piece:
        """The next piece; where a `unit` may stand it is read as one."""
        gap, match = NO_GAP, self._match
        while True:
            found = match(self.text, self.position)
            assert found is not None and found.lastgroup is not None  # the last group takes any character
            kind = found.lastgroup
            start, end = found.span(kind)
            self.position = end
            if kind == "GAP":
                gap = max(gap, SEMICOLON if ";" in found[kind] else LINE_END)
            elif kind == "COMMENT":
                self._keep_comment(start, end)
            elif unit and (measure := self._unit(self.text, start)):
                self.position = measure.end()
                return Piece("UNIT", measure[0], start, measure.end(), gap)
            else:
                return Piece(kind, found[kind], start, end, gap)

    def _keep_comment(self, start: int, end: int) -> None:
        while self.text[end - 1] in " \t\r":
            end -= 1
        self.comments.append((start, end))
