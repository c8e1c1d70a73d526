"""A recording of a walk as a trajectory of the robot's joints: splines through its samples, no phases.

Which foot stands is not in a recording of angles: it is the one whose ankle is lower while the pelvis is held still,
with a little persistence so that it does not flicker.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from haverify.robot.body import Robot
from haverify.robot.mapping import Drive, Map
from haverify.robot.mechanics import Engine, heights
from haverify.robot.trajectory import Trajectory, swayed
from haverify.text.record import replace

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

_PERSISTENCE = 0.004  # m, how much lower the other sole must be to become the stance sole


def recorded(
    times: Sequence[float], angles: Mapping[str, Sequence[float]], m: Map, robot: Robot, e: Engine, rate: int = 1000
) -> Trajectory:
    """The recording at `rate` samples a second, at the pace of the map; angles without gaps, as drives name them."""
    import numpy as np

    joints = tuple(robot.hinges)
    pace = float(m.speed)
    start, end = times[0] / pace, times[-1] / pace
    at = np.linspace(start, end, int((end - start) * rate) + 1)
    q, v, a = np.zeros((3, len(at), len(joints)))
    for k, name in enumerate(joints):
        drive = m.drive(name)
        q[:, k] = np.radians(float(m.posture.get(name, 0)))
        if drive is not None:
            for order, target in enumerate((q, v, a)):
                target[:, k] = _driven(drive, times, angles, at * pace, order) * pace**order
    empty = [""] * len(at)
    t = Trajectory(joints, at, q, v, a, empty, empty, ())
    stance = _stance(heights(e, t))
    for k, name in enumerate(joints):
        q[:, k] += np.radians([float(swayed(m, name, side)) for side in stance])
    return replace(t, modes=[f"on {side}" for side in stance], stance=stance)


def _driven(d: Drive, times: Sequence[float], angles: Mapping[str, Sequence[float]], at: Floats, order: int) -> Floats:
    import numpy as np
    from scipy.interpolate import CubicSpline

    total = sum(np.array(angles[name]) for name in d.outputs)
    curve: Floats = CubicSpline(times, total)(at, order)
    in_radians = np.radians(curve) if d.unit == "deg" else curve
    shift = np.radians(float(d.offset)) if order == 0 else 0.0
    driven: Floats = float(d.factor) * in_radians + shift
    return driven


def _stance(low: Mapping[str, Floats]) -> list[str]:
    found = []
    side = "left" if low["left"][0] <= low["right"][0] else "right"
    for left, right in zip(low["left"], low["right"], strict=True):
        if (right if side == "left" else left) < (left if side == "left" else right) - _PERSISTENCE:
            side = "right" if side == "left" else "left"
        found.append(side)
    return found
