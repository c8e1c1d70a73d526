"""A replay as points and curves to draw, and beside it the recording it stems from."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import product
from typing import TYPE_CHECKING

from haverify.robot.body import Description
from haverify.robot.checks import zmp
from haverify.robot.mechanics import Motion
from haverify.robot.trajectory import Trajectory
from haverify.text.record import record

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

Spot = tuple[float, float, float]


@record
class Shot:
    """The robot at one instant: limbs as chains of points with their side (`left`, `right`, none), corners of soles."""

    number: int
    limbs: list[tuple[str, list[Spot]]]
    soles: dict[str, list[Spot]]


def shots(d: Description, t: Trajectory, m: Motion, count: int) -> list[Shot]:
    """The robot at instants evenly over the cycle, seen from under its waist: the picture stays where it is."""
    import numpy as np

    chosen = [int(np.searchsorted(t.times, at)) for at in np.linspace(t.times[0], t.times[-1], count, endpoint=False)]
    chains = limbs(d, t)
    return [_shot(d, m, k, chains) for k in chosen]


def _shot(d: Description, m: Motion, k: int, chains: list[tuple[str, list[int]]]) -> Shot:
    middle = m.com[k]
    shift = (float(middle[0]), float(middle[1]), 0.0)

    def seen(p: Floats) -> Spot:
        x, y, z = (float(a) - b for a, b in zip(p, shift, strict=True))
        return (x, y, z)

    drawn = [(side, [seen(m.points[k, i]) for i in chain]) for side, chain in chains]
    return Shot(k, drawn, {side: [seen(c) for c in m.feet[side][k]] for side in m.feet})


def limbs(d: Description, t: Trajectory) -> list[tuple[str, list[int]]]:
    """From the base to each end of the tree, the joints of a chain as positions in the trajectory, with its side."""
    number = {name: k for k, name in enumerate(t.joints)}
    inner = {j.parent for j in d.robot.joints if j.turns}
    found = []
    for j in d.robot.joints:
        if j.turns and j.child not in inner:
            path = [number[i.name] for i in d.robot.path(j.child) if i.turns]
            found.append((_side(d, j.child), path))
    legs = [
        chain[0]
        for (_, chain), foot in product(found, d.feet.values())
        if d.robot.hinges[t.joints[chain[-1]]].child == foot
    ]
    across = {chain[0]: float(d.robot.hinges[t.joints[chain[0]]].origin[1]) for _, chain in found}
    upper = sorted((k for k in across if k not in legs), key=lambda k: across[k])
    return [*found, ("", [*legs[:1], *upper, *legs[:1]])]


def _side(d: Description, link: str) -> str:
    """The side of a chain by where it leads, from the feet or the signs of offsets to the left."""
    across = sum(float(j.origin[1]) for j in d.robot.path(link))
    return "left" if across > 0 else "right" if across < 0 else ""


def points(m: Motion) -> list[tuple[float, float] | None]:
    """The zero moment point; None where the ground would have to pull."""
    found = zmp(m)
    return [(float(p[0]), float(p[1])) if f > 0 else None for p, f in zip(found, m.wrench[:, 2], strict=True)]


def moving_joints(d: Description, t: Trajectory) -> Mapping[str, tuple[list[float], tuple[float, float]]]:
    """The angle (deg) of each joint that moves within a phase, and its limits."""
    import numpy as np

    found = {}
    for k, name in enumerate(t.joints):
        limits = d.robot.hinges[name].limits
        if limits is not None and np.abs(t.v[:, k]).max() > 0:
            ends = (math.degrees(limits.lower), math.degrees(limits.upper))
            found[name] = (np.degrees(t.q[:, k]).tolist(), ends)
    return found
