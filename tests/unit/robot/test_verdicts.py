"""Enclosures of the gait on HOAP-2: they contain what the engine computes, are narrow, and say what is known."""

from fractions import Fraction
from functools import cache

import numpy as np
import pytest
from numpy.polynomial import polynomial as poly
from tests.unit.robot.scene import cycle, engine, gait_map, moved, robot

from haverify.robot import mechanics
from haverify.robot.checks import inside, zmp
from haverify.robot.collisions import nearest
from haverify.robot.cycle import Piece
from haverify.robot.enclosures import GRAVITY, QUANTITIES, enclosed_finely, formulated, quantities, tapes
from haverify.robot.mapping import Drive
from haverify.robot.trajectory import Trajectory, sampled
from haverify.robot.verdicts import judged
from haverify.solvers.kernel import Fineness, along
from haverify.text.record import replace

Q = Fraction


@cache
def stretches_of(name):
    return enclosed_finely(tapes(robot(), gait_map(name), cycle(), {}))


@cache
def motion_of(name):
    return moved(gait_map(name), 300)


def seen_by_the_engine(t, motion, speed):
    """What the enclosures enclose, by name: the part of weight at rest, the part of motion at the automaton's pace."""
    is_left = np.array([side == "right" for side in t.stance])[:, None, None]
    swing = np.where(is_left, motion.feet["left"], motion.feet["right"])
    found = {f"sole_{k}_{c}": swing[:, k, i] for k in range(4) for i, c in enumerate("xyz")}
    found |= {f"com_{c}": motion.com[:, i] for i, c in enumerate("xyz")}
    rest = mechanics.moved(engine(), robot(), replace(t, v=0 * t.v, a=0 * t.a))
    wrench, torque = ((x - y) / speed**2 for x, y in ((motion.wrench, rest.wrench), (motion.torque, rest.torque)))
    found |= {f"push_{c}": wrench[:, i] for i, c in enumerate("xyz")}
    force, (ahead, aside) = wrench[:, 2], (-wrench[:, 4], wrench[:, 3])
    (back, front), (right, left) = ([float(v) for v in pair] for pair in (robot().sole.x, robot().sole.y))
    found |= {"tip_front": front * force - ahead, "tip_back": ahead - back * force}
    found |= {"tip_left": left * force - aside, "tip_right": aside - right * force}
    found |= {f"hold_{n}": rest.torque[:, k] for k, n in enumerate(t.joints)}
    return found | {f"move_{n}": torque[:, k] for k, n in enumerate(t.joints)}


@pytest.mark.parametrize("name", ["gait.toml", "gait_mended.toml"])
def test_enclosures_contain_the_engines_values_and_are_narrow(name):
    """At every sample, up to the engine's own rounding.

    Each range of a kinematic quantity, and of what the ground supplies, is at most twice the sampled one; torques are
    no such quantities: where they hardly change they are enclosed no finer than motors need it.
    """
    m = gait_map(name)
    t, motion = motion_of(name)
    stretches = stretches_of(name)
    seen = seen_by_the_engine(t, motion, float(m.speed))
    names = quantities(robot(), m)
    assert set(seen) >= set(names) and len(names) == len(QUANTITIES) + 2 * 13
    starts = {p.mode: float(p.start) for p in cycle().pieces}
    dwell = t.times * float(m.speed) - np.array([starts[mode] for mode in t.modes])
    modes = np.array(t.modes)
    for q in names:
        ends = []
        for mode in starts:
            mine = [s for s in stretches if s.mode == mode]
            low, high = np.array([s.values[q] for s in mine]).T
            k = np.clip(
                np.searchsorted([s.low for s in mine], dwell[modes == mode], side="right") - 1, 0, len(mine) - 1
            )
            values = seen[q][modes == mode]
            slack = 1e-8 * (1 + np.abs(seen[q]).max()) / float(m.speed) ** 2
            assert (low[k] - slack <= values).all() and (values <= high[k] + slack).all(), (q, mode)
            ends += [low.min(), high.max()]
        floor = 0.1 if q.startswith(("hold", "move")) else 1e-6  # N m
        assert max(ends) - min(ends) <= 2 * np.ptp(seen[q]) + floor, q


