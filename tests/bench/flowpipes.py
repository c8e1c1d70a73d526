"""What an analysis asks of the kernel: every flowpipe that is computed, with the box it starts from."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any
from unittest.mock import patch

from haverify import _kernel

Pair = tuple[float, float]
Box = list[Pair]


@dataclass(frozen=True)
class Segment:
    """A step: instants from somewhere in `start` on for `length`, and the box of all states in it."""

    start: Pair
    length: float
    states: Box


@dataclass(frozen=True)
class Call:
    """A flowpipe: its box of starts, its steps, the box at the horizon (empty if it did not come there)."""

    box: Box
    horizon: Pair
    segments: list[Segment]
    last: Box

    @property
    def is_point(self) -> bool:
        """Whether it is the flowpipe of one start (of an enclosure of it)."""
        return all(high - low <= 1e-12 * max(1.0, abs(low)) for low, high in self.box)


class Enough(Exception):
    """As many flowpipes as wanted are there; ends the analysis that computes them."""


@contextmanager
def recorded(most: int | None = None) -> Iterator[list[Call]]:
    """All flowpipes computed in this context, in order; `Enough` is raised after `most` of wide boxes."""
    calls: list[Call] = []
    original = _kernel.flowpipe

    def flowpipe(flow: Any, box: Box, horizon: Pair, *rest: Any) -> Any:
        found = original(flow, box, horizon, *rest)
        segments = [Segment(row[0], row[1], row[2]) for row in found[0]]
        calls.append(Call(list(box), horizon, segments, found[2]))
        if most is not None and sum(not c.is_point for c in calls) >= most:
            raise Enough
        return found

    with patch.object(_kernel, "flowpipe", flowpipe):
        yield calls


def leaves(calls: list[Call]) -> list[Call]:
    """The flowpipes of boxes that were not cut further."""
    wide = [c for c in calls if not c.is_point] or calls
    return [c for c in wide if not any(_is_part(other.box, c.box) for other in wide)]


def _is_part(inner: Box, outer: Box) -> bool:
    """Whether a box is a proper part of another."""
    inside = all(a >= low and b <= high for (a, b), (low, high) in zip(inner, outer, strict=True))
    return inside and inner != outer


def ends(calls: list[Call]) -> Box | None:
    """The least box around the last states of all uncut boxes; None where one did not come to the horizon."""
    last = [c.last for c in leaves(calls)]
    if not last or not all(last):
        return None
    return [(min(low for low, _ in v), max(high for _, high in v)) for v in zip(*last, strict=True)]
