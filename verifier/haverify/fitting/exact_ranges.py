"""Least and greatest values of curves and of their speeds, and whether they keep bounds: exactly."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from haverify.fitting.basis import Poly
from haverify.fitting.curve import Curve
from haverify.maths.sturm import extremes
from haverify.maths.univariate import integers

Q = Fraction
_ONE = Q(1)


def extreme(p: Poly, scale: Q = _ONE) -> tuple[Q, Q]:
    """Rational bounds of a polynomial on [0, 1], times a positive `scale`; about 2^-80 wider than its range."""
    whole, factor = integers(p)
    if not whole:
        return Q(0), Q(0)
    least, greatest = extremes(whole, Q(0), _ONE)
    return least.low * factor * scale, greatest.high * factor * scale


def ranges(curve: Curve) -> list[tuple[Q, Q]]:
    """The range of the angle in each phase, in degrees."""
    return [extreme(row) for row in curve.rows]


def outside(curve: Curve, bounds: Sequence[tuple[Q, Q]]) -> list[tuple[int, float, float]]:
    """The phases in which a curve leaves given bounds, with the least and the greatest value there."""
    return [
        (k, float(a), float(b))
        for k, ((a, b), (low, high)) in enumerate(zip(ranges(curve), bounds, strict=True))
        if a < low or b > high
    ]


def steepest(curve: Curve) -> Q:
    """The greatest speed of a curve in degrees a second."""
    slopes = [
        extreme(tuple(i * c for i, c in enumerate(row))[1:], 1 / length)
        for row, length in zip(curve.rows, curve.knots.lengths, strict=True)
    ]
    return max(max(-a, b) for a, b in slopes)
