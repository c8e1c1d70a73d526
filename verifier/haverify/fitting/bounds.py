"""Bounds for a fitted curve from outside the fit: what was recorded, and how far a curve may leave it."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import ceil, floor
from typing import TYPE_CHECKING, Any

from haverify.fitting.curve import Curve, Residual
from haverify.fitting.knots import Knots
from haverify.recordings.cycles import Cycle

if TYPE_CHECKING:
    from numpy import ndarray

    Array = ndarray[Any, Any]

Q = Fraction

FASTER = 1.25  # a curve may be a quarter faster than the recorded steps


def ranges(cycles: Sequence[Cycle], curve: Curve, residual: Residual) -> list[tuple[Q, Q]]:
    """For each phase an interval of tenths of a degree: recorded angles of the phase and of the samples next to it.

    It is widened by the residual and by an eighth of the largest second difference of the recording, which is how far a
    curve may leave the straight line between two samples.
    """
    low, high, bend = _recorded(cycles, curve.joint, curve.knots)
    below, above = (max(float(q), 0.0) for q in (-residual.low, residual.high))
    return [
        (Q(floor((a - above - bend) * 10), 10), Q(ceil((b + below + bend) * 10), 10))
        for a, b in zip(low, high, strict=True)
    ]


def _recorded(cycles: Sequence[Cycle], joint: str, knots: Knots) -> tuple[list[float], list[float], float]:
    import numpy as np

    n = len(knots.lengths)
    low, high, bend = [np.inf] * n, [-np.inf] * n, 0.0
    for c in cycles:
        t, y = _arrays(c, joint, knots)
        if len(y) > 2:
            bend = max(bend, float(np.max(np.abs(np.diff(y, 2)))) / 8)
        for k in range(n):
            first, last = np.searchsorted(t, [float(knots.at[k]), float(knots.at[k + 1])])
            around = np.take(y, range(first - 1, last + 1), mode="wrap")
            low[k], high[k] = min(low[k], float(around.min())), max(high[k], float(around.max()))
    return low, high, bend


def _arrays(c: Cycle, joint: str, knots: Knots) -> tuple[Array, Array]:
    import numpy as np

    at, y = c.near[joint]
    return np.array(at) * float(knots.period), np.array(y)


def fastest(cycles: Sequence[Cycle], curve: Curve) -> Q:
    """A bound for the speed in deg/s: a quarter above the fastest recorded step of at least 15 ms, in tens."""
    import numpy as np

    steepest = 0.0
    for c in cycles:
        t, y = _arrays(c, curve.joint, curve.knots)
        order = np.searchsorted(t, t + 0.015)
        there = order < len(t)
        if there.any():
            steepest = max(steepest, float(np.max(np.abs(y[order[there]] - y[there]) / (t[order[there]] - t[there]))))
    return Q(ceil(steepest * FASTER / 10) * 10)
