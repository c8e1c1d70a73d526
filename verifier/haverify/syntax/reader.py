"""Reads a whole file: decides where lines end, feeds the machine, and resumes after errors."""

from __future__ import annotations

import re
from functools import cached_property
from typing import NamedTuple

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.syntax.build import Builder
from haverify.syntax.complaint import DANGLING, Complaint, Failure, Opening
from haverify.syntax.language import Language
from haverify.syntax.machine import Machine
from haverify.syntax.scan import LINE_END, NO_GAP, SEMICOLON, Piece, Scanner
from haverify.syntax.tree import Tree
from haverify.text.record import replace
from haverify.text.source import Source
from haverify.text.span import Span

MOST_SHOWN = 20
MOST_ERRORS = 200  # then the rest of the file is not read: it is hardly a spec
DEEPEST = 200  # states on the stack: few enough for those who descend into the tree, a plain bracket takes one

CONTINUES_AFTER = DANGLING | {"RANGE", "PARALLEL", "JOIN", "LBRACE", "DOC"}
CONTINUES_BEFORE = frozenset(("and", "or", "implies", "when", "do", "then", "else", "inductive"))
CONTINUES_AFTER_TEXT = re.compile(r"(?:[-+*/^<>=:,.|([]|\b(?:in|is|and|or|not|implies|if|then|else|when|do))[ \t\r]*\Z")
OPENING = {"LPAR": "(", "LSQB": "[", "LBRACE": "{"}
CLOSING = frozenset(("RPAR", "RSQB", "RBRACE"))
DULL = r'(?:[^\n;{}"/]+|"[^"\n]*"|/(?!/))+'
DULL_LIST = r'(?:[^\n;{},"/]+|"[^"\n]*"|/(?!/))+'
LONGEST_SKIP = 100_000  # pieces passed over after errors; then the rest of the file is not read


class _Skip(NamedTuple):
    """Where reading resumes: at `piece`, after a line end that has been fed when `separated`."""

    piece: Piece
    separated: bool


