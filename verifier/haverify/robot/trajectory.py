"""Angles, speeds and accelerations of all joints at many instants: of a cycle through a map, or of a recording."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import zip_longest
from typing import TYPE_CHECKING

from haverify.robot.body import Robot
from haverify.robot.cycle import Cycle, Piece
from haverify.robot.mapping import Drive, Map
from haverify.text.record import record

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

Q = Fraction


@record
class Step:
    """What the commands do where one mode ends and the next begins: jumps of angle (rad) and speed (rad/s) by joint."""

    time: float
    before: str
    after: str
    angle: Mapping[str, float]
    speed: Mapping[str, float]


@record
class Trajectory:
    """`n` instants (s) of `m` joints in the order of `joints`: positions, speeds, accelerations, (n, m) in rad and s.

    Each instant has a mode and a stance side; where a mode ends there are two of the same time. Floats throughout.
    """

    joints: tuple[str, ...]
    times: Floats
    q: Floats
    v: Floats
    a: Floats
    modes: list[str]
    stance: list[str]
    steps: tuple[Step, ...]


def sampled(cycle: Cycle, m: Map, robot: Robot, rate: int = 1000) -> Trajectory:
    """One cycle at `rate` samples a second and at both ends of each mode."""
    import numpy as np

    joints = tuple(robot.hinges)
    parts = [_piece(p, m, joints, rate) for p in cycle.pieces]
    times, q, v, a = (np.concatenate([part[k] for part in parts]) for k in range(4))
    counts = [len(part[0]) for part in parts]
    modes = [p.mode for p, n in zip(cycle.pieces, counts, strict=True) for _ in range(n)]
    steps = _steps(cycle, parts, joints)
    return Trajectory(joints, times, q, v, a, modes, [m.stance[mode] for mode in modes], steps)


def _piece(p: Piece, m: Map, joints: tuple[str, ...], rate: int) -> tuple[Floats, Floats, Floats, Floats]:
    """Times, angles, speeds and accelerations over one mode, in the replay's own time."""
    import numpy as np
    from numpy.polynomial import polynomial as poly

    pace = float(m.speed)
    length = float(p.length)
    dwell = np.linspace(0, length, max(2, int(np.ceil(length / pace * rate)) + 1))
    q, v, a = np.zeros((3, len(dwell), len(joints)))
    for k, name in enumerate(joints):
        c = coefficients(p, m, name)
        q[:, k] = poly.polyval(dwell, c)
        v[:, k] = poly.polyval(dwell, poly.polyder(c)) * pace
        a[:, k] = poly.polyval(dwell, poly.polyder(c, 2)) * pace**2
    return (float(p.start) + dwell) / pace, q, v, a


def coefficients(p: Piece, m: Map, joint: str) -> list[float]:
    """The angle (rad) of a joint over a mode as coefficients of powers of the automaton's time."""
    import math

    exact = angle(p, m, joint)
    return [math.radians(c) if is_degrees else float(c) for c, is_degrees in exact] or [0.0]


def angle(p: Piece, m: Map, joint: str) -> list[tuple[Q, bool]]:
    """The same exactly: each coefficient with whether it counts in deg."""
    still = m.posture.get(joint, Q(0)) + swayed(m, joint, m.stance[p.mode])
    drive = m.drive(joint)
    if drive is None:
        return [(still, True)]
    scaled = [c * drive.factor for c in summed(p, drive.outputs)]
    if drive.unit == "rad":
        return _in_radians(scaled, drive)
    return [(scaled[0] + drive.offset, True), *((c, True) for c in scaled[1:])]


def summed(p: Piece, outputs: Sequence[str]) -> list[Q]:
    """The coefficients of a sum of outputs."""
    rows = [p.outputs[name] for name in outputs]
    return [sum(column, Q(0)) for column in zip_longest(*rows, fillvalue=Q(0))]


def _in_radians(scaled: list[Q], drive: Drive) -> list[tuple[Q, bool]]:
    if drive.offset and scaled[0]:
        raise ValueError("an offset in deg and an output in rad: `read_map` refuses this")
    first = (drive.offset, True) if drive.offset else (scaled[0], False)
    return [first, *((c, False) for c in scaled[1:])]


def swayed(m: Map, joint: str, side: str) -> Q:
    """What swaying over the stance side adds to a joint (deg).

    The ground holds the foot: an ankle that rolls by +r about the axis forward leans its shank to the left by r. Both
    ankles roll by so much and both hips back, so the legs stay parallel, the soles flat and the trunk upright.
    """
    if m.sway is None:
        return Q(0)
    lean = m.sway.roll if side == "left" else -m.sway.roll
    if joint in m.sway.ankles.values():
        return lean
    return -lean if joint in m.sway.hips.values() else Q(0)


def _steps(
    cycle: Cycle, parts: list[tuple[Floats, Floats, Floats, Floats]], joints: tuple[str, ...]
) -> tuple[Step, ...]:
    found = []
    for k, (_, q, v, _) in enumerate(parts):
        following = (k + 1) % len(parts)
        angle = dict(zip(joints, (parts[following][1][0] - q[-1]).tolist(), strict=True))
        speed = dict(zip(joints, (parts[following][2][0] - v[-1]).tolist(), strict=True))
        pieces = cycle.pieces
        found.append(Step(float(parts[k][0][-1]), pieces[k].mode, pieces[following].mode, angle, speed))
    return tuple(found)
