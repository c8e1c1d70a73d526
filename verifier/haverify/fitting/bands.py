"""Bands around a joint's curve: mean +- k standard deviations over cycles, and the thesis' difference of two fits.

Both come with the share of samples they hold; of held-out cycles where there are any, since a band holds what it was
made of too well.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from haverify.fitting.knots import Knots
from haverify.recordings.cycles import Cycle
from haverify.text.record import record

if TYPE_CHECKING:
    from numpy import ndarray

    Array = ndarray[Any, Any]

POINTS = 101
LEVEL = 0.95


@record
class Band:
    """`mean` and `sd` (101,) of `count` cycles or recordings by percent; the band reaches `k` deviations each way."""

    joint: str
    mean: Array
    sd: Array
    k: float
    count: int

    @property
    def low(self) -> Array:
        return self.mean - self.k * self.sd

    @property
    def high(self) -> Array:
        return self.mean + self.k * self.sd


@record
class Coverage:
    """The shares of samples, and of whole cycles, inside a band."""

    samples: float
    cycles: float


def normalised(cycles: Sequence[Cycle], joint: str) -> Array:
    """The angles of each cycle at 0, 1, .. 100 % (cycles, 101), linearly between samples, round from end to begin."""
    import numpy as np

    grid = np.linspace(0, 1, POINTS)
    found = []
    for c in cycles:
        at, y = c.near[joint]
        found.append(np.interp(grid, np.array(at), np.array(y), period=1.0))
    return np.array(found)


def band(cycles: Sequence[Cycle], joint: str) -> Band | None:
    """The band of 95 % for a further cycle, by Student's t at each percent; None of fewer than three cycles.

    k = t * sqrt(1 + 1/n) accounts for what n cycles do not tell of mean and deviation. Of three or more recordings it
    is the band for a further recording: each counts once, by its mean, since cycles of one are alike.
    """
    import numpy as np

    origins = list(dict.fromkeys(c.origin for c in cycles))
    curves = normalised(cycles, joint)
    if len(origins) > 2:
        curves = np.array([curves[[c.origin == o for c in cycles]].mean(axis=0) for o in origins])
    n = len(curves)
    if n < 3:
        return None
    from scipy.special import stdtrit  # slow to load, and mostly there are fewer

    k = float(stdtrit(n - 1, (1 + LEVEL) / 2)) * float(np.sqrt(1 + 1 / n))
    return Band(joint, curves.mean(axis=0), curves.std(axis=0, ddof=1), k, n)


def coverage(b: Band, cycles: Sequence[Cycle]) -> Coverage:
    """How much of some cycles a band holds."""
    import numpy as np

    grid = np.linspace(0, 1, POINTS)
    inside = []
    for c in cycles:
        at, y = map(np.array, c.near[b.joint])
        inside.append((np.interp(at, grid, b.low) <= y) & (y <= np.interp(at, grid, b.high)))
    every = np.concatenate(inside)
    return Coverage(float(every.mean()), float(np.mean([i.all() for i in inside])))


@record
class Difference:
    """The band between fits of degree 4 and of degree 2, phase by phase: its mean width, the share of samples in it."""

    joint: str
    width: float
    samples: float


def difference(cycles: Sequence[Cycle], joint: str, knots: Knots) -> Difference:
    """The thesis' band (section 5.14): the difference of fits of degree 4 and 2 on either side of the one of degree 4.

    Each phase is fitted by itself. A phase with fewer than six samples has no such band and counts as outside.
    """
    import numpy as np

    t = np.concatenate([np.array(c.near[joint][0]) for c in cycles]) * float(knots.period)
    y = np.concatenate([np.array(c.near[joint][1]) for c in cycles])
    widths, inside = [], 0
    for a, b in zip(knots.at, knots.at[1:], strict=False):
        here = (float(a) <= t) & (t < float(b))
        u, v = (t[here] - float(a)) / float(b - a), y[here]
        if len(u) < 6:
            continue
        four, two = (np.polyval(np.polyfit(u, v, d), u) for d in (4, 2))
        inside += int((np.abs(v - four) <= np.abs(four - two)).sum())
        widths.append(float(np.abs(four - two).mean()))
    return Difference(joint, float(np.mean(widths or [0.0])), inside / max(len(y), 1))


def csv(bands: Sequence[Band]) -> str:
    """The bands of some joints, by percent, to a thousandth of a degree."""
    labels = ",".join(f"{b.joint}_{side}" for b in bands for side in ("low", "high"))
    rows = [
        ",".join([str(p), *(_text(x) for b in bands for x in (float(b.low[p]), float(b.high[p])))])
        for p in range(POINTS)
    ]
    return "\n".join([f"percent,{labels}", *rows]) + "\n"


def _text(x: float) -> str:
    return str(float(Fraction(round(x * 1000), 1000)))
