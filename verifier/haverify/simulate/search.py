"""The search for a run that violates a formula: evenly spread draws, corners, then evolution from the best of them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from time import process_time
from typing import Any

from haverify.text.record import holder, record

Point = tuple[float, ...]
Values = Callable[[Sequence[Point]], list[float]]

SPREAD = 64  # evenly spread points, and half as many corners
AT_ONCE = 0.2  # s of runs between two looks at the clock
WIDE, NARROW = 0.3, 0.05  # first steps of evolution: far from the best point, and near it


@record
class Found:
    """The best point, its value, and how many runs were simulated until it was found."""

    point: Point
    value: float
    runs: int


@holder
class _Best:
    """What has been looked at so far."""

    values: Values
    budget: int
    enough: float
    end: float  # of the processor's time
    runs: int = 0
    found: Found | None = None
    pace: float = 1.0  # s for a run, as far as is known

    def look(self, points: Sequence[Point]) -> list[float]:
        """The values of as many of the points as the budget of runs and the time allow."""
        points = points[: max(self.budget - self.runs, 0)]
        values: list[float] = []
        while len(values) < len(points) and not self.is_late:
            count = max(1, int(AT_ONCE / self.pace))
            values += self._looked(points[len(values) : len(values) + count])
        return values

    def _looked(self, points: Sequence[Point]) -> list[float]:
        start = process_time()
        values = self.values(points)
        self.pace = max((process_time() - start) / len(points), 1e-6)
        for k, (p, v) in enumerate(zip(points, values, strict=True)):
            if self.found is None or v < self.found.value:
                self.found = Found(p, v, self.runs + k + 1)
        self.runs += len(points)
        return values

    @property
    def is_late(self) -> bool:
        return process_time() >= self.end

    @property
    def is_over(self) -> bool:
        return self.runs >= self.budget or self.is_late or (self.found is not None and self.found.value < self.enough)


def least(
    values: Values, dimension: int, budget: int, seed: int, enough: float, end: float = math.inf
) -> tuple[Found | None, int]:
    """The least value found, and how many runs that took; over once a value is below `enough`, or it is `end`."""
    best = _Best(values, budget, enough, end)
    for points in _first(dimension, seed):
        best.look(points)
        if best.is_over:
            return best.found, best.runs
    turn = 0
    while not best.is_over and best.found is not None:
        _evolve(best, dimension, NARROW if turn % 3 == 2 else WIDE, seed + turn)
        turn += 1
    return best.found, best.runs


def _first(dimension: int, seed: int) -> Iterator[list[Point]]:
    """Batches of evenly spread points and of corners."""
    from scipy.stats import qmc

    points = qmc.Sobol(dimension, seed=seed).random(SPREAD)
    for start in range(0, SPREAD, 16):
        yield [tuple(float(x) for x in p) for p in points[start : start + 16]]
    yield [(0.5, *[x] * (dimension - 1)) for x in (0.0, 1.0)]
    yield [(0.5, *(float(x > 0.5) for x in p[1:])) for p in points[: SPREAD // 2]]


def _evolve(best: _Best, dimension: int, step: float, seed: int) -> None:
    """One course of covariance matrix adaptation from the best point."""
    cma = _cma()
    assert best.found is not None
    told = {"seed": seed + 1, "verbose": -9, "bounds": [0, 1], "maxfevals": max(best.budget - best.runs, 1)}
    if dimension < 2:
        _scan(best, step)
        return
    evolution = cma.CMAEvolutionStrategy(list(best.found.point), step, told)
    while not evolution.stop() and not best.is_over:
        points = [tuple(float(x) for x in p) for p in evolution.ask()]
        values = best.look(points)
        if len(values) < len(points):
            return
        evolution.tell(points, values)


def _cma() -> Any:
    """The library, without what it says about drawing."""
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import cma
    return cma


def _scan(best: _Best, step: float) -> None:
    """One coordinate alone: points around the best one."""
    assert best.found is not None
    middle = best.found.point[0]
    best.look([(min(max(middle + step * (k - 8) / 8, 0.0), 1.0),) for k in range(17)])
