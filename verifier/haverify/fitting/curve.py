"""A joint angle over the cycle as the polynomials that are written: exact values, and exact distances from samples."""

from __future__ import annotations

from collections.abc import Sequence
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


def value(p: Poly, u: Q) -> Q:
    """A polynomial at a point, exactly."""
    total = Q(0)
    for c in reversed(p):
        total = total * u + c
    return total


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
        return value(self.rows[k], (t - self.knots.at[k]) / self.knots.lengths[k])

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


def residual(curve: Curve, cycles: Sequence[Cycle], rounding: Q = _NO_ROUNDING) -> Residual:
    """The distances of all samples of some cycles from a curve.

    They are computed in floating point, and again exactly where they come within the error of the extremes. Angles that
    were rounded when read widen the interval by that.
    """
    import numpy as np

    near = [c.near[curve.joint] for c in cycles]
    t = np.concatenate([np.array(at) for at, _ in near] or [np.zeros(0)]) * float(curve.knots.period)
    if not len(t):
        return Residual(Q(0), Q(0), 0.0, 0)
    off = np.concatenate([np.array(y) for _, y in near]) - curve.at(t)
    error = _error(curve)
    extreme = np.flatnonzero((off <= off.min() + 2 * error) | (off >= off.max() - 2 * error))
    exact = [_exactly(curve, cycles, near, int(k)) for k in extreme]
    return Residual(min(exact) - rounding, max(exact) + rounding, float(np.sqrt(np.mean(off**2))), len(t))


def farthest(curve: Curve, cycles: Sequence[Cycle]) -> list[tuple[int, int]]:
    """The samples (cycle, index) that lie farthest below and above a curve, up to rounding."""
    import numpy as np

    found = []
    for n, c in enumerate(cycles):
        at, y = c.near[curve.joint]
        there = [i for i, v in enumerate(c.angles[curve.joint]) if v is not None]
        off = np.array(y) - curve.at(np.array(at) * float(curve.knots.period))
        if there:
            found += [(float(off[k]), (n, there[int(k)])) for k in (off.argmin(), off.argmax())]
    return [min(found)[1], max(found)[1]] if found else []


def _exactly(curve: Curve, cycles: Sequence[Cycle], near: Sequence[tuple[Sequence[float], ...]], k: int) -> Q:
    """The distance of the k-th sample of all from the curve."""
    for c, (at, _) in zip(cycles, near, strict=True):
        if k < len(at):
            there = [i for i, v in enumerate(c.angles[curve.joint]) if v is not None]
            share, angle = c.at[there[k]], c.angles[curve.joint][there[k]]
            return (angle or Q(0)) - curve.value(share * curve.knots.period)
        k -= len(at)
    raise IndexError(k)


def _error(curve: Curve) -> float:
    """More than what rounding in floating point does to a distance.

    Local time is off by less than 1e-12 (instants below 10 s, phases above 1 ms), so a value by less than 1e-12 times
    the sum of i |c_i|, and Horner's scheme adds less than 2 (degree + 1) units of rounding of the sum of |c_i|. At a
    boundary the wrong phase may be taken: there both agree, and their slopes differ by no more than the sums of two.
    """
    steepest = max(sum((i + 1) * abs(float(c)) for i, c in enumerate(row)) for row in curve.rows)
    return 1e-9 * (1.0 + steepest)
