"""How many standard deviations a further curve may lie from the mean of n curves: at a point, and along all of it."""

from __future__ import annotations

from collections.abc import Callable
from math import inf, pi, sqrt
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from numpy import ndarray

    Array = ndarray[Any, Any]

LEVEL = 0.95
_STEPS = 200


def at_a_point(n: int) -> float:
    """Student's t of 95 % with n - 1 degrees of freedom, times sqrt(1 + 1/n) for what n curves do not tell of the mean.

    The classical prediction interval of a further observation from a normal population.
    """
    from scipy.special import stdtrit  # slow to load, and mostly there are too few cycles

    return float(stdtrit(n - 1, (1 + LEVEL) / 2)) * sqrt(1 + 1 / n)


def along_a_curve(n: int, rough: float, samples: int) -> float:
    """The same for a whole curve: 95 % of further ones stay inside everywhere.

    Distance over deviation is a field of Student's t along the cycle. The chance that it exceeds a level somewhere is
    at most the chance at a point plus the expected number of crossings, which follows from the roughness of the
    curves; and at most the sum of the chances at each of the `samples` of a cycle. The smaller level counts.
    Sources: K. J. Worsley et al., Human Brain Mapping 4, 1996, 58-73 (Euler characteristic of t fields); S. J. Kiebel
    et al., NeuroImage 10, 1999, 756-766 (roughness from residuals); T. C. Pataky, Journal of Biomechanics 43, 2010,
    1976-1982 (gait). Pointwise bands hold far fewer whole curves than samples: M. W. Lenhoff et al., Gait & Posture 9,
    1999, 10-17.
    """
    from scipy.special import stdtr, stdtrit

    freedom = n - 1

    def chance(t: float) -> float:
        crossings = rough / (2 * pi) * float((1 + t * t / freedom) ** (-(freedom - 1) / 2))
        return 2 * (float(stdtr(freedom, -t)) + crossings)

    smooth = _falling(chance, 1 - LEVEL) if freedom > 1 else inf
    single = float(stdtrit(freedom, 1 - (1 - LEVEL) / (2 * max(samples, 1))))
    return min(smooth, single) * sqrt(1 + 1 / n)


def roughness(curves: Array) -> float:
    """The length of the path that the curves' normalised residuals take on the unit sphere, in radians."""
    import numpy as np

    off = curves - curves.mean(axis=0)
    unit = off / np.maximum(np.sqrt((off**2).sum(axis=0)), 1e-9)
    return float(np.sqrt((np.diff(unit, axis=1) ** 2).sum(axis=0)).sum())


def _falling(chance: Callable[[float], float], level: float) -> float:
    """Where a falling function of positive numbers comes down to a level, from above."""
    low, high = 0.0, 1.0
    while chance(high) > level and high < 1e9:
        low, high = high, 2 * high
    for _ in range(_STEPS):
        middle = (low + high) / 2
        low, high = (middle, high) if chance(middle) > level else (low, middle)
    return high
