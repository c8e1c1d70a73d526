"""A joint angle over the cycle as the polynomials that are written: exact values, and exact distances from samples."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from haverify.fitting.basis import Poly, local
from haverify.fitting.knots import Knots
from haverify.recordings.cycles import Cycle
from haverify.text.record import record

if TYPE_CHECKING:
    from numpy import ndarray

    Array = ndarray[Any, Any]

Q = Fraction

_NO_ROUNDING = Q(0)


@record
class Curve:
    """The polynomials of a joint, one per phase, in local time u = (t - begin) / length; degrees."""

    joint: str
    knots: Knots
    order: int
    degree: int
    rows: tuple[Poly, ...]

    def value(self, t: Q) -> Q:
        """The angle at an instant in [0, period], exactly."""
        k = self.knots.phase(t)
        u = (t - self.knots.at[k]) / self.knots.lengths[k]
        total = Q(0)
        for c in reversed(self.rows[k]):
            total = total * u + c
        return total

    def jump(self, derivative: int = 0) -> Q:
        """The largest step of a derivative by time at a boundary of phases, the end of the cycle included, exactly."""
        n, steps = len(self.rows), []
        for k in range(n):
            after = (k + 1) % n
            here = _derivative(self.rows[k], derivative, Q(1)) / self.knots.lengths[k] ** derivative
            there = _derivative(self.rows[after], derivative, Q(0)) / self.knots.lengths[after] ** derivative
            steps.append(abs(here - there))
        return max(steps)

    def at(self, t: Array, derivative: int = 0) -> Array:
        """Angles, or derivatives by time, at some instants, in floating point."""
        import numpy as np

        phase, u = local(t, self.knots)
        found = np.zeros(len(t))
        for k, row in enumerate(self.rows):
            here = phase == k
            p = np.array([float(c) for c in row])
            for _ in range(derivative):
                p = np.polynomial.polynomial.polyder(p)
            found[here] = np.polynomial.polynomial.polyval(u[here], p) / float(self.knots.lengths[k]) ** derivative
        return found


def _derivative(p: Poly, order: int, u: Q) -> Q:
    for _ in range(order):
        p = tuple(i * c for i, c in enumerate(p))[1:]
    return sum((c * u**i for i, c in enumerate(p)), Q(0))


@record
class Residual:
    """How far samples lie from a curve: `low <= sample - curve <= high` holds for all, exactly; `rms` is near."""

    low: Q
    high: Q
    rms: float
    count: int


def samples(cycles: Iterable[Cycle], joint: str) -> tuple[list[Q], list[Q]]:
    """The shares of the cycle and the angles of all samples of a joint that are there."""
    at, angles = [], []
    for c in cycles:
        for share, angle in zip(c.at, c.angles[joint], strict=True):
            if angle is not None:
                at.append(share)
                angles.append(angle)
    return at, angles


def residual(curve: Curve, at: Sequence[Q], angles: Sequence[Q], rounding: Q = _NO_ROUNDING) -> Residual:
    """The distances of samples from a curve.

    They are computed in floating point, and again exactly where they come within the error of the extremes. Angles that
    were rounded when read widen the interval by that.
    """
    import numpy as np

    if not at:
        return Residual(Q(0), Q(0), 0.0, 0)
    t = np.array([float(x) for x in at]) * float(curve.knots.period)
    off = np.array([float(a) for a in angles]) - curve.at(t)
    error = _error(curve)
    low = [_exactly(curve, at[k], angles[k]) for k in map(int, np.flatnonzero(off <= off.min() + 2 * error))]
    high = [_exactly(curve, at[k], angles[k]) for k in map(int, np.flatnonzero(off >= off.max() - 2 * error))]
    return Residual(min(low) - rounding, max(high) + rounding, float(np.sqrt(np.mean(off**2))), len(at))


def _exactly(curve: Curve, share: Q, angle: Q) -> Q:
    return angle - curve.value(share * curve.knots.period)


def _error(curve: Curve) -> float:
    """More than what rounding in floating point does to a distance.

    Local time is off by less than 1e-12 (instants below 10 s, phases above 1 ms), so a value by less than 1e-12 times
    the sum of i |c_i|, and Horner's scheme adds less than 2 (degree + 1) units of rounding of the sum of |c_i|. At a
    boundary the wrong phase may be taken: there both agree, and their slopes differ by no more than the sums of two.
    """
    steepest = max(sum((i + 1) * abs(float(c)) for i, c in enumerate(row)) for row in curve.rows)
    return 1e-9 * (1.0 + steepest)
