"""What an analysis asks of the kernel: every tree of stretches, with the box it starts from."""

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
class Stretch:
    """Flow in a mode after so many jumps, and how it ends.

    `edge` is the number, in the mode of `parent`, of the edge it came by; `jump` has instants, states before and after.
    """

    mode: int
    jumps: int
    parent: int | None
    edge: int | None
    jump: tuple[Pair, Box, Box] | None
    segments: list[Segment]
    end: str


@dataclass(frozen=True)
class Call:
    """A tree of stretches: its box of starts, all its steps, the box at the horizon (empty if it jumps before)."""

    box: Box
    horizon: Pair
    segments: list[Segment]
    last: Box
    mode: int
    tree: tuple[Stretch, ...]

    @property
    def is_point(self) -> bool:
        """Whether it is the flowpipe of one start (of an enclosure of it)."""
        return all(high - low <= 1e-12 * max(1.0, abs(low)) for low, high in self.box)


class Enough(Exception):
    """As many flowpipes as wanted are there; ends the analysis that computes them."""


@contextmanager
def recorded(most: int | None = None) -> Iterator[list[Call]]:
    """All that is computed in this context, in order; `Enough` is raised after `most` of wide boxes."""
    calls: list[Call] = []
    original = _kernel.reach

    def reach(modes: Any, start: Any, horizon: float, *rest: Any) -> Any:
        tree = original(modes, start, horizon, *rest)
        found = tree.rows()
        stretches = tuple(_stretch(*row) for row in found)
        steps = [g for s in stretches for g in s.segments]
        last = found[0][7] if len(found) == 1 else []
        calls.append(Call(list(start[1]), (horizon, horizon), steps, last, start[0], stretches))
        if most is not None and sum(not c.is_point for c in calls) >= most:
            raise Enough
        return tree

    with patch.object(_kernel, "reach", reach):
        yield calls


def _stretch(parent: int | None, mode: int, jumps: int, _: bool, jump: Any, steps: Any, end: str, *__: Any) -> Stretch:
    segments = [Segment((row[0][0], row[0][0]), row[0][1] - row[0][0], row[1]) for row in steps]
    made = None if jump is None else (jump[1], jump[2], jump[3])
    return Stretch(mode, jumps, parent, None if jump is None else jump[0], made, segments, end)


def leaves(calls: list[Call]) -> list[Call]:
    """The flowpipes of boxes that were not cut further."""
    wide = [c for c in calls if not c.is_point] or calls
    return [c for c in wide if not any(_is_part(other.box, c.box) for other in wide)]


def impacts(calls: list[Call]) -> dict[str, Pair]:
    """For each number of jumps, instants (`t1`) and the states before it (`before1 0`, by coordinate), as hulls."""
    found: dict[str, Pair] = {}
    for s in (s for c in leaves(calls) for s in c.tree):
        if s.jump is None:
            continue
        time, before, _ = s.jump
        for key, (low, high) in [(f"t{s.jumps}", time), *((f"before{s.jumps} {k}", x) for k, x in enumerate(before))]:
            a, b = found.get(key, (low, high))
            found[key] = min(a, low), max(b, high)
    return found


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
