"""Text to tree, going on after errors."""

from __future__ import annotations

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.syntax.build import Builder
from haverify.syntax.language import Language, language
from haverify.syntax.machine import Machine
from haverify.syntax.scan import LINE_END, NO_GAP, SEMICOLON, Piece, Scanner
from haverify.syntax.tree import Tree
from haverify.text.source import Source
from haverify.text.span import Span


def parse(source: Source) -> tuple[Tree, list[Diagnostic]]:
    """The tree of a file and what is wrong with its text; every declaration that could be read is in the tree."""
    return _Parser(source, language()).run()


CONTINUES_AFTER = frozenset(
    "CMP PLUS MINUS STAR SLASH CIRCUMFLEX TOLERANCE EQUAL ASSIGN ARROW THEREFORE RANGE PARALLEL JOIN COLON COMMA DOT"
    " LBRACE DOC IN IS AND OR NOT IMPLIES IF THEN ELSE WHEN DO".split()
)
CONTINUES_BEFORE = frozenset(("}", "and", "or", "implies", "when", "do", "then", "else", "inductive"))


class _Parser:
    def __init__(self, source: Source, language: Language) -> None:
        self.source = source
        self.language = language
        self.builder = Builder(source.path, language)
        self.machine = Machine(language, self.builder)
        self.scanner = Scanner(source.text, language)
        self.last = "LBRACE"
        self.depth = 0

    def run(self) -> tuple[Tree, list[Diagnostic]]:
        findings = []
        m = self.machine
        items = ()
        while True:
            piece = self.scanner.next("UNIT" in m.table[m.states[-1]])
            if piece.gap and self.separates(piece):
                m.feed("_SEP", None, piece.start, piece.start)
                self.last = "_SEP"
            symbol = self.symbol(piece)
            if not m.feed(symbol, piece[1:4], piece.start, piece.end):
                span = Span(self.source.path, piece.start, piece.end)
                findings.append(Diagnostic("HA001", f"unexpected '{piece.text}'", span))
                break
            self.last = symbol
            if symbol in ("LPAR", "LSQB"):
                self.depth += 1
            elif symbol in ("RPAR", "RSQB"):
                self.depth -= 1
            if symbol == "$END":
                items = m.values[-2]
                break
        path = self.source.path
        text = self.source.text
        comments = tuple((text[s:e], Span(path, s, e)) for s, e in self.scanner.comments)
        return Tree(path, items, comments, Span(path, 0, len(text))), findings + self.builder.findings

    def separates(self, piece: Piece) -> bool:
        if piece.kind == "END" or piece.text == "}" or self.last in ("LBRACE", "DOC"):
            return False
        if piece.gap == SEMICOLON:
            return True
        return not (self.depth or self.last in CONTINUES_AFTER or piece.text in CONTINUES_BEFORE)

    def symbol(self, piece: Piece) -> str:
        kind, text = piece.kind, piece.text
        row = self.machine.table[self.machine.states[-1]]
        if kind == "WORD":
            word = self.language.words.get(text)
            if word is not None and (word in row or text in self.language.reserved):
                return word
            return "NAME"
        if kind == "OPERATOR":
            return self.language.symbols[text]
        if kind == "NUMBER" and text == "1" and "ONE" in row:
            return "ONE"
        return "$END" if kind == "END" else kind
