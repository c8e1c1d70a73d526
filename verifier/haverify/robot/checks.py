"""What a robotics engineer looks at in a replay, each with its worst instant. Sampled: tells, and proves nothing."""

from __future__ import annotations

from typing import TYPE_CHECKING

from haverify.robot.body import Description
from haverify.robot.mapping import Servo
from haverify.robot.mechanics import GRAVITY, Motion
from haverify.robot.trajectory import Trajectory
from haverify.text.record import record

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

_MM = 1000.0


@record
class Followed:
    """The angles (n, m) in rad that the joints take under the motors' law."""

    q: Floats
    servo: Servo


@record
class Sampled:
    """A quantity at its worst sampled instant (s). `margin` is the signed distance to `limit`; None: there is none."""

    name: str
    what: str  # the joint, the side, the bodies
    value: float
    limit: float | None
    margin: float | None
    unit: str
    time: float
    mode: str
    note: str = ""
    advice: bool = False  # the limit is a placeholder


def checked(d: Description, t: Trajectory, m: Motion, followed: Followed) -> list[Sampled]:
    """Every check, in the order of the table."""
    found = [_positions(d, t), _speeds(d, t), _torques(d, t, m), _power(t, m), *_continuity(t)]
    found += [_upright(t, m), *_feet(t, m), *_ground(d, t, m), _bodies(t, m), _capture(d, t, m), _momentum(t, m)]
    return [*found, *_impact(t, m), _tracking(d, t, followed)]


def margins(d: Description, t: Trajectory, m: Motion) -> dict[str, dict[str, float]]:
    """For each joint that moves the least margins: `position` in deg, `speed` in rad/s, `torque` in N m."""
    import numpy as np

    low, high, speed, effort = _limits(d, t)
    table = {}
    for k, name in enumerate(t.joints):
        if np.ptp(t.q[:, k]) > 0:
            position = min((t.q[:, k] - low[k]).min(), (high[k] - t.q[:, k]).min())
            table[name] = {
                "position": float(np.degrees(position)),
                "speed": float(speed[k] - np.abs(t.v[:, k]).max()),
                "torque": float(effort[k] - np.abs(m.torque[:, k]).max()),
            }
    return table


def _limits(d: Description, t: Trajectory) -> tuple[Floats, Floats, Floats, Floats]:
    import numpy as np

    known = [limits for name in t.joints if (limits := d.robot.hinges[name].limits)]
    rows = [[float(x) for x in (i.lower, i.upper, i.velocity, i.effort)] for i in known]
    low, high, speed, effort = np.array(rows).T
    return low, high, speed, effort


def _at(t: Trajectory, k: int) -> tuple[float, str]:
    return float(t.times[k]), t.modes[k]


def _worst(margin: Floats) -> tuple[int, int]:
    import numpy as np

    row, column = np.unravel_index(np.argmin(margin), margin.shape)
    return int(row), int(column)


def _positions(d: Description, t: Trajectory) -> Sampled:
    import numpy as np

    low, high, _, _ = _limits(d, t)
    margin = np.degrees(np.minimum(t.q - low, high - t.q))
    k, j = _worst(margin)
    near = low[j] if t.q[k, j] - low[j] < high[j] - t.q[k, j] else high[j]
    value, limit = np.degrees([t.q[k, j], near]).tolist()
    return Sampled("joint position", t.joints[j], value, limit, float(margin[k, j]), "deg", *_at(t, k))


def _speeds(d: Description, t: Trajectory) -> Sampled:
    import numpy as np

    _, _, most, _ = _limits(d, t)
    margin = most - np.abs(t.v)
    k, j = _worst(margin)
    note = d.advice_because if d.advice else ""
    value = float(abs(t.v[k, j]))
    return Sampled(
        "joint speed", t.joints[j], value, float(most[j]), float(margin[k, j]), "rad/s", *_at(t, k), note, d.advice
    )


