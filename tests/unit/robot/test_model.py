"""The model of HOAP-2: what its generator makes, its figures, and a second engine's opinion of them."""

import runpy
import tomllib
from fractions import Fraction
from functools import cache
from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from haverify.robot.body import inertia_trouble
from haverify.robot.urdf import read_urdf
from haverify.text.source import Source

FOLDER = Path(__file__).parents[3] / "models" / "hoap2"
FIGURES = tomllib.loads((FOLDER / "robot.toml").read_text())


@cache
def robot():
    made, found = read_urdf(Source.of_text("hoap2.urdf", (FOLDER / "hoap2.urdf").read_text()))
    assert found == []
    return made


@cache
def model():
    return pin.buildModelFromUrdf(str(FOLDER / "hoap2.urdf"), pin.JointModelFreeFlyer())


def standing():
    """All angles zero but the arms hanging; the base at the origin."""
    q = pin.neutral(model())
    for side in "lr":
        q[model().joints[model().getJointId(f"{side}_shoulder_pitch")].idx_q] = np.pi / 2
    return q


def test_the_urdf_is_what_the_generator_makes_of_the_figures():
    made = runpy.run_path(str(FOLDER / "make_urdf.py"))["urdf"](FIGURES)
    assert made == (FOLDER / "hoap2.urdf").read_text()


def test_every_figure_names_a_source_that_is_there():
    known = set(FIGURES["sources"])
    said = [s for part in (*FIGURES["link"], *FIGURES["joint"]) for s in part.get("sources", [part.get("source")])]
    assert len(said) > 50
    assert all(s in known or s.startswith("estimate: ") for s in said)


def test_there_are_25_hinges_and_the_mass_is_as_stated():
    assert len(robot().hinges) == 25
    assert float(robot().mass) == pytest.approx(FIGURES["totals"]["mass"], abs=1e-4)
    assert float(robot().mass) == pytest.approx(pin.computeTotalMass(model()), rel=1e-12)


def test_the_standing_centre_of_mass_is_as_stated():
    """Above the floor, and ahead of the ankle."""
    com = pin.centerOfMass(model(), model().createData(), standing())
    height = 0.055 + 0.2 + 0.0355
    assert com[2] + height == pytest.approx(FIGURES["totals"]["standing_com_height"], abs=1e-4)
    assert com[0] + 0.034 == pytest.approx(FIGURES["totals"]["standing_com_ahead_of_ankle"], abs=1e-4)


def test_every_link_is_a_rigid_body():
    assert [link.name for link in robot().links.values() if inertia_trouble(link)] == []
    for inertia in model().inertias.tolist()[1:]:
        a, b, c = sorted(np.linalg.eigvalsh(inertia.inertia))
        assert a > 0 and a + b > c


def test_no_rigid_body_has_such_an_inertia():
    foot = robot().links["l_foot"]
    for inertia in ([1, 1, 3, 0, 0, 0], [1, 1, 1, 2, 0, 0], [-1, 1, 1, 0, 0, 0]):
        changed = type(foot)("x", foot.mass, foot.com, tuple(map(Fraction, inertia)))
        assert inertia_trouble(changed) != ""


@cache
def second():
    """The same file in MuJoCo, with a free base; contacts and limits do not act."""
    spec = mujoco.MjSpec.from_file(str(FOLDER / "hoap2.urdf"))
    spec.compiler.fusestatic = False
    spec.option.gravity = [0, 0, -9.81]
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    spec.body("torso").add_freejoint()
    return spec.compile()


def test_a_second_engine_agrees_on_mass_centre_of_mass_inverse_dynamics_and_zero_moment_point():
    """At 100 random states, to 1e-6 relative. Both free joints count in axes of their own, so they are translated."""
    first, other = model(), second()
    data, seen = first.createData(), mujoco.MjData(other)
    assert other.body_mass.sum() == pytest.approx(pin.computeTotalMass(first), rel=1e-12)
    names = list(robot().hinges)
    at_q, at_v = ([getattr(first.joints[first.getJointId(n)], k) for n in names] for k in ("idx_q", "idx_v"))
    there_q, there_v = ([other.joint(n).qposadr[0] for n in names], [other.joint(n).dofadr[0] for n in names])
    random = np.random.default_rng(7)
    for _ in range(100):
        q, v, a = pin.neutral(first), random.normal(size=first.nv), 5 * random.normal(size=first.nv)
        turn = random.normal(size=4)
        q[:3], q[3:7], q[at_q] = random.normal(size=3), turn / np.linalg.norm(turn), random.uniform(-1, 1, len(names))
        r = pin.XYZQUATToSE3(q[:7]).rotation
        seen.qpos[:3], seen.qpos[3:7], seen.qpos[there_q] = q[:3], q[[6, 3, 4, 5]], q[at_q]
        seen.qvel[:3], seen.qvel[3:6], seen.qvel[there_v] = r @ v[:3], v[3:6], v[at_v]
        seen.qacc[:3], seen.qacc[3:6], seen.qacc[there_v] = r @ (a[:3] + np.cross(v[3:6], v[:3])), a[3:6], a[at_v]
        mujoco.mj_inverse(other, seen)
        tau = pin.rnea(first, data, q, v, a)
        found = seen.qfrc_inverse
        base = np.concatenate([r.T @ found[:3], found[3:6]])
        assert np.abs(base - tau[:6]).max() <= 1e-6 * np.abs(tau[:6]).max()
        assert np.abs(found[there_v] - tau[at_v]).max() <= 1e-6 * np.abs(tau[at_v]).max()
        assert np.abs(seen.subtree_com[1] - pin.centerOfMass(first, data, q)).max() <= 1e-9
        mine, theirs = (zero_moment_point(w, q[:7]) for w in (tau[:6], base))
        assert np.abs(mine - theirs).max() <= 1e-6 * np.abs(mine).max()


def zero_moment_point(wrench, placement):
    """On the ground, of the wrench on the base in its own axes."""
    w = pin.XYZQUATToSE3(placement).act(pin.Force(wrench)).vector
    return np.array([-w[4], w[3]]) / w[2]
