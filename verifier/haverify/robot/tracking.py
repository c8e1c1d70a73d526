"""How far a robot under a proportional-derivative law strays from the angles it is asked for. Floats: a simulation.

The stance foot is fixed to the ground, so the joints' angles alone are the state. Every joint has a motor whose torque
is `kp (asked angle - angle) + kd (asked speed - speed)`, at most the joint's effort; gravity is not compensated. The
law is evaluated at the end of each step, to first order (J. Tan, K. Liu, G. Turk, Stable proportional-derivative
controllers, 2011), which is stable for light links too. Where the feet change the robot starts anew as commanded.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from haverify.robot.body import Description
from haverify.robot.mapping import Servo
from haverify.robot.mechanics import Engine, Solver, stand
from haverify.robot.trajectory import Trajectory

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

_ROUNDS = 4  # of finding the motors that give all they can


def followed(e: Engine, d: Description, t: Trajectory, servo: Servo) -> Floats:
    """The joints' angles (n, m) in rad under the law, at the instants of a trajectory and in its order."""
    import numpy as np

    at = e.placed(t.joints)
    order = np.argsort(at.v)  # the engine's own order of joints
    ground = e.pin.SE3(np.eye(3), np.array([0.0, 0.0, -float(d.sole.z)]))
    efforts = [limits.effort for name in t.joints if (limits := d.robot.hinges[name].limits)]
    most = np.array([float(x) for x in efforts])[order]
    asked, pace = t.q[:, order], t.v[:, order]
    seen, rates = asked.copy(), pace.copy()
    kp, kd = float(servo.kp), float(servo.kd)
    for k in range(len(t.times) - 1):
        if t.stance[k + 1] == t.stance[k]:
            h = t.times[k + 1] - t.times[k]
            mass, bias = _dynamics(e, e.feet[t.stance[k]], ground, seen[k], rates[k])
            pull = kp * (asked[k + 1] - seen[k] - h * rates[k]) + kd * (pace[k + 1] - rates[k])
            rates[k + 1] = rates[k] + h * _accelerated(e.solve, mass, bias, pull, h * kd, most)
            seen[k + 1] = seen[k] + h * rates[k + 1]
    found: Floats = seen[:, np.argsort(order)]
    return found


def _accelerated(solve: Solver, mass: Floats, bias: Floats, pull: Floats, damping: float, most: Floats) -> Floats:
    """Accelerations under torques `pull - damping * acceleration`, cut at `most`."""
    import numpy as np

    cut, main = np.zeros(len(most)), mass.diagonal().copy()
    a = cut
    for _ in range(_ROUNDS):
        np.fill_diagonal(mass, main + damping * (cut == 0))
        _, a, _ = solve(mass, np.where(cut, cut * most, pull) - bias)  # solves it: the matrix is positive definite
        torque = pull - damping * a
        beyond = np.sign(torque) * (np.abs(torque) > most)
        if (beyond == cut).all():
            break
        cut = beyond
    return a


def _dynamics(e: Engine, foot: int, ground: object, q: Floats, v: Floats) -> tuple[Floats, Floats]:
    """The matrix of inertia of the joints alone, the foot being held, and what gravity and motion ask of them.

    The base moves as the joints make it: `X` times their speeds, X from the foot's Jacobian.
    """
    import numpy as np

    pin, model, data = e.pin, e.model, e.data
    pose, speed = np.concatenate([np.zeros(6), [1.0], q]), np.concatenate([np.zeros(6), v])
    still = np.zeros(model.nv)
    stand(e, foot, ground, pose, speed, still)
    tau = pin.rnea(model, data, pose, speed, still)
    whole = pin.crba(model, data, pose)
    held = pin.computeJointJacobian(model, data, pose, foot)
    x = -data.oMi[1].actInv(data.oMi[foot]).action @ held[:, 6:]
    cross = x.T @ whole[:6, 6:]
    mass = whole[6:, 6:] + cross + cross.T + x.T @ whole[:6, :6] @ x
    return mass, tau[6:] + x.T @ tau[:6]