class Reader:
    """One pass over one file."""

    def __init__(self, source: Source, language: Language) -> None:
        self._source = source
        self._language = language
        self._builder = Builder(source.path, language)
        self._machine = Machine(language, self._builder)
        self._scanner = Scanner(source.text, language)
        self._complaint = Complaint(source, language)
        self._open: list[Opening] = []
        self._last: Piece = Piece("END", "", 0, 0, NO_GAP)
        self._last_symbol = "LBRACE"
        self._findings: list[Diagnostic] = []
        self._errors = 0
        self._skipped = 0
        self._starters = language.starters

    def read(self) -> tuple[Tree, list[Diagnostic]]:
        """The tree and the findings of the file."""
        piece: Piece | None = self._next()
        while piece is not None and self._errors < MOST_ERRORS:
            piece = self._step(piece)
        if piece is not None:
            self._finish()
        text, path = self._source.text, self._source.path
        comments = tuple((text[start:end], Span(path, start, end)) for start, end in self._scanner.comments)
        tree = Tree(path, self._machine.values[-2], comments, Span(path, 0, len(text)))
        return tree, self._capped(self._findings + self._builder.findings)

    def _next(self) -> Piece:
        machine = self._machine
        return self._scanner.next("UNIT" in machine.table[machine.states[-1]])

    def _step(self, piece: Piece) -> Piece | None:
        """Feed a piece; the piece to go on with, None after the end of the file."""
        machine = self._machine
        if piece.gap and self._separates(piece):
            if not machine.feed("_SEP", None, self._last.end, self._last.end):
                return self._fail(piece, "_SEP")
            self._last_symbol = "_SEP"
        symbol = self._symbol(piece)
        if not machine.feed(symbol, piece[1:4], piece.start, piece.end):
            return self._fail(piece, symbol)
        self._last, self._last_symbol = piece, symbol
        if symbol in OPENING:
            self._open.append(Opening(OPENING[symbol], piece.start, len(machine.states)))
        elif symbol in CLOSING:
            self._open.pop()
        if symbol == "$END":
            return None
        if len(machine.states) > DEEPEST:
            self._too_deep(piece)
            return None
        return self._next()

    def _separates(self, piece: Piece) -> bool:
        """Whether the gap before a piece ends a line."""
        if piece.kind == "END" or piece.text == "}" or self._last_symbol in ("LBRACE", "DOC", "_SEP"):
            return False
        if piece.gap == SEMICOLON:
            return True
        inside = bool(self._open) and self._open[-1].text != "{"
        return not inside and self._last_symbol not in CONTINUES_AFTER and piece.text not in CONTINUES_BEFORE

    def _symbol(self, piece: Piece) -> str:
        """The terminal a piece is, where the machine stands: words have a meaning only where the grammar uses them."""
        kind, text = piece.kind, piece.text
        row = self._machine.table[self._machine.states[-1]]
        if kind == "WORD":
            word = self._language.words.get(text)
            return word if word is not None and (word in row or text in self._language.reserved) else "NAME"
        if kind == "OPERATOR":
            return self._language.symbols[text]
        if kind == "NUMBER" and text == "1" and "ONE" in row:
            return "ONE"
        return "$END" if kind == "END" else kind

    # ---- after an error ----------------------------------------------------------

    def _fail(self, piece: Piece, symbol: str) -> Piece | None:
        """Report that `symbol` cannot stand here, and find where to go on."""
        machine = self._machine
        unclosed = self._unclosed(piece)
        self._errors += 1
        if self._errors <= MOST_SHOWN + 1:
            row = {symbol for symbol in machine.table[machine.states[-1]] if machine.accepts(symbol)}
            failure = Failure(piece, symbol, self._last, self._last_symbol, row, tuple(self._open), unclosed)
            self._findings.append(self._complaint.about(failure))
        if piece.kind == "END":
            self._finish()
            return None
        if unclosed is not None:
            return self._after_closing(piece, unclosed.height - 1)
        resumed = self._skip(piece, symbol, self._abandon(symbol))
        if resumed is None:
            return None
        self._last, self._last_symbol = resumed.piece, "_SEP" if resumed.separated else "_ERROR"
        return resumed.piece._replace(gap=NO_GAP)

    def _lists(self) -> list[int]:
        """Heights of the stack at which an item of some block may stand, innermost first."""
        table, states = self._machine.table, self._machine.states
        return [height for height in range(len(states), 0, -1) if "_ERROR" in table[states[height - 1]]]

    def _unclosed(self, piece: Piece) -> Opening | None:
        """The block that was not closed when a word starts a line that belongs to a block further out."""
        word = self._language.words.get(piece.text) if piece.kind == "WORD" else None
        if word is None or not piece.gap:
            return None
        rows = [(height, self._machine.table[self._machine.states[height - 1]]) for height in self._lists()]
        if not rows or word in rows[0][1]:
            return None
        home = next((height for height, row in rows if word in row), 0)
        left_open = [opening for opening in self._open if opening.text == "{" and opening.height > home > 0]
        if not left_open or self._indent(piece.start) > self._indent(left_open[0].start):
            return None
        return left_open[0]

    def _indent(self, offset: int) -> int:
        start = self._source.text.rfind("\n", 0, offset) + 1
        line = self._source.text[start : offset + 1]
        return len(line) - len(line.lstrip())

    def _abandon(self, symbol: str) -> int:
        """Give up the innermost item; the number of its braces that are still open."""
        if symbol != "_SEP" and self._machine.accepts("_SEP"):
            self._machine.feed("_SEP", None, self._last.end, self._last.end)
        return self._drop(self._lists()[0])

    def _drop(self, height: int) -> int:
        braces = sum(opening.text == "{" and opening.height > height for opening in self._open)
        self._open = [opening for opening in self._open if opening.height <= height]
        self._machine.drop(height)
        self._machine.feed("_ERROR", None, self._last.end, self._last.end)
        return braces

    def _skip(self, piece: Piece, symbol: str, depth: int) -> _Skip | None:
        """Pass over pieces until a line, an item or the block ends; `depth` braces are to be closed first."""
        inside = bool(self._open)
        first, in_item = True, self._last_symbol not in ("_SEP", "LBRACE", "DOC")
        while piece.kind != "END":
            ends_line = piece.gap and (not first or symbol == "_SEP" or (in_item and piece.text in self._starters))
            if depth == 0 and ends_line and self._resumes(piece):
                return _Skip(piece, True)
            if depth == 0 and self._ends_item(piece, inside):
                return _Skip(piece, False)
            depth += (piece.text == "{") - (piece.text == "}" and depth > 0)
            self._skipped += 1
            if self._skipped > LONGEST_SKIP:
                self._finish()
                return None
            first = False
            self._jump(inside, depth)
            piece = self._scanner.next(unit=False)
        return _Skip(piece, False)

    def _ends_item(self, piece: Piece, inside: bool) -> bool:
        if piece.text == "}" and piece.kind == "OPERATOR":
            return inside
        return piece.text == "," and self._machine.accepts("COMMA")

    def _resumes(self, piece: Piece) -> bool:
        """Whether a new item starts with `piece`; then the line end before it is fed."""
        before = self._source.text[max(0, piece.start - 200) : piece.start].rstrip("; \t\r\n")
        starter = piece.text in self._starters
        if piece.gap == LINE_END and not starter and CONTINUES_AFTER_TEXT.search(before):
            return False
        machine = self._machine
        if piece.text in CONTINUES_BEFORE or not machine.accepts("_SEP"):
            return False
        states = list(machine.states)
        word = self._language.words.get(piece.text) if piece.kind == "WORD" else None
        row = machine.table[machine.after(states, "_SEP")]
        symbol = word if word is not None and (word in row or starter) else self._symbol(piece)
        if symbol not in row and not starter:
            return False
        machine.feed("_SEP", None, piece.start, piece.start)
        return True

    def _jump(self, inside: bool, depth: int) -> None:
        """Pass what cannot matter while skipping, at the speed of one search."""
        in_list = inside and depth == 0 and self._machine.accepts("COMMA")
        pattern = DULL_LIST if in_list else DULL if inside or depth else self._dull_outside
        dull = re.compile(pattern).match(self._source.text, self._scanner.position)
        if dull:
            self._scanner.position = dull.end()

    def _after_closing(self, piece: Piece, height: int) -> Piece:
        """Go on with `piece` after the blocks above `height` were closed for the author."""
        while self._open and self._open[-1].height > height:
            self._close_one()
        self._last_symbol = "RBRACE"
        return piece

    def _close_one(self) -> None:
        machine = self._machine
        braces = [opening for opening in self._open if opening.text == "{"]
        if not machine.accepts("RBRACE"):
            lists = self._lists()
            self._drop(lists[0])
            if not braces or lists[0] < braces[-1].height:
                return
        if machine.feed("RBRACE", None, self._last.end, self._last.end):
            self._open = self._open[: self._open.index(braces[-1])] if braces else []

    def _finish(self) -> None:
        """End the file here, keeping every block that was begun."""
        while self._open:
            self._close_one()
        machine, end = self._machine, len(self._source.text)
        if not machine.feed("$END", None, end, end):
            self._drop(self._lists()[0])
            machine.feed("$END", None, end, end)

    @cached_property
    def _dull_outside(self) -> str:
        """Between declarations whole lines are dull, unless a word of the language begins them."""
        words = {word for word, terminal in self._language.words.items() if terminal in self._language.states[0]}
        beginning = "|".join(sorted(words | self._starters))
        return rf"(?:{DULL}|}}|[\n;](?![ \t]*(?:(?:{beginning})\b|@|/)))+"

    def _too_deep(self, piece: Piece) -> None:
        span = Span(self._source.path, piece.start, piece.end)
        message = "nested too deeply to be meant; the rest of the file was not read"
        self._findings.append(Diagnostic("HA001", message, span))
        self._finish()

    def _capped(self, findings: list[Diagnostic]) -> list[Diagnostic]:
        """The findings in order of place; of many the first, the last of which says so."""
        findings = sorted(findings, key=lambda finding: finding.span.start if finding.span else 0)
        if len(findings) <= MOST_SHOWN:
            return findings
        note = f"only the first {MOST_SHOWN} errors of this file are shown"
        return [*findings[: MOST_SHOWN - 1], replace(findings[MOST_SHOWN - 1], notes=(note,))]