def _torques(d: Description, t: Trajectory, m: Motion) -> Sampled:
    import numpy as np

    _, _, _, most = _limits(d, t)
    margin = most - np.abs(m.torque)
    k, j = _worst(margin)
    note = d.advice_because if d.advice else ""
    value = float(abs(m.torque[k, j]))
    return Sampled(
        "joint torque", t.joints[j], value, float(most[j]), float(margin[k, j]), "N m", *_at(t, k), note, d.advice
    )


def _power(t: Trajectory, m: Motion) -> Sampled:
    import numpy as np

    each = np.abs(m.torque * t.v)
    k, j = _worst(-each)
    span = t.times[-1] - t.times[0]
    mean = float(np.trapezoid(each.sum(axis=1), t.times) / span)
    note = f"all joints together {mean:.1f} W on average"
    return Sampled("power", t.joints[j], float(each[k, j]), None, None, "W", *_at(t, k), note)


def _continuity(t: Trajectory) -> list[Sampled]:
    import math

    found = []
    for name, unit, factor, kind in (
        ("step of angle", "deg", math.degrees(1), "angle"),
        ("step of speed", "rad/s", 1.0, "speed"),
    ):
        every = [
            (abs(size) * factor, joint, step)
            for step in t.steps
            for joint, size in (step.angle if kind == "angle" else step.speed).items()
        ]
        if every:
            size, joint, step = max(every, key=lambda e: e[0])
            found.append(Sampled(name, joint, size, None, None, unit, step.time, f"{step.before} -> {step.after}"))
    return found


def _upright(t: Trajectory, m: Motion) -> Sampled:
    """How far the swing sole is from lying flat where it becomes the stance sole: the whole body turns by so much."""
    import numpy as np

    worst = (0.0, 0)
    for k in _switches(t):
        corners = m.feet[t.stance[k + 1]][k]
        normal = np.cross(corners[1] - corners[2], corners[3] - corners[2])
        angle = float(np.degrees(np.arccos(np.clip(normal[2] / np.linalg.norm(normal), -1, 1))))
        worst = max(worst, (angle, k))
    return Sampled(
        "sole at touchdown",
        "tilt",
        worst[0],
        None,
        None,
        "deg",
        *_at(t, worst[1]),
        "the body turns by it at the switch",
    )


def _switches(t: Trajectory) -> list[int]:
    """The last instants before the stance foot changes; the cycle is closed."""
    return [k for k in range(len(t.times) - 1) if t.stance[k] != t.stance[k + 1]]


def _swing(t: Trajectory, m: Motion) -> Floats:
    """The corners of the swing sole (n, 4, 3)."""
    import numpy as np

    is_left = np.array([side == "right" for side in t.stance])
    return np.where(is_left[:, None, None], m.feet["left"], m.feet["right"])


def _feet(t: Trajectory, m: Motion) -> list[Sampled]:
    import numpy as np

    corners = _swing(t, m)
    lowest = corners[:, :, 2].min(axis=1) * _MM
    k = int(np.argmin(lowest))
    stance = m.feet["left"] + m.feet["right"] - corners
    ahead = (corners - stance).mean(axis=1)[:, 0]
    passing = np.flatnonzero((np.diff(np.sign(ahead)) != 0) & (np.diff(t.times) > 0))
    found = [
        Sampled("swing sole above ground", "lowest corner", float(lowest[k]), 0.0, float(lowest[k]), "mm", *_at(t, k))
    ]
    if len(passing):
        p = int(passing[np.argmin(lowest[passing])])
        value = float(lowest[p])
        found.append(Sampled("swing clearance", "where feet pass", value, None, None, "mm", *_at(t, p)))
    s = int(np.argmax(m.slip))
    found.append(
        Sampled(
            "stance sole at rest",
            "speed",
            float(m.slip[s]) * _MM,
            1e-6,
            1e-6 - float(m.slip[s]) * _MM,
            "mm/s",
            *_at(t, s),
        )
    )
    return found


def zmp(m: Motion) -> Floats:
    """The zero moment point on the ground (n, 2), in m from the stance ankle's foot point."""
    import numpy as np

    moment: Floats = np.stack([-m.wrench[:, 4], m.wrench[:, 3]], axis=1)
    point: Floats = moment / m.wrench[:, 2:3]
    return point


