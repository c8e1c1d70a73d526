"""Cycles by percent: the angles of each at 0, 1, .. 100 % of it, between samples and at the nearest ones."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from haverify.recordings.cycles import Cycle
from haverify.text.record import record

if TYPE_CHECKING:
    from numpy import ndarray

    Array = ndarray[Any, Any]

POINTS = 101


def normalised(cycles: Sequence[Cycle], joint: str) -> Array:
    """The angles of each cycle at 0, 1, .. 100 % (cycles, 101), linearly between samples, round from end to begin."""
    import numpy as np

    grid = np.linspace(0, 1, POINTS)
    found = []
    for c in cycles:
        at, y = c.near[joint]
        found.append(np.interp(grid, np.array(at), np.array(y), period=1.0))
    return np.array(found)


@record
class Percents:
    """Cycles of a joint: `between` (cycles, 101) linearly between samples, `nearest` (cycles, 101) with samples' noise.

    A nearest sample is moved along the mean curve to its percent, no more: the straight line between two samples would
    have less noise than either. `unit[i]` is the recording or the cycle that counts once, `samples` are of a cycle.
    """

    joint: str
    between: Array
    nearest: Array
    unit: Array
    samples: int

    @property
    def count(self) -> int:
        return int(self.unit.max()) + 1 if len(self.unit) else 0

    def where(self, kept: Array) -> Percents:
        """The cycles of some units, numbered anew."""
        import numpy as np

        _, unit = np.unique(self.unit[kept], return_inverse=True)
        return Percents(self.joint, self.between[kept], self.nearest[kept], unit, self.samples)


def percents(cycles: Sequence[Cycle], joint: str) -> Percents:
    """Cycles by percent. Of three or more recordings each is a unit: cycles of one are alike; else each cycle is."""
    import numpy as np

    between = normalised(cycles, joint)
    origins = list(dict.fromkeys(c.origin for c in cycles))
    unit = [origins.index(c.origin) for c in cycles] if len(origins) > 2 else list(range(len(cycles)))
    mean = between.mean(axis=0) if len(cycles) else np.zeros(POINTS)
    nearest = np.array([_nearest(c, joint, mean) for c in cycles])
    samples = int(np.median([len(c.at) for c in cycles])) if len(cycles) else 0
    return Percents(joint, between, nearest, np.array(unit), samples)


def _nearest(c: Cycle, joint: str, mean: Array) -> Array:
    import numpy as np

    grid = np.linspace(0, 1, POINTS)
    at, y = map(np.array, c.near[joint])
    at, y = np.concatenate([at[-1:] - 1, at, at[:1] + 1]), np.concatenate([y[-1:], y, y[:1]])
    k = np.clip(np.searchsorted(at, grid), 1, len(at) - 1)
    k = np.where(grid - at[k - 1] < at[k] - grid, k - 1, k)
    return np.asarray(y[k] + mean - np.interp(at[k] % 1, grid, mean))
