"""Tracks of heels and toes from joint angles alone, by a planar leg of average proportions.

The hip is the origin. Lengths as shares of body height: thigh 0.245, shank 0.246, ankle 0.039 above the floor
(R. Drillis, R. Contini, 1966, after D. A. Winter, Biomechanics and Motor Control of Human Movement); the heel is taken
0.04 behind the ankle and the toe 0.11 before it. Instants of extremes depend little on them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from haverify.recordings.recording import Recording, Track

if TYPE_CHECKING:
    from numpy import ndarray

    Array = ndarray[Any, Any]

HEIGHT = 1.75
THIGH, SHANK, ANKLE, BEHIND, BEFORE = (HEIGHT * share for share in (0.245, 0.246, 0.039, 0.04, 0.11))


def tracks(r: Recording, times: Array) -> dict[str, Track]:
    """The tracks at the given instants, missing angles bridged by straight lines."""
    return {side: _track(*(values(r, side + j, times) for j in "hka")) for side in ("l", "r")}


def values(r: Recording, joint: str, times: Array) -> Array:
    """The angles of a joint at some instants, linearly between samples, in degrees."""
    import numpy as np

    y = np.array(r.near[joint])
    there = np.isfinite(y)
    return np.asarray(np.interp(times, np.array(r.clock)[there], y[there])) if there.any() else np.zeros(len(times))


def _track(hip: Array, knee: Array, ankle: Array) -> Track:
    """Forward kinematics of one leg; the height is that over the lowest point of the track."""
    import numpy as np

    thigh, shank = np.radians(hip), np.radians(hip + knee)
    foot = shank + np.radians(ankle)
    x = THIGH * np.sin(thigh) + SHANK * np.sin(shank)
    y = -THIGH * np.cos(thigh) - SHANK * np.cos(shank)
    heel_x, heel_y = x - BEHIND * np.cos(foot) + ANKLE * np.sin(foot), y - BEHIND * np.sin(foot) - ANKLE * np.cos(foot)
    toe_x, toe_y = x + BEFORE * np.cos(foot) + ANKLE * np.sin(foot), y + BEFORE * np.sin(foot) - ANKLE * np.cos(foot)
    return Track(*(tuple(float(v) for v in c) for c in (heel_x, toe_x, heel_y, toe_y)))
