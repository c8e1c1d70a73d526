"""Says in words what is wrong where the parser could not go on."""

from __future__ import annotations

import re
from typing import NamedTuple

from haverify.diagnostics.diagnostic import Diagnostic, Label
from haverify.syntax.language import Language
from haverify.syntax.scan import Piece
from haverify.text.source import Source
from haverify.text.span import Span

ARITHMETIC = frozenset(("CMP", "PLUS", "MINUS", "STAR", "SLASH", "CIRCUMFLEX", "TOLERANCE"))
LOGIC = frozenset(("AND", "OR", "NOT", "IMPLIES", "IS", "IN"))
OPERATORS = ARITHMETIC | LOGIC | {"UNTIL", "DOT", "LPAR", "LSQB"}
DANGLING = ARITHMETIC | LOGIC | {
    "EQUAL", "ASSIGN", "IF", "THEN", "ELSE", "WHEN", "DO", "COMMA", "COLON", "ARROW", "THEREFORE", "DOT",
}  # fmt: skip
LINES = ("within", "expect", "method", "using", "assume")
KINDS = {"NAME": "a name", "STRING": "a string", "NUMBER": "a number", "UNIT": "a unit", "VERDICT": "a verdict"}
ENDS = ("RPAR", "RSQB", "RBRACE", "_SEP")
WRITE = {"≤": "<=", "≥": ">=", "≠": "!=", "∧": "and", "∨": "or", "¬": "not", "→": "->", "·": "*", "×": "*", "−": "-",
         "&": "and", "|": "or", "!": "not", "“": '"', "”": '"', "π": "pi", "±": "+-", "∞": "a bound"}  # fmt: skip
BLOCKS = (
    (("SPEC", "PROPERTY"), "a declaration"),
    (("PART", "SYNC"), "a member of a system"),
    (("MODE", "EDGE"), "a member of an automaton"),
    (("DOMAIN", "TERMINAL"), "a line of a mode"),
    (("WITHIN", "METHOD"), "a line of a property"),
    (("KEY", "COLUMN"), "a line of a table"),
    (("LOGIC", "OUTPUT"), "a line of a fuzzy system"),
    (("CELL", "RULE"), "a line of a cellular automaton"),
)


class Opening(NamedTuple):
    """A bracket that is open: its text, its place, and the height of the stack after it."""

    text: str
    start: int
    height: int


class Failure(NamedTuple):
    """Where the parser stood: the piece it could not take (as `symbol`), the one before, the symbols it could take."""

    piece: Piece
    symbol: str
    last: Piece
    last_symbol: str
    row: set[str]
    open: tuple[Opening, ...]
    unclosed: Opening | None


