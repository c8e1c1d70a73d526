"""Long lines broken where the language lets a line go on: before `and`, `or` and the like, after commas."""

from __future__ import annotations

import re

LONGEST_LINE = 120
CONTINUATION = "    "
BREAK = re.compile(r'"[^"]*"|[([{]|[)\]}]|, | (?=(?:and|or|implies|when|do|then|else) )')


def wrap(text: str, indent: str) -> list[str]:
    """`text` on one line, or broken at the outermost places that make it fit if any do."""
    if len(indent + text) <= LONGEST_LINE:
        return [indent + text]
    lines: list[str] = []
    rest, first = text, True
    while True:
        prefix = indent if first else indent + CONTINUATION
        cut = _cut(rest, LONGEST_LINE - len(prefix))
        if cut is None:
            return [*lines, prefix + rest]
        lines.append((prefix + rest[:cut]).rstrip())
        rest, first = rest[cut:].lstrip(), False


def _cut(text: str, room: int) -> int | None:
    """The last of the outermost places within `room` to break at, the first outside it when there is none."""
    if len(text) <= room:
        return None
    places = _places(text)
    within = [(depth, -place) for depth, place in places if place <= room]
    if within:
        return -min(within)[1]
    return min((place for _, place in places), default=None)


def _places(text: str) -> list[tuple[int, int]]:
    """Depth in brackets and offset of every place at which a line may end."""
    places, depth = [], 0
    for found in BREAK.finditer(text):
        mark = found[0]
        if mark in "([{":
            depth += 1
        elif mark in ")]}":
            depth -= 1
        elif not mark.startswith('"'):
            places.append((depth, found.end()))
    return places
