"""Least squares with bounds: the curve nearest to samples among those that stay in a declared interval."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, Any

from haverify.errors import UnsupportedError
from haverify.fitting.basis import design
from haverify.fitting.knots import Knots
from haverify.text.record import record

if TYPE_CHECKING:
    from numpy import ndarray

    Array = ndarray[Any, Any]

_POINTS = 100  # of each phase at which the bounds are kept
_ROOM = 0.02  # degrees by which they are kept, for what lies between the points and for rounding


@record
class Interval:
    """Where a joint has to stay, in degrees."""

    low: Fraction
    high: Fraction


def within(gram: Array, right: Array, knots: Knots, order: int, degree: int, bounds: Interval) -> Array:
    """The unknowns of least squares, given by normal equations, whose curve stays in an interval.

    A quadratic program, solved by interior points (clarabel). The bounds are kept at many points with some room, not
    everywhere: the claim that a spec makes of them is what proves them.

    Raises
    ------
    UnsupportedError    where no curve of this degree can be found
    """
    import clarabel
    import numpy as np
    from scipy import sparse

    t = np.concatenate(
        [np.linspace(float(a), float(b), _POINTS, endpoint=False) for a, b in zip(knots.at, knots.at[1:], strict=False)]
    )
    rows = design(t, knots, order, degree)
    matrix = sparse.csc_matrix(np.vstack([rows, -rows]))
    low, high = float(bounds.low) + _ROOM, float(bounds.high) - _ROOM
    limits = np.concatenate([np.full(len(t), high), np.full(len(t), -low)])
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    quadratic = sparse.triu(sparse.csc_matrix(gram + 1e-9 * np.trace(gram) * np.eye(len(gram))), format="csc")
    cones = [clarabel.NonnegativeConeT(len(limits))]
    answer = clarabel.DefaultSolver(quadratic, -right, matrix, limits, cones, settings).solve()
    if str(answer.status) not in ("Solved", "AlmostSolved"):
        raise UnsupportedError(
            f"no curve of degree {degree} stays in {bounds.low} .. {bounds.high} deg ({answer.status})"
        )
    return np.array(answer.x)
