"""The robot in motion through Pinocchio: the stance foot lies flat on the ground, the ground supplies what it takes.

At each instant the base is placed so that the stance sole is at rest at the origin; inverse dynamics then tell the
wrench from the ground and the torque of every joint. One foot carries all, also where two touch the ground. Floats:
what is computed here is sampled, and proves nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import combinations
from typing import TYPE_CHECKING, Any

from haverify.errors import UsageError
from haverify.robot.body import NEAR, Description
from haverify.robot.trajectory import Trajectory
from haverify.text.record import holder, record

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

Solver = Callable[..., Any]  # of a positive definite matrix and a right side: LAPACK's dposv
GRAVITY = 9.81  # m/s^2, as Pinocchio has it; kept equal to the enclosures' by a test


@record
class Motion:
    """What happens at `n` instants, in the world whose origin lies under the stance foot's ankle, z up; SI units.

    `wrench` is force and moment about the origin that the ground supplies; `torque` (n, m) as the trajectory's joints;
    `feet` the corners of both soles (n, 4, 3); `swing_speed` that of the swing foot (n, 6) in its own axes; `distance`
    between the nearest two bodies and `nearest` their names; `momentum` about the centre of mass; `points` those of the
    joints (n, m, 3), for drawing; `slip` the greatest speed of the stance foot as inverse dynamics see it.
    """

    com: Floats
    com_speed: Floats
    wrench: Floats
    torque: Floats
    feet: dict[str, Floats]
    swing_speed: Floats
    distance: Floats
    nearest: list[tuple[str, str]]
    momentum: Floats
    points: Floats
    slip: Floats


@record
class Placing:
    """Positions in the engine's vectors of angles and of speeds."""

    q: list[int]
    v: list[int]


@holder
class Engine:
    """Pinocchio's model of a robot, with the indices that are needed."""

    pin: Any
    model: Any
    data: Any
    geometry: Any
    geometry_data: Any
    feet: dict[str, int]
    solve: Solver

    def placed(self, joints: Sequence[str]) -> Placing:
        """Where the engine keeps the angles and the speeds of joints."""
        found = [self.model.joints[self.model.getJointId(name)] for name in joints]
        return Placing([j.idx_q for j in found], [j.idx_v for j in found])


def engine(d: Description) -> Engine:
    """Pinocchio with the robot loaded.

    Raises
    ------
    UsageError      where Pinocchio is not installed, or cannot read the file
    """
    try:
        import pinocchio as pin
        from scipy.linalg.lapack import dposv
    except ImportError:
        raise UsageError(
            "replay needs Pinocchio, which is not installed: pip install 'haverify[robot]', or pip install pin"
        ) from None
    try:
        model = pin.buildModelFromUrdf(d.urdf, pin.JointModelFreeFlyer())
        shapes = pin.buildGeomFromUrdf(model, d.urdf, pin.GeometryType.COLLISION)
    except (ValueError, RuntimeError) as e:
        raise UsageError(f"Pinocchio cannot read {d.urdf}: {' '.join(str(e).split())[:300]}") from None
    bodies = [shape.parentJoint for shape in shapes.geometryObjects]
    for i, k in combinations(range(len(bodies)), 2):
        if _apart(model, bodies[i], bodies[k]) > NEAR:
            shapes.addCollisionPair(pin.CollisionPair(i, k))
    feet = {side: model.frames[model.getFrameId(link)].parentJoint for side, link in d.feet.items()}
    return Engine(pin, model, model.createData(), shapes, pin.GeometryData(shapes), feet, dposv)


def _apart(model: Any, a: int, b: int) -> int:
    """How many joints lie between two bodies."""
    above: dict[int, int] = {}
    for start, steps in ((a, 0), (b, 0)):
        at = start
        while True:
            if at in above and start == b:
                return above[at] + steps
            if start == a:
                above[at] = steps
            if at == 0:
                break
            at, steps = model.parents[at], steps + 1
    return len(model.parents)


