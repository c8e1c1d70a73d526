"""Findings as people read them: a line of summary, the place with carets, notes with values, a help to paste."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import groupby

from haverify.diagnostics.codes import severity
from haverify.diagnostics.diagnostic import Diagnostic, Severity
from haverify.text.record import record
from haverify.text.source import Source
from haverify.text.span import Span

_WIDTH = 120  # code points of a source line that are shown
_LEAD = 40  # of which at least these stand before the marked place
_CAP = 20  # findings of one code that are written out in full

_COLOUR = {
    Severity.ERROR: "\x1b[1;31m",
    Severity.WARNING: "\x1b[1;33m",
    Severity.INFORMATION: "\x1b[1;36m",
    Severity.VERDICT: "\x1b[1;35m",
}
_RESET = "\x1b[0m"


@record
class _Mark:
    """A stretch of one source line to underline, columns from 1, `end` exclusive."""

    line: int
    start: int
    end: int
    sign: str
    text: str


def render_all(found: Iterable[Diagnostic], sources: Mapping[str, Source], colour: bool = False) -> str:
    """The findings one after the other, an empty line between them; of one code at most 20 are written out."""
    blocks, seen, hidden = [], dict[str, int](), dict[str, int]()
    for d in found:
        seen[d.code] = seen.get(d.code, 0) + 1
        if seen[d.code] > _CAP:
            hidden[d.code] = hidden.get(d.code, 0) + 1
        else:
            blocks.append(render(d, sources, colour))
    blocks += [f"... and {n} more of {code} (`--format json` lists all)\n" for code, n in sorted(hidden.items())]
    return "\n".join(blocks)


def render(d: Diagnostic, sources: Mapping[str, Source], colour: bool = False) -> str:
    """One finding, with a newline at the end."""
    kind = severity(d)
    head = f"{kind.value}[{d.code}]"
    if colour:
        head = f"{_COLOUR[kind]}{head}{_RESET}"
    lines = [f"{head}: {_one_line(d.message)}"]
    lines += places(d, sources)
    lines += [text for note in d.notes for text in _entry("note", note)]
    if d.help:
        lines += _entry("help", d.help)
    return "\n".join(lines) + "\n"


def where(span: Span, sources: Mapping[str, Source]) -> str:
    """`path:line:column` of the start of a span."""
    source = sources.get(span.path)
    if source is None:
        return span.path
    line, column = source.position(span.start)
    return f"{span.path}:{line}:{column}"


def _one_line(text: str) -> str:
    return " ".join(text.split("\n"))


def _entry(word: str, text: str) -> list[str]:
    first, *rest = text.split("\n")
    return [f"   = {word}: {first}", *(f"     {' ' * len(word)}  {line}" for line in rest)]


def places(d: Diagnostic, sources: Mapping[str, Source]) -> list[str]:
    """The excerpts: the file of the primary span first, other files after it."""
    if d.span is None:
        return []
    spots = [(d.span, d.label, "^"), *((label.span, label.text, "-") for label in d.labels)]
    paths = list(dict.fromkeys(span.path for span, _, _ in spots))
    lines = []
    for path in paths:
        here = [spot for spot in spots if spot[0].path == path]
        lines.append(f"  --> {where(here[0][0], sources)}")
        if path in sources:
            lines += _excerpt(sources[path], here)
    return lines


def _excerpt(source: Source, spots: list[tuple[Span, str, str]]) -> list[str]:
    marks = sorted((_mark(source, *spot) for spot in spots), key=lambda m: (m.line, m.start, m.sign == "-"))
    gutter = len(str(marks[-1].line))
    lines, last = [f" {' ' * gutter} |"], None
    for number, group in groupby(marks, key=lambda m: m.line):
        if last is not None and number > last + 1:
            lines.append(f" {'.' * min(gutter, 3)}")
        lines += _marked_line(source.line(number), number, gutter, list(group))
        last = number
    return lines


def _mark(source: Source, span: Span, text: str, sign: str) -> _Mark:
    """The first line of a span; an empty span is one column wide, a span of several lines ends with its first."""
    line, start = source.position(min(span.start, len(source.text)))
    end_of_line = len(source.line(line)) + 1
    width = max(1, min(span.end - span.start, end_of_line - start))
    return _Mark(line, start, start + width, sign, _one_line(text))


def _marked_line(text: str, number: int, gutter: int, marks: list[_Mark]) -> list[str]:
    shift, shown = _clip(_plain(text), marks)
    moved = [_Mark(m.line, m.start - shift, min(m.end - shift, len(shown) + 2), m.sign, m.text) for m in marks]
    pad = " " * gutter
    lines = [f" {number:>{gutter}} | {shown}".rstrip()]
    lines.append(f" {pad} | {_underline(moved)}")
    for m in reversed(moved[:-1]):
        if m.text:
            lines.append(f" {pad} | {' ' * (m.start - 1)}{m.text}")
    return lines


def _underline(marks: list[_Mark]) -> str:
    row = [" "] * max(m.end - 1 for m in marks)
    for m in sorted(marks, key=lambda m: m.sign == "^"):  # carets win where marks overlap
        row[m.start - 1 : m.end - 1] = m.sign * (m.end - m.start)
    return ("".join(row) + " " + marks[-1].text).rstrip()


def _plain(text: str) -> str:
    """The line with each control character, tabs included, shown as one column."""
    return "".join(" " if c == "\t" else c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in text)


def _clip(text: str, marks: list[_Mark]) -> tuple[int, str]:
    """A window of a long line around its marks, and by how many columns the marks move left."""
    if len(text) <= _WIDTH:
        return 0, text
    first = min((m for m in marks), key=lambda m: (m.sign != "^", m.start)).start
    start = max(0, min(first - 1 - _LEAD, len(text) - _WIDTH))
    last = start + _WIDTH + (start + _WIDTH == len(text))  # a mark may stand behind the end of the line
    marks[:] = [m for m in marks if start < m.start <= last]
    marks[:] = [_Mark(m.line, m.start, min(m.end, last + 1), m.sign, m.text) for m in marks]
    shown = text[start : start + _WIDTH]
    lead, tail = "..." if start else "", "..." if start + _WIDTH < len(text) else ""
    return start - len(lead), lead + shown + tail
