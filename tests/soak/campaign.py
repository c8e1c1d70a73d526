"""Sampled runs against enclosures: each run inside, at all instants that are looked at, and at each jump.

A run is computed twice, with one step and with two between neighbouring instants. How far both are apart bounds the
error of the better one many times over, and that is all the tolerance there is, besides a share for rounding.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from tests.soak.problems import Array, Problem
from tests.soak.runs import Jumped, Runs, starts

Box = Sequence[tuple[float, float]]
CHUNK = 4000  # runs at a time: what fits a processor's cache
ROUNDING = 1e-13  # relative to the size of a state
LOOKS = 1000  # instants are at least this part of the horizon apart: many stretches have many ends


@dataclass(frozen=True)
class Piece:
    """All states at some instants after so many jumps, in a mode."""

    mode: int
    jumps: int
    time: tuple[float, float]
    box: Box


@dataclass(frozen=True)
class Crossing:
    """All jumps by an edge (its mode, and its number there) as the `jumps`-th: instants, states before and after."""

    edge: tuple[int, int]
    jumps: int
    time: tuple[float, float]
    before: Box
    after: Box


@dataclass(frozen=True)
class Enclosure:
    """What an analysis says of all runs from a box until `until`, and of the states then (`last`, where it says so)."""

    start: Box
    mode: int
    until: float
    pieces: Sequence[Piece]
    crossings: Sequence[Crossing] = ()
    last: Box = ()


@dataclass
class Tally:
    """What was looked at, and what was found outside."""

    runs: int = 0
    looks: int = 0
    jumps: int = 0
    escapes: list[str] = field(default_factory=list)

    def add(self, other: Tally) -> None:
        self.runs += other.runs
        self.looks += other.looks
        self.jumps += other.jumps
        self.escapes += other.escapes


def campaign(problem: Problem, enclosure: Enclosure, count: int, seed: int) -> Tally:
    """Sample `count` runs from the starts of an enclosure and follow them through it."""
    total = Tally()
    for first in range(0, count, CHUNK):
        points = starts(list(enclosure.start)[: problem.size], min(CHUNK, count - first), seed + first)
        total.add(_chunk(problem, enclosure, points))
    return total


def instants(enclosure: Enclosure, longest: float) -> Array:
    """Where to look: at the ends and in the middle of pieces, and never farther apart than `longest`."""
    ends = {t for p in enclosure.pieces for t in (p.time[0], sum(p.time) / 2)} | {0.0, enclosure.until}
    found = [0.0]
    for t in sorted(t for t in ends if 0 < t <= enclosure.until):
        parts = max(1, int(np.ceil((t - found[-1]) / longest)))
        if t - found[-1] > max(1e-9, enclosure.until / LOOKS):
            found += list(np.linspace(found[-1], t, parts + 1)[1:])
    return np.array(found)


def _chunk(problem: Problem, enclosure: Enclosure, points: Array) -> Tally:
    count = points.shape[1]
    rough, fine = (Runs(problem, points.copy(), _full(count, enclosure.mode), _full(count, 0)) for _ in range(2))
    tally = Tally(runs=count)
    lookup = _Lookup(enclosure.pieces)
    _look(lookup, rough, fine, tally)
    for before, after in zip(*(lambda t: (t[:-1], t[1:]))(instants(enclosure, problem.step)), strict=True):
        h = float(after - before)
        crossed = list(rough.advance(h))
        again = [*fine.advance(h / 2), *fine.advance(h / 2)]
        rough.time = fine.time = float(after)
        _look(lookup, rough, fine, tally)
        _look_at_jumps(enclosure, crossed, again, tally)
    if enclosure.last:
        end = Piece(enclosure.mode, 0, (enclosure.until, enclosure.until), enclosure.last)
        _look(_Lookup([end]), rough, fine, tally)
    return tally


def _full(count: int, value: int) -> NDArray[np.int64]:
    return np.full(count, value, dtype=np.int64)


class _Lookup:
    """The pieces by mode and number of jumps."""

    def __init__(self, pieces: Sequence[Piece]) -> None:
        self.by_place: dict[tuple[int, int], list[Piece]] = {}
        for p in pieces:
            self.by_place.setdefault((p.mode, p.jumps), []).append(p)
        self.times = {k: np.array([p.time for p in ps]) for k, ps in self.by_place.items()}

    def at(self, mode: int, jumps: int, time: float) -> list[Piece]:
        """The pieces that hold an instant."""
        place = (mode, jumps)
        if place not in self.times:
            return []
        low, high = self.times[place].T
        slack = 1e-12 * (1 + abs(time))
        return [self.by_place[place][k] for k in np.flatnonzero((low - slack <= time) & (time <= high + slack))]


def _slack(rough: Array, fine: Array) -> Array:
    return np.asarray(np.abs(rough - fine) + ROUNDING * (1 + np.abs(fine)))


def _inside(states: Array, slack: Array, boxes: Sequence[Box]) -> NDArray[np.bool_]:
    """Which states (n, runs) lie in at least one of some boxes."""
    found = np.zeros(states.shape[1], dtype=bool)
    for box in boxes:
        low, high = np.array(box)[: len(states)].T[:, :, None]
        found |= ((low - slack <= states) & (states <= high + slack)).all(axis=0)
    return found


def _look(lookup: _Lookup, rough: Runs, fine: Runs, tally: Tally) -> None:
    """All runs at one instant; those of which one version has jumped already are looked at later."""
    alike = (rough.modes == fine.modes) & (rough.jumps == fine.jumps)
    slack = _slack(rough.states, fine.states)
    for mode, jumps in np.unique(np.stack([fine.modes[alike], fine.jumps[alike]]), axis=1).T:
        own = np.flatnonzero(alike & (fine.modes == mode) & (fine.jumps == jumps))
        pieces = lookup.at(int(mode), int(jumps), fine.time)
        is_inside = _inside(fine.states[:, own], slack[:, own], [p.box for p in pieces])
        tally.looks += len(own)
        for k in own[~is_inside][:1]:
            state = ", ".join(f"{x:.17g}" for x in fine.states[:, k])
            tally.escapes.append(f"t = {fine.time!r}, mode {mode}, {jumps} jumps: {state} ({(~is_inside).sum()} runs)")


def _look_at_jumps(enclosure: Enclosure, crossed: list[Jumped], again: list[Jumped], tally: Tally) -> None:
    """Jumps that both versions make in the same step: instant, states before and after in one crossing."""
    for one in again:
        for other in (o for o in crossed if o.edge == one.edge):
            _, a, b = np.intersect1d(one.runs, other.runs, return_indices=True)
            better = np.vstack([one.times[None, a], one.before[:, a], one.after[:, a]])
            slack = _slack(np.vstack([other.times[None, b], other.before[:, b], other.after[:, b]]), better)
            for count in np.unique(one.count[a]):
                own = one.count[a] == count
                known = [c for c in enclosure.crossings if c.edge == one.edge and c.jumps == count]
                boxes = [[c.time, *c.before[: len(one.before)], *c.after[: len(one.after)]] for c in known]
                is_inside = _inside(better[:, own], slack[:, own], boxes)
                tally.jumps += int(own.sum())
                if not is_inside.all():
                    first = better[:, own][:, ~is_inside][:, 0]
                    tally.escapes.append(f"jump {count} by edge {one.edge}: t = {first[0]!r}, {first[1:]}")