def inside(d: Description, points: Floats) -> Floats:
    """The signed distance (m) of points (n, 2) to the edge of the stance sole; negative outside."""
    import numpy as np

    low, high = (np.array([float(d.sole.x[i]), float(d.sole.y[i])]) for i in (0, 1))
    within = np.minimum(points - low, high - points)
    outside = np.linalg.norm(np.minimum(within, 0), axis=1)
    distance: Floats = np.where(outside > 0, -outside, within.min(axis=1))
    return distance


def _ground(d: Description, t: Trajectory, m: Motion) -> list[Sampled]:
    import numpy as np

    force = m.wrench[:, 2]
    pull = int(np.argmin(force))
    along = np.linalg.norm(m.wrench[:, :2], axis=1)
    need = np.where(force > 0, along / np.maximum(force, 1e-9), np.inf)
    slip = int(np.argmax(need))
    mu = float(d.friction)
    found = [Sampled("ground pushes", "normal force", float(force[pull]), 0.0, float(force[pull]), "N", *_at(t, pull))]
    found.append(
        Sampled("friction cone", "coefficient", float(need[slip]), mu, mu - float(need[slip]), "", *_at(t, slip))
    )
    for name, points in (("zero moment point", zmp(m)), ("centre of mass over sole", m.com[:, :2])):
        margin = inside(d, points) * _MM
        k = int(np.argmin(margin))
        x, y = points[k] * _MM
        text = f"x {x:.1f} y {y:.1f}"
        found.append(
            Sampled(name, "to the sole's edge", float(margin[k]), 0.0, float(margin[k]), "mm", *_at(t, k), text)
        )
    return found


def _bodies(t: Trajectory, m: Motion) -> Sampled:
    import numpy as np

    k = int(np.argmin(m.distance))
    value = float(m.distance[k]) * _MM
    return Sampled("self-collision", " and ".join(m.nearest[k]), value, 0.0, value, "mm", *_at(t, k))


def _capture(d: Description, t: Trajectory, m: Motion) -> Sampled:
    """Where a foot would have to stand for the body to come to rest, as a linear inverted pendulum."""
    import numpy as np

    omega = np.sqrt(GRAVITY / m.com[:, 2:3])
    points = m.com[:, :2] + m.com_speed[:, :2] / omega
    margin = inside(d, points) * _MM
    k = int(np.argmin(margin))
    x, y = points[k] * _MM
    return Sampled(
        "capture point", "to the sole's edge", float(margin[k]), None, None, "mm", *_at(t, k), f"x {x:.1f} y {y:.1f}"
    )


def _momentum(t: Trajectory, m: Motion) -> Sampled:
    import numpy as np

    size = np.linalg.norm(m.momentum, axis=1)
    k = int(np.argmax(size))
    return Sampled("angular momentum", "about the centre of mass", float(size[k]), None, None, "N m s", *_at(t, k))


def _impact(t: Trajectory, m: Motion) -> list[Sampled]:
    """How fast the ankle of the landing foot still moves when it becomes the stance foot."""
    import numpy as np

    every = [(float(np.linalg.norm(m.swing_speed[k, :3])), k) for k in _switches(t)]
    if not every:
        return []
    speed, k = max(every)
    return [Sampled("impact at touchdown", "speed of the ankle", speed, None, None, "m/s", *_at(t, k))]


def _tracking(d: Description, t: Trajectory, f: Followed) -> Sampled:
    """How far a joint is from the angle that it is asked for."""
    import numpy as np

    error, most = np.degrees(np.abs(f.q - t.q)), float(f.servo.tolerance)
    k, j = _worst(-error)
    value = float(error[k, j])
    law = f"kp {float(f.servo.kp):g} N m/rad, kd {float(f.servo.kd):g} N m s/rad, no more than the joint's torque"
    return Sampled("tracking error", t.joints[j], value, most, most - value, "deg", *_at(t, k), law, d.advice)