class Complaint:
    """Words for the failures of one file."""

    def __init__(self, source: Source, language: Language) -> None:
        self._source = source
        self._language = language

    def about(self, failure: Failure) -> Diagnostic:
        """The finding for a failure."""
        for attempt in (self._unclosed, self._bad, self._doc, self._dangling, self._stray, self._keyword):
            finding = attempt(failure)
            if finding is not None:
                return finding
        return self._unexpected(failure)

    def _span(self, start: int, end: int) -> Span:
        return Span(self._source.path, start, end)

    def _place(self, failure: Failure) -> Span:
        """The piece, or the end of the line that it is no longer on."""
        if failure.symbol == "_SEP" or (failure.piece.gap and failure.last.end) or failure.piece.kind == "END":
            return self._span(failure.last.end, failure.last.end)
        return self._span(failure.piece.start, failure.piece.end)

    def _unclosed(self, failure: Failure) -> Diagnostic | None:
        opening = failure.unclosed
        if opening is None and failure.open:
            innermost, piece = failure.open[-1], failure.piece
            in_brackets = innermost.text != "{" and (piece.gap or piece.text == "}")
            if piece.kind == "END" or (in_brackets and failure.last_symbol not in DANGLING):
                opening = innermost
        if opening is None:
            return None
        piece = failure.piece
        label = Label(self._span(piece.start, piece.end), f"found {_found(piece)} before it was closed")
        place = self._span(opening.start, opening.start + 1)
        return Diagnostic("HA003", f"'{opening.text}' opened here is never closed", place, labels=(label,))

    def _bad(self, failure: Failure) -> Diagnostic | None:
        piece = failure.piece
        if piece.kind != "BAD" or failure.symbol == "_SEP":
            return None
        place, first = self._span(piece.start, piece.end), piece.text[0]
        if first == '"':
            return Diagnostic("HA001", "this string does not end on its line", place, help='close it with `"`')
        if first in WRITE:
            message = f"'{first}' is not a symbol of the language"
            return Diagnostic("HA001", message, place, help=f"write `{WRITE[first]}`")
        if first.isalpha():
            word = self._word(piece.start)
            return Diagnostic("HA001", f"'{word}' cannot be a name: names are ASCII letters, digits and '_'", place)
        return Diagnostic("HA001", f"the character {first!r} (U+{ord(first):04X}) means nothing here", place)

    def _word(self, offset: int) -> str:
        text = self._source.text
        before = re.search(r"\w*\Z", text[max(0, offset - 40) : offset])
        after = re.match(r"\w*", text[offset : offset + 40])
        return (before[0] if before else "") + (after[0] if after else "")

    def _doc(self, failure: Failure) -> Diagnostic | None:
        if failure.piece.kind == "DOC" and failure.symbol != "_SEP":
            place = self._span(failure.piece.start, failure.piece.end)
            message = "a doc comment stands on a line of its own before a declaration or a member"
        elif failure.last_symbol == "DOC":
            place = self._span(failure.last.start, failure.last.end)
            message = "nothing follows this doc comment that it could describe"
        else:
            return None
        return Diagnostic("HA001", message, place, help="write `//` for a remark")

    def _dangling(self, failure: Failure) -> Diagnostic | None:
        """An operator at the end of a line, and on the next line a word that cannot be its operand."""
        piece, last = failure.piece, failure.last
        reserved = piece.text in self._language.reserved
        if failure.last_symbol not in DANGLING or not piece.gap or not reserved:
            return None
        message = f"{self._expected(failure.row)} is missing after '{last.text}'"
        label = Label(self._span(piece.start, piece.end), f"'{piece.text}' starts something new")
        return Diagnostic("HA003", message.removeprefix("expected "), self._span(last.start, last.end), labels=(label,))

    def _stray(self, failure: Failure) -> Diagnostic | None:
        if failure.piece.text not in (")", "]", "}") or failure.open or failure.symbol == "_SEP":
            return None
        place = self._span(failure.piece.start, failure.piece.end)
        return Diagnostic("HA003", f"'{failure.piece.text}' closes nothing", place)

    def _keyword(self, failure: Failure) -> Diagnostic | None:
        piece, row = failure.piece, failure.row
        taken = piece.text in self._language.reserved and "NAME" in row and "LPAR" not in row
        if not taken or piece.gap or failure.symbol == "_SEP":
            return None
        place = self._span(piece.start, piece.end)
        message = f"'{piece.text}' is a word of the language and cannot be a name"
        return Diagnostic("HA001", message, place, help=f"choose another name, such as `{piece.text}_1`")

    def _unexpected(self, failure: Failure) -> Diagnostic:
        after = f" after '{_short(failure.last.text)}'" if failure.last.text else ""
        if failure.last_symbol in ("_SEP", "LBRACE"):
            after = ""
        ended = failure.symbol == "_SEP" or (failure.piece.gap and failure.last_symbol in DANGLING)
        found = "end of line" if ended else _found(failure.piece)
        if failure.symbol == "_SEP" and failure.piece.gap == 2:
            found = "';'"
        if failure.piece.text in self._language.reserved and not ended:
            found = f"the word '{failure.piece.text}'"
        message = f"expected {self._expected(failure.row)}{after}, found {found}"
        place = self._place(failure) if ended or failure.piece.kind == "END" else self._piece(failure.piece)
        return Diagnostic("HA001", message, place, help=_help(failure))

    def _piece(self, piece: Piece) -> Span:
        return self._span(piece.start, piece.end)

    # ---- what could have stood there -------------------------------------------------

    def _expected(self, row: set[str]) -> str:
        """What a state of the machine would take, in words."""
        if "LPAR" in row and "QUANTITY" in row:
            return "an expression"
        for symbols, words in BLOCKS:
            if all(symbol in row for symbol in symbols):
                return words
        found = [words for symbol, words in KINDS.items() if symbol in row]
        if "CIRCUMFLEX" in row or "PLUS" in row:
            found.append("an operator")
        literals = [] if "an operator" in found else self._literals(row)
        ends = [self._end(symbol) for symbol in ENDS if symbol in row]
        chosen = (found + literals)[:3] + ends[-1:] if len(found + literals) <= 4 else [*found, *ends[-1:]]
        return _listed(chosen or ["something else"])

    def _literals(self, row: set[str]) -> list[str]:
        terminals = [symbol for symbol in row if symbol.isupper() and symbol not in ENDS and symbol not in OPERATORS]
        spelled = [self._language.spelling(symbol) for symbol in sorted(terminals)]
        plain = [text for symbol, text in (("IN", "in"), ("LSQB", "["), ("LPAR", "(")) if symbol in row]
        return [f"'{text}'" for text in spelled + plain if text]

    def _end(self, symbol: str) -> str:
        return "end of line" if symbol == "_SEP" else f"'{self._language.spelling(symbol)}'"


def _listed(words: list[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} or {words[-1]}"


def _short(text: str) -> str:
    return text if len(text) <= 40 else text[:37] + "..."


def _found(piece: Piece) -> str:
    return "end of file" if piece.kind == "END" else f"'{_short(piece.text)}'"


def _help(failure: Failure) -> str | None:
    piece, row = failure.piece, failure.row
    if piece.text == "=" and "CMP" in row:
        return "write `==` to compare"
    if piece.text == "." and "QUANTITY" in row:
        return "write a digit before the point: `0.5`"
    if piece.text == ":=" and "EQUAL" in row:
        return "write `=`; `:=` assigns at a jump"
    if piece.text == "=" and "QUOTE" in row:
        return f"write `{failure.last.text}' =` for a derivative"
    if piece.text == "=" and "ASSIGN" in row:
        return "write `:=` to assign at a jump"
    return _help_with_habits(failure)


def _help_with_habits(failure: Failure) -> str | None:
    """What to write for what other languages would take there."""
    piece, last, row = failure.piece, failure.last_symbol, failure.row
    if piece.text == ":":
        return "write `{ ... }` around what follows" if "LBRACE" in row else "no colon stands here"
    if (piece.text == "[" and "LSQB" not in row) or (piece.text == "/" and row == {"RSQB"}):
        return "a unit follows a number, or a colon: `0.5 m/s`, `x: m/s`"
    if piece.kind == "NUMBER" and last in ("NUMBER", "INT"):
        return "write a unit below one with a power: `0.5 s^-1`"
    if piece.text in LINES and "_SEP" in row:
        return f"begin a new line, or write `;`, before `{piece.text} ...`"
    if piece.text == '""':
        return "write `/// ...` above a declaration to describe it"
    return None
