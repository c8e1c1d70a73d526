"""Many sampled runs at once, by Dormand and Prince's method of order 8, with jumps where they are due."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import DOP853
from tests.soak.problems import Array, Field, Problem

Ints = NDArray[np.int64]
NEWTON = 6  # steps of Newton's method towards the instant of a jump


def stepped(field: Field, y: Array, h: float | Array) -> Array:
    """States (n, runs) a step of length `h` later, of one length for all runs or of one for each."""
    a, b = DOP853.A, DOP853.B
    slopes = np.empty((len(b), *y.shape))
    for s in range(len(b)):
        slopes[s] = field(y + h * np.tensordot(a[s, :s], slopes[:s], axes=1) if s else y)
    return np.asarray(y + h * np.tensordot(b, slopes, axes=1))


@dataclass
class Jumped:
    """Jumps by one edge (its mode, its number there): runs, jumps made with it, instants, states before and after."""

    edge: tuple[int, int]
    runs: Ints
    count: Ints
    times: Array
    before: Array
    after: Array


@dataclass
class Runs:
    """Where all runs are: states (n, runs), modes, numbers of jumps so far, at one instant."""

    problem: Problem
    states: Array
    modes: Ints
    jumps: Ints
    time: float = 0.0

    def advance(self, h: float) -> Iterator[Jumped]:
        """Follow all runs for `h`; at most one jump each."""
        before, modes = self.states.copy(), self.modes.copy()
        for mode in np.unique(modes):
            own = np.flatnonzero(modes == mode)
            start, field = before[:, own], self.problem.fields[mode]
            after = stepped(field, start, h)
            self.states[:, own] = after
            for number, edge in enumerate(self.problem.edges[mode]):
                first, last = (edge.sign * (s[edge.coordinate] - edge.level) for s in (start, after))
                is_due = (first < 0) & (last >= 0)
                if is_due.any():
                    yield self._jump(field, (int(mode), number), own[is_due], start[:, is_due], h)
        self.time += h

    def _jump(self, field: Field, place: tuple[int, int], runs: Ints, start: Array, h: float) -> Jumped:
        edge = self.problem.edges[place[0]][place[1]]
        dwell = np.full(len(runs), h / 2)
        for _ in range(NEWTON):
            at = stepped(field, start, dwell)
            dwell = np.clip(dwell - (at[edge.coordinate] - edge.level) / field(at)[edge.coordinate], 0.0, h)
        before = stepped(field, start, dwell)
        landed = before.copy()
        for coordinate, factor in edge.factors.items():
            landed[coordinate] = before[coordinate] * factor
        landed[edge.coordinate] = edge.level * edge.factors.get(edge.coordinate, 1.0)
        self.modes[runs] = edge.target
        self.jumps[runs] += 1
        self.states[:, runs] = stepped(self.problem.fields[edge.target], landed, h - dwell)
        return Jumped(place, runs, self.jumps[runs].copy(), self.time + dwell, before, landed)


def starts(box: list[tuple[float, float]], count: int, seed: int) -> Array:
    """Points of a box: three in four from its inside, the others with each coordinate at an end or in the middle."""
    random = np.random.default_rng(seed)
    low, high = np.array(box).T[:, :, None]
    shares = random.random((len(box), count))
    coarse = random.integers(0, 3, (len(box), count)) / 2
    points = np.where(np.arange(count) % 4 == 3, coarse, shares)
    return np.asarray(np.clip(low + points * (high - low), low, high))
