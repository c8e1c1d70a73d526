"""Heel strike and toe-off from the motion of the feet, by two published methods."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, Any

from haverify.recordings.recording import Events, Track

if TYPE_CHECKING:
    from numpy import ndarray

    Array = ndarray[Any, Any]

ZENI = "heel and toe farthest from the pelvis (Zeni 2008)"
VELOCITY = "vertical velocity of the foot (O'Connor 2007)"

_AROUND = 0.02  # seconds on either side of an extreme
_LOW = 0.35  # of the heel's range: a strike happens below


def zeni(track: Track, times: Array, period: float) -> Events:
    """Strikes where the heel is farthest before the pelvis, offs where the toe is farthest behind it.

    Source: J. A. Zeni, J. G. Richards, J. S. Higginson, Two simple methods for determining gait events during treadmill
    and overground walking using kinematic data, Gait & Posture 27, 2008, 710-714 (the coordinate-based method).
    """
    import numpy as np

    heel, toe = _smooth(np.array(track.heel_x), times), -_smooth(np.array(track.toe_x), times)
    strikes, offs = (_instants(peaks(v, times, period), v, times) for v in (heel, toe))
    return Events(strikes, offs, ZENI)


def velocity(track: Track, times: Array, period: float) -> Events:
    """Offs where the middle of the foot rises fastest, strikes where its fall ends while the heel is low.

    A strike is the first minimum of the vertical velocity with the heel in the lowest 35 % of its range.
    Source: C. M. O'Connor, S. K. Thorpe, M. J. O'Malley, C. L. Vaughan, Automatic detection of gait events using
    kinematic data, Gait & Posture 25, 2007, 469-474.
    """
    import numpy as np

    heel, toe = (_smooth(np.array(v), times) for v in (track.heel_y, track.toe_y))
    v = np.gradient((heel + toe) / 2, times)
    low = (heel < np.min(heel) + _LOW * np.ptp(heel)) & (v < 0.25 * np.min(v))
    falls: list[int] = []
    for k in (k for k in range(1, len(v) - 1) if low[k] and v[k - 1] > v[k] <= v[k + 1]):
        if not falls or times[k] - times[falls[-1]] > 0.3 * period:
            falls.append(k)
    return Events(_instants(falls, v, times), _instants(peaks(v, times, period), v, times), VELOCITY)


def _smooth(values: Array, times: Array) -> Array:
    """Means over 30 ms, ends repeated."""
    import numpy as np

    width = max(1, int(0.03 / float(times[1] - times[0])) // 2 * 2 + 1)
    padded = np.pad(values, width // 2, mode="edge")
    return np.convolve(padded, np.ones(width) / width, "valid")


def peaks(values: Array, times: Array, period: float) -> list[int]:
    """Where a value is the largest within 0.3 periods on both sides, ends of the recording left out.

    Of equal ones in a row the first counts.
    """
    import numpy as np

    found: list[int] = []
    inner = np.flatnonzero((values[1:-1] > values[:-2]) & (values[1:-1] >= values[2:])) + 1
    for k in inner:
        a, b = np.searchsorted(times, [times[k] - 0.3 * period, times[k] + 0.3 * period])
        if values[k] >= values[a:b].max() and (not found or times[k] - times[found[-1]] > 0.3 * period):
            found.append(int(k))
    return found


def _instants(at: list[int], values: Array, times: Array) -> tuple[Fraction, ...]:
    """The instants of extremes, to a tenth of a millisecond: those of parabolas through 40 ms around them."""
    import numpy as np

    step = float(times[1] - times[0]) if len(times) > 1 else 1.0
    half = max(1, round(_AROUND / step))
    found = []
    for k in at:
        a, b = max(k - half, 0), min(k + half + 1, len(values))
        x = (times[a:b] - times[k]) / step
        bend, slope, _ = np.polyfit(x, values[a:b], 2) if b - a > 2 else (0.0, 0.0, 0.0)
        shift = -slope / (2 * bend) if bend != 0 else 0.0
        instant = float(times[k]) + min(max(float(shift), -half / 2), half / 2) * step
        found.append(Fraction(round(instant * 10_000), 10_000))
    return tuple(found)
