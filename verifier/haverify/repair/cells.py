"""Changes of table cells: slips in one number, two neighbours the wrong way round."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise

from haverify.diagnostics.diagnostic import Edit
from haverify.maths.exact import parse_decimal
from haverify.model.spec import Cell, Spec
from haverify.repair.change import Change
from haverify.repair.slips import slips
from haverify.text.source import Source
from haverify.text.span import Span


def cells_by_line(spec: Spec) -> dict[tuple[str, int], list[list[Cell]]]:
    """The cells of each line of each table, from left to right; those that read one place are together."""
    found: dict[tuple[str, int], dict[Span, list[Cell]]] = {}
    for c in spec.cells:
        found.setdefault((c.span.path, c.row), {}).setdefault(c.span, []).append(c)
    return {line: [places[s] for s in sorted(places, key=lambda s: s.start)] for line, places in found.items()}


def line_changes(places: Sequence[Sequence[Cell]], sources: Mapping[str, Source]) -> list[Change]:
    """The small changes of one line of a table."""
    found = [c for place in places for c in slips_of(place, sources)]
    for left, right in pairwise(places):
        found += swapped(left, right, sources)
    return found


def slips_of(place: Sequence[Cell], sources: Mapping[str, Source]) -> Iterator[Change]:
    """The slips in one cell, which several tables may read."""
    first = place[0]
    for slip in slips(text_of(first.span, sources)):
        numbers = tuple((c.constant, slip.value) for c in place)
        yield Change(slip.kind, (Edit(first.span, slip.text),), name_of(first, sources), numbers)


def swapped(
    left: Sequence[Cell], right: Sequence[Cell], sources: Mapping[str, Source], kind: str = "cells"
) -> Iterator[Change]:
    """Two neighbours exchanged, if they are neighbours and differ."""
    a, b = left[0], right[0]
    texts = text_of(a.span, sources), text_of(b.span, sources)
    between = sources[a.span.path].text[a.span.end : b.span.start] if a.span.path in sources else ""
    if between.strip(' "\t') == "," and a.number != b.number and all(parse_decimal(t) is not None for t in texts):
        numbers = (*((c.constant, b.number) for c in left), *((c.constant, a.number) for c in right))
        what = f"{a.column} and {name_of(b, sources)}"
        yield Change(kind, (Edit(a.span, texts[1]), Edit(b.span, texts[0])), what, numbers)


def text_of(span: Span, sources: Mapping[str, Source]) -> str:
    """What is written in a cell."""
    return sources[span.path].at(span).strip() if span.path in sources else ""


def name_of(cell: Cell, sources: Mapping[str, Source]) -> str:
    """A cell as people know it: `p4 in row LR`."""
    source = sources.get(cell.span.path)
    if source is None:
        return f"{cell.column} in line {cell.row}"
    line = source.line(source.position(cell.span.start)[0])
    return f"{cell.column} in row {line.split(',', 1)[0].strip()}"