def test_heights_of_100_000_instants_lie_in_their_enclosures():
    m = gait_map("gait_mended.toml")
    stretches = stretches_of("gait_mended.toml")
    t = sampled(cycle(), replace(m, speed=Q(1)), robot().robot, 84_000)
    assert len(t.times) > 100_000
    for p in cycle().pieces:
        chosen = np.array(t.modes) == p.mode
        corner = lowest_heel(t.q[chosen], t.joints, m.stance[p.mode])
        mine = [s for s in stretches if s.mode == p.mode]
        low, high = np.array([s.values["sole_2_z"] for s in mine]).T
        k = np.searchsorted([s.low for s in mine], t.times[chosen] - float(p.start), side="right") - 1
        k = np.clip(k, 0, len(mine) - 1)
        assert (low[k] - 1e-12 <= corner).all() and (corner <= high[k] + 1e-12).all()


def lowest_heel(q, joints, stance):
    """The height of the swing sole's corner 2 by plane trigonometry: legs lean by the sway, soles stay parallel."""
    angle = dict(zip(joints, q.T, strict=True))
    one, other = (stance[0], "r" if stance == "left" else "l")
    lean = angle[f"{one}_ankle_roll"]

    def reach(side):
        hip, knee = angle[f"{side}_hip_pitch"], angle[f"{side}_knee_pitch"]
        return 0.1 * np.cos(hip) + 0.1 * np.cos(hip + knee)

    return (reach(one) - reach(other)) * np.cos(lean)


def verdicts(m, stretches=None):
    found = judged(robot(), m, cycle(), stretches or enclosed_finely(tapes(robot(), m, cycle(), {})))
    return {d.name: d for d in found}


@cache
def verdicts_of(name):
    return verdicts(gait_map(name), stretches_of(name))


def test_a_motion_in_the_sagittal_plane_leaves_the_sole_sideways_and_sway_mends_it():
    """Without sway 8 mm are missing; 6 deg of sway leave at least 8 mm."""
    still = replace(gait_map("gait_mended.toml"), sway=None, posture=dict.fromkeys(robot().robot.hinges, Q(0)))
    found = verdicts(still)
    assert found["zero moment point sideways"].verdict == "refuted"
    assert found["centre of mass sideways"].verdict == "refuted"
    assert found["centre of mass sideways"].low == pytest.approx(-8, abs=0.6)
    mended = verdicts_of("gait_mended.toml")
    assert mended["zero moment point sideways"].verdict == "proved"
    assert mended["centre of mass sideways"].low == pytest.approx(8.6, abs=0.5)


def test_each_degree_of_sway_moves_the_zero_moment_point_by_some_3_mm():
    base = gait_map("gait_mended.toml")
    slow = replace(base, speed=Q(1, 100))
    points = []
    for roll in (0, 2):
        t, m = moved(replace(slow, sway=replace(base.sway, roll=Q(roll))), 10)
        left = np.array(t.stance) == "left"
        points.append(zmp(m)[left, 1].mean())
    assert (points[1] - points[0]) / 2 == pytest.approx(2.8e-3, abs=0.2e-3)


def test_the_mended_gait_keeps_every_limit_of_the_whole_body():
    assert {d.verdict for d in verdicts_of("gait_mended.toml").values()} == {"proved"}


def test_what_is_refuted_shows_in_samples_and_what_is_proved_does_not():
    for name in ("gait.toml", "gait_mended.toml"):
        _, motion = motion_of(name)
        found = verdicts_of(name)
        points = zmp(motion)
        least = inside(robot(), points).min() * 1000
        if motion.wrench[:, 2].min() <= 0:
            continue  # there is no such point where the ground would have to pull
        both = min(found[f"zero moment point {way}"].low for way in ("fore-aft", "sideways"))
        assert both <= least + 1e-6
        assert (least < 0) == any(
            found[f"zero moment point {w}"].verdict == "refuted" for w in ("fore-aft", "sideways")
        )


def test_gravity_is_the_engines():
    assert float(GRAVITY) == mechanics.GRAVITY == -engine().model.gravity.linear[2]


