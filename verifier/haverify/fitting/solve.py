"""Least squares for the curves of a walk, and the choice of their degree."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from haverify.fitting.basis import design, polynomials
from haverify.fitting.bounded import Interval, within
from haverify.fitting.curve import Curve
from haverify.fitting.knots import Knots
from haverify.fitting.percent import POINTS, normalised
from haverify.recordings.cycles import Cycle
from haverify.text.record import record

if TYPE_CHECKING:
    from numpy import ndarray

    Array = ndarray[Any, Any]

Q = Fraction

HIGHEST = 9
NEAR = 0.5
"""Root mean square in degrees to which a curve shall meet the mean cycle, if some degree can."""
_FOLDS = 5
_NO_WORSE = 1.02  # a lower degree is taken whose error is at most so many times the least


@record
class Points:
    """The samples of a joint in floating point: instants (n,), angles (n,), and the part (n,) that each is dealt to.

    `mean` (100,) are the angles of the mean cycle at 0, 1, .. 99 %.
    """

    t: Array
    y: Array
    part: Array
    parts: int
    mean: Array


@record
class Equations:
    """Normal equations: `gram` (p, p), `right` (p,), the sum of squares of the angles and their number."""

    gram: Array
    right: Array
    square: float
    count: int

    def less(self, other: Equations) -> Equations:
        """The equations without the samples of others."""
        rest = self.square - other.square
        return Equations(self.gram - other.gram, self.right - other.right, rest, self.count - other.count)

    def solution(self) -> Array:
        """The unknowns of least squares, columns scaled; of several solutions the shortest.

        The basis is near enough to orthogonal for that: what rounding adds is below a millionth of a degree.
        """
        import numpy as np

        scale = np.sqrt(np.diag(self.gram))
        scale[scale == 0] = 1.0
        found, *_ = np.linalg.lstsq(self.gram / np.outer(scale, scale), self.right / scale, rcond=1e-11)
        return np.asarray(found / scale)

    def error(self, unknowns: Array) -> float:
        """The sum of squared distances of the samples from the curve of some unknowns."""
        return max(0.0, self.square - 2 * float(unknowns @ self.right) + float(unknowns @ self.gram @ unknowns))


def lowest(order: int) -> int:
    """The lowest degree that continuity of an order allows."""
    return 2 * order + 1


def points(cycles: Sequence[Cycle], joint: str, knots: Knots) -> Points:
    """The samples of a joint; cycles are dealt out to up to five parts."""
    import numpy as np

    parts = min(_FOLDS, len(cycles))
    t, y, part = list[float](), list[float](), list[int]()
    for i, c in enumerate(cycles):
        at, angles = c.near[joint]
        t += at
        y += angles
        part += [i % parts] * len(at)
    mean = normalised(cycles, joint).mean(axis=0)[:-1]
    return Points(np.array(t) * float(knots.period), np.array(y), np.array(part), parts, mean)


def curve(p: Points, joint: str, knots: Knots, order: int, degree: int | None, bounds: Interval | None = None) -> Curve:
    """The curve nearest to all samples of a joint, of a degree given or chosen, within bounds if there are any."""
    degree = chosen(p, knots, order) if degree is None else degree
    whole = _sum(_equations(p, knots, order, degree))
    unknowns = whole.solution() if bounds is None else within(whole.gram, whole.right, knots, order, degree, bounds)
    return Curve(joint, knots, order, degree, polynomials(unknowns, knots, order, degree))


def chosen(p: Points, knots: Knots, order: int) -> int:
    """The degree that predicts cycles left out of the fit best; of about equally good ones the lowest.

    Of one or two cycles none can be left out: there the degree is the one of least Bayesian information, among those
    with at least two samples for each unknown. Samples are never left out: neighbours would tell their value. Where
    cycles differ much, both are content with a curve that misses their mean: the next degree that meets it is taken.
    """
    degrees = _allowed(len(p.y), len(knots.lengths), order)
    equations = [_equations(p, knots, order, d) for d in degrees]
    if p.parts < 3:
        scores = [_information(_sum(e)) for e in equations]
        best = scores.index(min(scores))
    else:
        errors = [_predicted(e) for e in equations]
        best = next(k for k, e in enumerate(errors) if e <= _NO_WORSE**2 * min(errors))
    missed = [_missed(p, _sum(e), knots, order, d) for d, e in zip(degrees[best:], equations[best:], strict=True)]
    enough = next((k for k, m in enumerate(missed) if m <= NEAR), missed.index(min(missed)))
    return degrees[best + enough]


def _missed(p: Points, e: Equations, knots: Knots, order: int, degree: int) -> float:
    """The root mean square by which the curve of a degree misses the mean cycle."""
    import numpy as np

    t = np.linspace(0, float(knots.period), POINTS)[:-1]
    return float(np.sqrt(np.mean((design(t, knots, order, degree) @ e.solution() - p.mean) ** 2)))


def _allowed(count: int, phases: int, order: int) -> list[int]:
    """The degrees whose unknowns are at most half of the samples, the lowest in any case."""
    first = lowest(order)
    return [first, *(d for d in range(first + 1, max(HIGHEST, first + 2) + 1) if 2 * phases * (d - order) <= count)]


def _equations(p: Points, knots: Knots, order: int, degree: int) -> list[Equations]:
    """The normal equations of each part."""
    matrix = design(p.t, knots, order, degree)
    found = []
    for k in range(p.parts):
        m, y = matrix[p.part == k], p.y[p.part == k]
        found.append(Equations(m.T @ m, m.T @ y, float(y @ y), len(y)))
    return found


def _sum(parts: Sequence[Equations]) -> Equations:
    total = parts[0]
    for e in parts[1:]:
        total = Equations(total.gram + e.gram, total.right + e.right, total.square + e.square, total.count + e.count)
    return total


def _information(e: Equations) -> float:
    import numpy as np

    spread = max(e.error(e.solution()) / e.count, 1e-6)  # a thousandth of a degree: finer is of no use
    return float(e.count * np.log(spread) + len(e.right) * np.log(e.count))


def _predicted(parts: Sequence[Equations]) -> float:
    """The sum of squared errors in parts that are left out of the fit, in turns."""
    whole = _sum(parts)
    return sum(left.error(whole.less(left).solution()) for left in parts)
