"""Where the bodies of a robot are while it moves: each shape's placement in the world at some instants."""

from __future__ import annotations

from typing import TYPE_CHECKING

from haverify.robot.body import Description
from haverify.robot.collisions import Solid, solids
from haverify.robot.mechanics import Engine, stand, states
from haverify.robot.trajectory import Trajectory
from haverify.text.record import record

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]


@record
class Poses:
    """Shapes, and at each instant (s, from the begin) where they are: `placed` (instants, shapes, 4, 4)."""

    solids: list[Solid]
    times: list[float]
    placed: Floats


def poses(e: Engine, d: Description, t: Trajectory, count: int) -> Poses:
    """The shapes at `count` instants evenly over the cycle, its first and last among them; the stance foot rests."""
    import numpy as np

    pin, every = e.pin, solids(d) or []
    chosen = np.linspace(0, len(t.times) - 1, count).round().astype(int)
    q, v, a = states(e, t)
    ground = pin.SE3(np.eye(3), np.array([0.0, 0.0, -float(d.sole.z)]))
    frames = [e.model.getFrameId(s.link) for s in every]
    offsets = [pin.SE3(np.eye(3), np.array([float(c) for c in s.shape.centre])) for s in every]
    placed = np.zeros((count, len(every), 4, 4))
    for row, k in enumerate(chosen):
        stand(e, e.feet[t.stance[k]], ground, q[k], v[k], a[k])
        pin.framesForwardKinematics(e.model, e.data, q[k])
        for i, (frame, offset) in enumerate(zip(frames, offsets, strict=True)):
            placed[row, i] = (e.data.oMf[frame] * offset).homogeneous
    return Poses(every, [float(t.times[k] - t.times[0]) for k in chosen], placed)
