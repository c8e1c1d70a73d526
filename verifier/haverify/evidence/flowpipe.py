"""Flowpipes as far as a drawing shows them: boxes over time, fewer and wider than those that decided a claim.

A JSON value, `haverify.flowpipe/1`: `names` of the state's components, and `pieces`, each with its `mode`, the number
of `jumps` before it, its `start` (a pair for each name) and its `steps` (first and last instant, then a pair for each
name). Numbers are rounded for drawing. Nothing rests on them.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from haverify.text.record import record

Pair = tuple[float, float]
Json = Any

SCHEMA = "haverify.flowpipe/1"
_STEPS = 480  # of all pieces together
_LEAST = 24  # of one piece
_PIECES = 60
_NAMES = 12
_DIGITS = 6


@record
class Stretch:
    """Boxes in one mode: the box at the start, and for each step its instants and the box of its states."""

    mode: str
    jumps: int
    start: Sequence[Pair]
    steps: Sequence[tuple[Pair, Sequence[Pair]]]


def flowpipe_json(names: Sequence[str], stretches: Sequence[Stretch]) -> dict[str, Json]:
    """The value for some stretches; of many the first ones, of many steps hulls of neighbours."""
    shown = [s for s in stretches if s.steps][:_PIECES]
    most = max(_LEAST, _STEPS // max(1, len(shown)))
    return {"schema": SCHEMA, "names": list(names[:_NAMES]), "pieces": [_piece(s, most) for s in shown]}


def _piece(s: Stretch, most: int) -> Json:
    steps = [[*_rounded(time), *(x for pair in box[:_NAMES] for x in _rounded(pair))] for time, box in _fewer(s, most)]
    return {"mode": s.mode, "jumps": s.jumps, "start": [_rounded(p) for p in s.start[:_NAMES]], "steps": steps}


def _fewer(s: Stretch, most: int) -> Iterator[tuple[Pair, list[Pair]]]:
    """Neighbouring steps joined, so that at most about `most` are left, none much longer than the others."""
    first, last = s.steps[0][0][0], s.steps[-1][0][0]
    least = (last - first) / most
    group: list[tuple[Pair, Sequence[Pair]]] = []
    for step in s.steps:
        group.append(step)
        if step[0][0] - group[0][0][0] >= least or len(s.steps) <= most:
            yield _joined(group)
            group = []
    if group:
        yield _joined(group)


def _joined(group: Sequence[tuple[Pair, Sequence[Pair]]]) -> tuple[Pair, list[Pair]]:
    if len(group) == 1:
        return group[0][0], list(group[0][1])
    boxes = [box for _, box in group]
    time = _hull(t for t, _ in group)
    return time, [_hull(box[k] for box in boxes) for k in range(len(boxes[0]))]


def _hull(pairs: Iterable[Pair]) -> Pair:
    listed = list(pairs)
    return min(low for low, _ in listed), max(high for _, high in listed)


def _rounded(pair: Pair) -> list[float]:
    return [float(f"{x:.{_DIGITS}g}") for x in pair]