def test_at_100_random_states_the_engines_values_lie_in_point_enclosures():
    """Waist and legs, each state on cubics of its own at an instant of its own, on either foot.

    To 1e-9 relative, enclosed to 1e-6.
    """
    random = np.random.default_rng(11)
    joints = tuple(robot().robot.hinges)
    moving = [n for n in joints if n.startswith(("waist", "l_hip", "r_hip", "l_knee", "r_knee", "l_ankle", "r_ankle"))]
    drives = tuple(Drive(n, (n,), "rad", Q(1), Q(0), gait_map().drives[0].span) for n in moving)
    free = np.array([n in moving for n in joints])
    for k in range(100):
        side = ("left", "right")[k % 2]
        m = replace(gait_map(), drives=drives, posture={}, sway=None, stance={"M": side}, speed=Q(1))
        cubic, now = free * random.uniform(-1, 1, (4, 25)), random.uniform(-1, 1)
        rows = {n: tuple(Q(float(c)) for c in column) for n, column in zip(joints, cubic.T, strict=True)}
        made = formulated(robot(), m, Piece("M", Q(0), Q(1), rows, ""), {})
        wanted = [1.0] * len(made.names)
        ((_, _, values),) = along(made.positions, made.readout, 2, (now, now), wanted, Fineness(depth=0))
        q, v, a = (poly.polyval(now, poly.polyder(cubic, order)) for order in range(3))
        t = Trajectory(joints, np.zeros(1), q[None], v[None], a[None], ["M"], [side], ())
        seen = seen_by_the_engine(t, mechanics.moved(engine(), robot(), t), 1)
        for name, (low, high) in zip(made.names, values, strict=True):
            slack = 1e-9 * (1 + abs(seen[name][0]))
            assert low - slack <= seen[name][0] <= high + slack, name
            assert high - low <= 1e-6 * (1 + abs(seen[name][0])), name


@pytest.mark.parametrize("name", ["gait.toml", "gait_mended.toml"])
def test_no_sampled_distance_is_below_its_bound(name):
    """The bound is within 2 mm of the least distance that the engine sees."""
    _, motion = motion_of(name)
    found = verdicts_of(name)["self-collision"]
    least = motion.distance.min() * 1000
    assert found.verdict == "proved" and found.low <= least + 1e-3 and least - found.low < 2


def test_an_arm_in_the_leg_is_refuted():
    """Both arms turned back and down, so that the hands stand in the thighs."""
    m = replace(
        gait_map("gait_mended.toml"), posture={**gait_map("gait_mended.toml").posture, "l_shoulder_roll": Q(-20)}
    )
    _, motion = moved(m, 50)
    assert motion.distance.min() < -0.005
    found = nearest(robot(), m, cycle(), {})
    assert max(n.high for n in found) < 0


def test_bounds_hold_at_every_pace_between_the_ends():
    """At the slowest, the fastest and between: the engine's margins are within what is said of all paces."""
    m = gait_map("gait_mended.toml")
    found = verdicts_of("gait_mended.toml")
    for pace in (Q(9, 10), Q(1), Q(11, 10)):
        _, motion = moved(replace(m, speed=m.speed * pace), 100)
        points = zmp(motion)
        low, high = (np.array([float(robot().sole.x[i]), float(robot().sole.y[i])]) for i in (0, 1))
        margin = np.minimum(points - low, high - points).min(axis=0) * 1000
        assert (
            found["zero moment point fore-aft"].low <= margin[0]
            and margin[1] >= found["zero moment point sideways"].low
        )
        assert np.abs(motion.torque).max() <= 9 - found["joint torques"].low
        assert motion.wrench[:, 2].min() >= found["ground pushes"].low
    assert found["ground pushes"].pace == Q(11, 10) and found["ground pushes"].holds == (Q(9, 10), Q(11, 10))


def test_paces_at_which_the_ground_pushes():
    """The gait as printed pushes up to 0.98 of its pace: the engine sees force there and none a little beyond."""
    found = verdicts_of("gait.toml")["ground pushes"]
    assert found.verdict == "refuted" and found.holds[0] == Q(9, 10)
    for pace, sign in ((found.holds[1], 1), (found.holds[1] + Q(1, 50), -1)):
        _, motion = moved(replace(gait_map(), speed=pace), 300)
        assert sign * motion.wrench[:, 2].min() > 0
