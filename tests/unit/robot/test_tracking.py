"""The joints under their motors' law: as a second engine simulates it, and what is known of it by hand."""

from fractions import Fraction

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from tests.unit.robot.scene import FOLDER, cycle, engine, gait_map, robot

from haverify.robot import mechanics
from haverify.robot.mapping import Servo
from haverify.robot.mechanics import stand
from haverify.robot.tracking import followed
from haverify.robot.trajectory import Trajectory, sampled
from haverify.text.record import replace

Q = Fraction
SERVO = Servo(Q(400), Q(4), Q(2))


def part(t, chosen):
    """Some instants of a trajectory."""
    kept = np.flatnonzero(chosen)
    picked = [values[kept] for values in (t.times, t.q, t.v, t.a)]
    return Trajectory(t.joints, *picked, [t.modes[k] for k in kept], [t.stance[k] for k in kept], ())


def second(names, servo, start, fixed, step):
    """MuJoCo with a motor at each joint, and a foot held by a stiff weld; its state is that of `start`."""
    spec = mujoco.MjSpec.from_file(str(FOLDER / "hoap2.urdf"))
    spec.compiler.fusestatic = False
    spec.option.timestep, spec.option.integrator = step, mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.gravity = [0, 0, -9.81]
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_LIMIT
    spec.body("torso").add_freejoint()
    for name in names:
        for gain, bias in ((servo.kp, [0, -servo.kp, 0]), (servo.kd, [0, 0, -servo.kd])):
            motor = spec.add_actuator(name=f"{name}{len(spec.actuators)}", target=name)
            motor.trntype = mujoco.mjtTrn.mjTRN_JOINT
            motor.biastype = mujoco.mjtBias.mjBIAS_AFFINE
            motor.gainprm[0], motor.biasprm[:3] = float(gain), [float(b) for b in bias]
    held = spec.add_equality(type=mujoco.mjtEq.mjEQ_WELD, name1=fixed, name2="world")
    held.objtype = mujoco.mjtObj.mjOBJ_BODY
    held.solref, held.solimp = [1e-3, 1], [0.999, 0.999, 0.001, 0.5, 2]
    q, v = start
    r = pin.XYZQUATToSE3(q[:7]).rotation
    held.data[:11] = [0, 0, 0, 0, 0, float(robot().sole.z), 1, 0, 0, 0, 1]  # the world, seen from the foot
    model = spec.compile()
    data = mujoco.MjData(model)
    first = engine().model
    data.qpos[:3], data.qpos[3:7] = q[:3], q[[6, 3, 4, 5]]
    data.qvel[:3], data.qvel[3:6] = r @ v[:3], v[3:6]
    for name in names:
        j = first.joints[first.getJointId(name)]
        data.qpos[model.joint(name).qposadr[0]], data.qvel[model.joint(name).dofadr[0]] = q[j.idx_q], v[j.idx_v]
    return model, data


def test_a_second_engine_sees_the_same_errors():
    """The first of mid stance at 5 kHz: every joint strays by the same angle, to 0.02 deg."""
    t = sampled(cycle(), gait_map("gait_mended.toml"), robot().robot, 5000)
    t = part(t, np.array([mode == "MST" for mode in t.modes]) & (t.times < 0.46))
    e = engine()
    at = e.placed(t.joints)
    q, v, a = pin.neutral(e.model), np.zeros(e.model.nv), np.zeros(e.model.nv)
    q[at.q], v[at.v] = t.q[0], t.v[0]
    stand(e, e.feet["right"], pin.SE3(np.eye(3), np.array([0.0, 0.0, -float(robot().sole.z)])), q, v, a)
    mine = np.degrees(followed(e, robot(), t, SERVO) - t.q)
    model, data = second(t.joints, SERVO, (q, v), "r_foot", t.times[1] - t.times[0])
    places = [model.joint(n).qposadr[0] for n in t.joints]
    theirs = np.zeros_like(mine)
    for k in range(1, len(t.times)):
        data.ctrl[0::2], data.ctrl[1::2] = t.q[k], t.v[k]
        mujoco.mj_step(model, data)
        theirs[k] = np.degrees(data.qpos[places] - t.q[k])
    assert np.abs(data.body("r_foot").xpos[:2]).max() < 1e-5
    assert 0.3 < np.abs(mine).max() < 1
    assert np.abs(mine - theirs).max() < 0.02


def test_at_rest_a_joint_gives_way_by_its_torque_over_the_gain():
    """On the left foot, straight, for 2 s: the roll of hip and ankle carries the body."""
    names = tuple(robot().robot.hinges)
    q = np.zeros((400, len(names)))
    t = Trajectory(names, np.arange(400) / 200, q, q, q, ["M"] * 400, ["left"] * 400, ())
    found = followed(engine(), robot(), t, SERVO)[-1:]
    there = Trajectory(names, t.times[:1], found, q[:1], q[:1], ["M"], ["left"], ())
    torque = mechanics.moved(engine(), robot(), there).torque[0]
    assert found[0] == pytest.approx(torque / -400, abs=1e-5)
    assert np.abs(torque).max() > 2


def test_a_motor_gives_no_more_than_it_can():
    """With a weak motor at every joint the body sinks, however high the gain is."""
    names = tuple(robot().robot.hinges)
    q = np.zeros((200, len(names)))
    t = Trajectory(names, np.arange(200) / 1000, q, q, q, ["M"] * 200, ["left"] * 200, ())
    weak = {n: replace(j, limits=replace(j.limits, effort=Q(1))) for n, j in robot().robot.hinges.items()}
    joints = tuple(weak.get(j.name, j) for j in robot().robot.joints)
    feeble = replace(robot(), robot=replace(robot().robot, joints=joints))
    firm = Servo(Q(100_000), Q(1000), Q(2))
    strayed = [np.degrees(np.abs(followed(engine(), d, t, firm)).max()) for d in (robot(), feeble)]
    assert strayed[0] < 0.1 and strayed[1] > 3
