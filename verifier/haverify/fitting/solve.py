"""Least squares for the curves of a walk, and the choice of their degree."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from haverify.fitting.basis import design, polynomials
from haverify.fitting.curve import Curve, samples
from haverify.fitting.knots import Knots
from haverify.recordings.cycles import Cycle

if TYPE_CHECKING:
    from numpy import ndarray

    Array = ndarray[Any, Any]

Q = Fraction

HIGHEST = 7
_FOLDS = 5
_NO_WORSE = 1.02  # a lower degree is taken whose error is at most so many times the least


def lowest(order: int) -> int:
    """The lowest degree that continuity of an order allows."""
    return 2 * order + 1


def solve(cycles: Sequence[Cycle], joint: str, knots: Knots, order: int, degree: int) -> Curve:
    """The curve nearest to all samples of a joint in some cycles."""
    t, y = _arrays(cycles, joint, knots)
    unknowns = _least(design(t, knots, order, degree), y)
    return Curve(joint, knots, order, degree, polynomials(unknowns, knots, order, degree))


def _arrays(cycles: Sequence[Cycle], joint: str, knots: Knots) -> tuple[Array, Array]:
    import numpy as np

    at, angles = samples(cycles, joint)
    return np.array([float(x) for x in at]) * float(knots.period), np.array([float(a) for a in angles])


def _least(matrix: Array, y: Array) -> Array:
    """The solution of least squares by its normal equations, columns scaled; of several the shortest.

    The basis is near enough to orthogonal for that: what rounding adds is below a millionth of a degree.
    """
    import numpy as np

    scale = np.sqrt((matrix**2).sum(axis=0))
    scale[scale == 0] = 1.0
    scaled = matrix / scale
    found, *_ = np.linalg.lstsq(scaled.T @ scaled, scaled.T @ y, rcond=1e-11)
    return np.asarray(found / scale)


def degree(cycles: Sequence[Cycle], joint: str, knots: Knots, order: int) -> int:
    """The degree that predicts cycles left out of the fit best; of about equally good ones the lowest.

    Of one or two cycles none can be left out: there the degree is the one of least Bayesian information, among those
    with at least two samples for each unknown. Samples are never left out: neighbours would tell their value.
    """
    degrees = _allowed(cycles, joint, knots, order)
    if len(degrees) < 2:
        return degrees[0]
    errors = [_predicted(cycles, joint, knots, order, d) for d in degrees] if len(cycles) > 2 else None
    if errors is None:
        scores = [_information(cycles, joint, knots, order, d) for d in degrees]
        return degrees[scores.index(min(scores))]
    return next(d for d, e in zip(degrees, errors, strict=True) if e <= _NO_WORSE * min(errors))


def _allowed(cycles: Sequence[Cycle], joint: str, knots: Knots, order: int) -> list[int]:
    """The degrees whose unknowns are at most half of the samples, the lowest in any case."""
    count, n = len(samples(cycles, joint)[0]), len(knots.lengths)
    first = lowest(order)
    return [first, *(d for d in range(first + 1, max(HIGHEST, first + 2) + 1) if 2 * n * (d - order) <= count)]


def _information(cycles: Sequence[Cycle], joint: str, knots: Knots, order: int, d: int) -> float:
    import numpy as np

    t, y = _arrays(cycles, joint, knots)
    matrix = design(t, knots, order, d)
    rest = y - matrix @ _least(matrix, y)
    spread = max(float(np.mean(rest**2)), 1e-6)  # a thousandth of a degree: finer is of no use
    return float(len(y) * np.log(spread) + matrix.shape[1] * np.log(len(y)))


def _predicted(cycles: Sequence[Cycle], joint: str, knots: Knots, order: int, d: int) -> float:
    """The root mean square error in cycles that are left out of the fit, in turns."""
    import numpy as np

    folds = min(_FOLDS, len(cycles))
    squares, count = 0.0, 0
    for fold in range(folds):
        kept = [c for i, c in enumerate(cycles) if i % folds != fold]
        t, y = _arrays(kept, joint, knots)
        unknowns = _least(design(t, knots, order, d), y)
        t, y = _arrays([c for i, c in enumerate(cycles) if i % folds == fold], joint, knots)
        rest = y - design(t, knots, order, d) @ unknowns
        squares, count = squares + float(rest @ rest), count + len(y)
    return float(np.sqrt(squares / max(count, 1)))
