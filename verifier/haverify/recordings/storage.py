"""OpenSim's `.mot` and `.sto` files, and SIMM's: a header of any version, a line of labels, rows of numbers.

Header lines are `key=value` or `key value`, up to `endheader`. Labels and rows are what counts: numbers of rows and
columns in the header are often wrong and are only compared. `inDegrees` says the unit of angles in versions 1 to 3;
older files say it in a sentence, SIMM's not at all.
"""

from __future__ import annotations

import re

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.recordings.columns import Columns, columns_of
from haverify.text.record import record
from haverify.text.source import Source
from haverify.text.span import Span

_END = re.compile(r"^[ \t]*endheader[ \t]*$", re.MULTILINE | re.IGNORECASE)
_COUNTS = {"nrows": "rows", "datarows": "rows", "ncolumns": "columns", "datacolumns": "columns"}


@record
class Header:
    """`unit` is `deg`, `rad` or empty where nothing is said, `why` the words that say it.

    `counts` are (kind, number, span).
    """

    unit: str
    why: str
    counts: tuple[tuple[str, int, Span], ...]


def storage(source: Source) -> tuple[Header, Columns | None, list[Diagnostic]]:
    """The header and the columns of a file, with what is odd about them."""
    end = _END.search(source.text)
    if end is None:
        at = Span(source.path, 0, len(source.line(1)))
        message = "no line `endheader`: this is no .mot or .sto file"
        return Header("", "", ()), None, [Diagnostic("HA210", message, at)]
    header = _header(source, end.start())
    columns, found = columns_of(source, end.end() + 1, None)
    if columns is not None:
        found += _contradictions(header, columns)
    return header, columns, found


def _header(source: Source, end: int) -> Header:
    text = source.text[:end]
    counts, unit, why = [], "", ""
    for m in re.finditer(r"^[ \t]*(\w+)[ \t]*[= \t][ \t]*([^\s=]+)[ \t]*$", text, re.MULTILINE):
        key, value = m[1].lower(), m[2]
        if key in _COUNTS and value.isdigit() and len(value) < 10:
            counts.append((_COUNTS[key], int(value), Span(source.path, m.start(1), m.end(2))))
        if key == "indegrees":
            unit, why = ("rad" if value.lower() in ("no", "n", "false", "0") else "deg"), f"inDegrees={value}"
    sentence = re.search(r"angles are in (degrees|radians)", text, re.IGNORECASE)
    if not unit and sentence:
        unit, why = ("deg" if sentence[1].lower() == "degrees" else "rad"), sentence[0]
    return Header(unit, why, tuple(counts))


def _contradictions(header: Header, columns: Columns) -> list[Diagnostic]:
    found: dict[tuple[str, int], Diagnostic] = {}
    for kind, stated, span in header.counts:
        actual = len(columns.rows) if kind == "rows" else len(columns.labels)
        if stated != actual:
            message = f"the header says {stated} {kind}, but {actual} follow; the {kind} that are there are read"
            found.setdefault((kind, stated), Diagnostic("HA221", message, span))
    return list(found.values())
