"""A line of labels and rows of numbers, each with its place in the file."""

from __future__ import annotations

import re
from fractions import Fraction

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.maths.exact import parse_decimal
from haverify.text.record import record
from haverify.text.source import Source
from haverify.text.span import Span

Q = Fraction

_EMPTY = frozenset({"", "nan", "-nan", "na", "n/a", "null", "none", "inf", "-inf"})
_MOST = 50
_LARGEST = 10**300


@record
class Columns:
    """Labels with their spans, and rows as texts; `starts[i]` is where row i begins in the file."""

    source: Source
    labels: tuple[str, ...]
    spans: tuple[Span, ...]
    rows: tuple[tuple[str, ...], ...]
    starts: tuple[int, ...]
    separator: str | None

    def span(self, row: int, column: int) -> Span:
        """The place of a cell."""
        start = self.starts[row]
        line = self.source.text[start : self.source.text.find("\n", start) % (len(self.source.text) + 1)]
        cells = list(re.finditer(r"\S+", line)) if self.separator is None else _split_at(line, self.separator)
        if column >= len(cells):
            return Span(self.source.path, start, start + len(line))
        return Span(self.source.path, start + cells[column].start(), start + cells[column].end())


def _split_at(line: str, separator: str) -> list[re.Match[str]]:
    return list(re.finditer(f"(?<![^{separator}])[^{separator}]*", line))


def columns_of(source: Source, start: int, separator: str | None) -> tuple[Columns | None, list[Diagnostic]]:
    """The columns from offset `start` on; cells are separated by white space, or by `separator`.

    A row with too few or too many cells is an error: no one can say which cells are missing.
    """
    labels: tuple[str, ...] = ()
    spans: tuple[Span, ...] = ()
    rows: list[tuple[str, ...]] = []
    starts: list[int] = []
    found: list[Diagnostic] = []
    at = start
    for line in source.text[start:].split("\n"):
        cells = _cells(line, separator)
        if cells and not labels:
            labels, spans = tuple(cells), _label_spans(source.path, line, at, separator)
        elif cells and len(cells) == len(labels):
            rows.append(tuple(cells))
            starts.append(at)
        elif cells and len(found) < _MOST:
            found.append(_ragged(Span(source.path, at, at + len(line)), len(rows) + 1, cells, len(labels), separator))
        at += len(line) + 1
    if not rows:
        place = Span(source.path, max(start - 1, 0), start)
        return None, [*found, Diagnostic("HA210", "no rows of numbers", place)]
    return Columns(source, labels, spans, tuple(rows), tuple(starts), separator), found


def _cells(line: str, separator: str | None) -> list[str]:
    if separator is None:
        return line.split()
    cells = [c.strip().strip('"') for c in line.split(separator)]
    return cells if any(cells) else []


def _label_spans(path: str, line: str, at: int, separator: str | None) -> tuple[Span, ...]:
    found = re.finditer(r"\S+", line) if separator is None else _split_at(line, separator)
    return tuple(Span(path, at + m.start(), at + m.end()) for m in found)


def _ragged(span: Span, row: int, cells: list[str], labels: int, separator: str | None) -> Diagnostic:
    has_commas = separator == "," and len(cells) >= 2 * labels - 1 and all(c.lstrip("+-").isdigit() for c in cells)
    advice = "are these decimal commas? write decimal points"
    message = f"row {row} has {len(cells)} cells, the line of labels {labels}"
    return Diagnostic("HA210", message, span, help=advice if has_commas else None)


def numbers(columns: Columns, column: int) -> tuple[list[Q | None], list[Diagnostic]]:
    """The numbers of a column; None where a cell is empty or NaN, an error where it is something else."""
    values: list[Q | None] = []
    found: list[Diagnostic] = []
    for i, row in enumerate(columns.rows):
        q = parse_decimal(row[column])
        if q is None and row[column].lower() not in _EMPTY:
            message = f"`{row[column]}` in column {columns.labels[column]} is no number"
            has_comma = re.fullmatch(r"[+-]?\d+,\d+", row[column]) is not None
            advice = f"write a decimal point: {row[column].replace(',', '.')}" if has_comma else None
            found.append(Diagnostic("HA210", message, columns.span(i, column), help=advice))
        if q is not None and abs(q) > _LARGEST:
            found.append(
                Diagnostic("HA210", f"`{row[column][:20]}` is no angle, time or force", columns.span(i, column))
            )
            q = None
        values.append(q)
    return values, found[:_MOST]
