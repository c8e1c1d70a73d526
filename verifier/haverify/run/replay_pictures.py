"""The pictures of a replay, each with its caption."""

from __future__ import annotations

from haverify.report.figures import robot as robot_figures
from haverify.robot import filming, mechanics
from haverify.robot.body import Description
from haverify.robot.trajectory import Trajectory

_FRAMES = 56  # of the moving picture


def pictures(d: Description, t: Trajectory, m: mechanics.Motion) -> list[tuple[str, str]]:
    """Stick figures, the moving one, the zero moment point, the joints."""
    film = filmed(d, t, m)
    return [
        ("The robot in each phase.", robot_figures.strip(film)),
        ("One cycle, at the replay's own pace.", robot_figures.moving(film)),
        ("The zero moment point in the stance sole; red where it leaves it.", robot_figures.soles(film)),
        ("The joints over the cycle, with their limits.", robot_figures.joints(film)),
    ]


def filmed(d: Description, t: Trajectory, m: mechanics.Motion) -> robot_figures.Film:
    """What the pictures show."""
    frames = []
    for shot in filming.shots(d, t, m, _FRAMES):
        k = shot.number
        com = (0.0, 0.0, float(m.com[k, 2]))
        frames.append(robot_figures.Frame(float(t.times[k]), t.modes[k], t.stance[k], shot.limbs, shot.soles, com))
    step = max(1, len(t.times) // 1200)
    curves = [
        robot_figures.Curve(name, "deg", values[::step], ends, {})
        for name, (values, ends) in filming.moving_joints(d, t).items()
    ]
    flat = [(float(x), float(y)) for x, y in m.com[::step, :2]]
    sole = ((float(d.sole.x[0]), float(d.sole.x[1])), (float(d.sole.y[0]), float(d.sole.y[1])))
    return robot_figures.Film(
        t.times[::step].tolist(),
        t.modes[::step],
        t.stance[::step],
        frames,
        filming.points(m)[::step],
        flat,
        sole,
        curves,
    )
