"""CSV texts as cells with their places."""

from __future__ import annotations

import posixpath
from typing import NamedTuple

from haverify.elaborate.context import Context
from haverify.text.source import Source
from haverify.text.span import Span

COMMAS = "separated by ';'? a comma is expected"
LONGEST_SHOWN = 40


class CsvCell(NamedTuple):
    """A field without quotes and surrounding blanks, and its range in the text."""

    text: str
    start: int
    end: int


class CsvRow(NamedTuple):
    """The cells of a line, numbered from 1."""

    line: int
    cells: list[CsvCell]


def shown_path(ctx: Context, source: Source, written: str) -> str:
    """The path of a data file relative to the root spec."""
    folder = posixpath.dirname(ctx.root)
    if not source.path.startswith(folder):
        return written
    return posixpath.relpath(source.path, folder or ".")


def read_csv(source: Source) -> list[CsvRow]:
    """The rows that are not blank; fields may be quoted, but hold no line ends."""
    rows = []
    start = 0
    for number, line in enumerate(source.text.split("\n"), 1):
        if line.strip():
            rows.append(CsvRow(number, _quoted(line, start) if '"' in line else _plain(line, start)))
        start += len(line) + 1
    return rows


def _plain(line: str, start: int) -> list[CsvCell]:
    cells = []
    for field in line.split(","):
        cells.append(_cell(field, start))
        start += len(field) + 1
    return cells


def _cell(field: str, start: int) -> CsvCell:
    text = field.strip()
    at = start + (len(field) - len(field.lstrip()) if text else 0)
    return CsvCell(text, at, at + len(text))


def _quoted(line: str, start: int) -> list[CsvCell]:
    cells, field_start, inside = [], 0, False
    for k, c in enumerate(line + ","):
        if c == '"':
            inside = not inside
        elif c == "," and (not inside or k == len(line)):
            cells.append(_unquoted(line[field_start:k], start + field_start))
            field_start = k + 1
    return cells


def _unquoted(field: str, start: int) -> CsvCell:
    cell = _cell(field, start)
    text = cell.text
    if len(text) >= 2 and text[0] == text[-1] == '"':
        return CsvCell(text[1:-1].replace('""', '"').strip(), cell.start, cell.end)
    return cell


def clipped(text: str) -> str:
    """A cell to show: of what may be no table at all, not much is repeated."""
    return text if len(text) <= LONGEST_SHOWN else text[:LONGEST_SHOWN] + "..."


def cell_span(source: Source, cell: CsvCell) -> Span:
    """The place of a cell."""
    return Span(source.path, cell.start, cell.end)
