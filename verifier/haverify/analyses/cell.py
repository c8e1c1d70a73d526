"""A cell: a box of entry states of a mode, and how long a run may stay in it; an exit: an edge that leaves it."""

from __future__ import annotations

from fractions import Fraction

from haverify.analyses.bounds import Box, Interval
from haverify.text.record import holder, record

Q = Fraction


@holder
class Cell:
    """One cell; `sigma` is the scaled time at entry where time is followed, `parent` the first way into it."""

    mode: int
    entry: Box
    sigma: Interval | None
    jumps: int | None
    dwell: Q | None = None
    parent: tuple[int, int] | None = None  # cell, edge
    depth: int = 0
    joins: int = 0


@record
class Exit:
    """An edge taken out of a cell: during which scaled dwells, from which box, into which box, at which
    scaled times."""

    edge: int
    dwell: tuple[Q, Q | None]
    before: Box
    after: Box
    sigma: Interval | None


def moved(entry: Interval, slope: Q, first: Q, last: Q | None) -> Interval:
    """The values `e + slope * s` for `e` in the entry interval and `first <= s <= last`."""
    if not slope:
        return entry
    low = None if entry.low is None else entry.low + slope * first
    high = None if entry.high is None else entry.high + slope * first
    if slope > 0:
        return Interval(low, None if entry.high is None or last is None else entry.high + slope * last)
    return Interval(None if entry.low is None or last is None else entry.low + slope * last, high)