def moved(e: Engine, d: Description, t: Trajectory) -> Motion:
    """Follow a trajectory."""
    import numpy as np

    pin, model, data = e.pin, e.model, e.data
    ids = [model.getJointId(name) for name in t.joints]
    at_v, n = e.placed(t.joints).v, len(t.times)
    q, v, a = states(e, t)
    ground = pin.SE3(np.eye(3), np.array([0.0, 0.0, -float(d.sole.z)]))
    names = [g.name.rsplit("_", 1)[0] for g in e.geometry.geometryObjects]
    pairs = [(names[p.first], names[p.second]) for p in e.geometry.collisionPairs]
    com, com_speed, momentum = np.zeros((3, n, 3))
    wrench, swing_speed = np.zeros((2, n, 6))
    slip, distance = np.zeros((2, n))
    torque, points = np.zeros((n, len(ids))), np.zeros((n, len(ids), 3))
    turned, moved_to = {s: np.zeros((n, 3, 3)) for s in e.feet}, {s: np.zeros((n, 3)) for s in e.feet}
    nearest: list[tuple[str, str]] = []
    for k in range(n):
        foot = e.feet[t.stance[k]]
        swing = e.feet["right" if t.stance[k] == "left" else "left"]
        stand(e, foot, ground, q[k], v[k], a[k])
        tau = pin.rnea(model, data, q[k], v[k], a[k])
        pin.computeCentroidalMomentumTimeVariation(model, data, q[k], v[k], a[k])
        wrench[k] = data.oMi[1].act(pin.Force(tau[:6])).vector
        pin.computeJointJacobians(model, data)
        across = pin.getJointJacobian(model, data, foot, pin.ReferenceFrame.WORLD)
        torque[k] = (tau - across.T @ wrench[k])[at_v]
        com[k], com_speed[k], momentum[k] = data.com[0], data.vcom[0], data.hg.angular
        swing_speed[k], slip[k] = data.v[swing].vector, np.abs(data.v[foot].vector).max()
        for side, joint in e.feet.items():
            turned[side][k], moved_to[side][k] = data.oMi[joint].rotation, data.oMi[joint].translation
        for j, i in enumerate(ids):
            points[k, j] = data.oMi[i].translation
        first, distance[k] = _nearest(e)
        nearest.append(pairs[first])
    corners = np.array([[float(c) for c in corner] for corner in d.sole.corners])
    soles = {s: np.einsum("nij,cj->nci", turned[s], corners) + moved_to[s][:, None, :] for s in e.feet}
    return Motion(com, com_speed, wrench, torque, soles, swing_speed, distance, nearest, momentum, points, slip)


def states(e: Engine, t: Trajectory) -> tuple[Floats, Floats, Floats]:
    """Positions, speeds and accelerations as the engine orders them; the base is not placed yet."""
    import numpy as np

    at = e.placed(t.joints)
    q = np.tile(e.pin.neutral(e.model), (len(t.times), 1))
    v, a = np.zeros((2, len(t.times), e.model.nv))
    q[:, at.q], v[:, at.v], a[:, at.v] = t.q, t.v, t.a
    return q, v, a


def stand(e: Engine, foot: int, ground: Any, q: Floats, v: Floats, a: Floats) -> None:
    """Place and move the base, in `q`, `v` and `a`, so that a foot rests on the ground.

    With the base at rest the foot would move by (v_f, a_f) in its own axes; the base has to move the other way, which
    in the base's axes is their image under the foot's placement. No term is missing: the foot's whole speed is zero.
    """
    e.pin.forwardKinematics(e.model, e.data, q, v, a)
    placed = e.data.oMi[foot]
    v[:6] = -placed.act(e.data.v[foot]).vector
    a[:6] = -placed.act(e.data.a[foot]).vector
    q[:7] = e.pin.SE3ToXYZQUAT(ground * placed.inverse())


def _nearest(e: Engine) -> tuple[int, float]:
    """The number of the pair of bodies that is nearest, and its distance, where the engine has placed them."""
    e.pin.updateGeometryPlacements(e.model, e.data, e.geometry, e.geometry_data)
    first = e.pin.computeDistances(e.geometry, e.geometry_data)
    return first, e.geometry_data.distanceResults[first].min_distance


def heights(e: Engine, t: Trajectory) -> dict[str, Floats]:
    """How high each ankle is while the base is held still and upright, by side."""
    import numpy as np

    pin, model, data = e.pin, e.model, e.data
    at_q = e.placed(t.joints).q
    found = {side: np.zeros(len(t.times)) for side in e.feet}
    q = pin.neutral(model)
    for k in range(len(t.times)):
        q[at_q] = t.q[k]
        pin.forwardKinematics(model, data, q)
        for side, joint in e.feet.items():
            found[side][k] = data.oMi[joint].translation[2]
    return found
