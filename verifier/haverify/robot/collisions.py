"""How near two bodies of a robot come, enclosed over the whole cycle: a lower bound, and an upper one where they meet.

Over a stretch of time each shape stays within some distance of where it is taken to be, in every direction; so the gap
between two shapes along any direction is within the sum of both of what it is between these. The greatest gap over all
directions is their distance. If it is negative, it is attained for boxes at a normal of a face or across two edges
(S. Gottschalk, M. Lin, D. Manocha, OBBTree, 1996).
"""

from __future__ import annotations

from functools import partial
from itertools import combinations
from typing import TYPE_CHECKING

from haverify.maths.bernstein import Box
from haverify.maths.interval import Interval
from haverify.robot.body import NEAR, Description, Robot, Shape
from haverify.robot.chain import Placed, constants, seen_from_base
from haverify.robot.cycle import Cycle, Piece
from haverify.robot.formula import Formulas, Number
from haverify.robot.mapping import Map
from haverify.robot.threads import at_once
from haverify.solvers.kernel import Fineness, along
from haverify.text.record import record

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

_ROUNDING = 1e-9  # m: what is computed in floats here is of the order of 1 m and wrong by less than 1e-13
_PARALLEL = 1e-6  # rad, edges that count as parallel; leaving out their normal changes a gap by less than 1e-6 m
_WIDTH, _STRETCHES = 0.002, 4000  # m, how far a shape may move in a stretch along an axis; stretches of a mode


@record
class Solid:
    """A shape with its link."""

    link: str
    shape: Shape


@record
class Nearest:
    """What the distance (m) of the nearest two bodies lies in over a stretch of a mode; `high` may be infinite."""

    pair: tuple[str, str]
    low: float
    high: float
    mode: str
    start: float
    end: float
    is_sure: bool  # whether all stretches of the mode have enclosures


@record
class Poses:
    """Centres (n, s, 3) and half-axes (n, s, 3, 3), by rows, of shapes over stretches; how far off they may be."""

    centres: Floats
    axes: Floats
    off: Floats  # (n, s)


def solids(d: Description) -> list[Solid] | None:
    """All shapes; None where one is not read."""
    found = []
    for link in d.robot.links.values():
        if link.shapes is None:
            return None
        found += [Solid(link.name, shape) for shape in link.shapes]
    return found


def pairs(robot: Robot, every: list[Solid]) -> list[tuple[int, int]]:
    """The pairs of shapes that may collide."""
    roots = {s.link: [j.name for j in robot.path(s.link) if j.turns] for s in every}

    def between(a: str, b: str) -> int:
        return len(set(roots[a]) ^ set(roots[b]))

    return [(i, k) for i, k in combinations(range(len(every)), 2) if between(every[i].link, every[k].link) > NEAR]


def nearest(d: Description, m: Map, cycle: Cycle, box: Box) -> list[Nearest] | None:
    """For each mode its nearest pair of bodies at its nearest; None where a shape is not read."""
    every = solids(d)
    if every is None:
        return None
    chosen = pairs(d.robot, every)
    return at_once([partial(_nearest, d, m, piece, box, every, chosen) for piece in cycle.pieces]) if chosen else []


def _nearest(
    d: Description, m: Map, piece: Piece, box: Box, every: list[Solid], chosen: list[tuple[int, int]]
) -> Nearest:
    import numpy as np

    times, poses, is_sure = _poses(d, m, piece, box, every)
    balls = np.array([s.shape.is_ball for s in every])
    first, second = np.array(chosen).T
    gap = np.empty((len(times), len(chosen)))
    for n in range(len(times)):
        gap[n] = _gaps(poses.centres[n], poses.axes[n], balls, first, second)
    off = poses.off[:, first] + poses.off[:, second] + _ROUNDING
    row, column = np.unravel_index(np.argmin(gap - off), gap.shape)
    is_exact = (gap < 0) & ~(balls[first] | balls[second])
    high = float(np.where(is_exact, gap + off + _PARALLEL, np.inf).min())
    names = every[chosen[column][0]].link, every[chosen[column][1]].link
    start, end = times[row]
    return Nearest(names, float((gap - off)[row, column]), high, piece.mode, start, end, is_sure)


def _poses(
    d: Description, m: Map, piece: Piece, box: Box, every: list[Solid]
) -> tuple[list[tuple[float, float]], Poses, bool]:
    """Where the shapes are over stretches of a mode, seen from the base."""
    import numpy as np

    f = Formulas()
    placed = seen_from_base(f, d, m, piece, f.variable(0), box)
    outputs = [n for s in every for n in _placement(f, placed[s.link], s.shape)]
    identity = Formulas()
    same = identity.listing([identity.variable(k) for k in range(len(outputs))])
    time = (0.0, Interval.at(piece.length).high)
    widths = [_WIDTH] * len(outputs)
    fineness = Fineness(depth=7 if box else 16, stretches=_STRETCHES)
    found = along(f.listing(outputs), same, 0, time, widths, fineness)
    known = [(low, high, values) for low, high, values in found if values is not None]
    ends = np.array([values for _, _, values in known]).reshape(len(known), len(every), 4, 3, 2)
    middle, radius = ends.mean(axis=-1), np.ptp(ends, axis=-1) / 2
    off = np.sqrt((radius**2).sum(axis=-1)).sum(axis=-1)
    return (
        [(low, high) for low, high, _ in known],
        Poses(middle[:, :, 0], middle[:, :, 1:], off),
        len(known) == len(found),
    )


def _placement(f: Formulas, p: Placed, shape: Shape) -> list[Number]:
    """Its centre, and half its axes one by one."""
    centre = f.plus(p.at, f.turned(p.turn, constants(shape.centre)))
    columns = [tuple(p.turn[i][k] for i in range(3)) for k in range(3)]
    halves = [f.mul(c, Number(size)) for column, size in zip(columns, shape.size, strict=True) for c in column]
    return [*centre, *halves]


def _gaps(centres: Floats, axes: Floats, balls: Floats, first: Floats, second: Floats) -> Floats:
    """The greatest gap of each pair along the directions tried; negative where they overlap along all."""
    import numpy as np

    one, other = axes[first], axes[second]
    faces = np.cross(axes[:, [1, 2, 0]], axes[:, [2, 0, 1]])
    apart = centres[second] - centres[first]
    crossed = np.cross(one[:, :, None, :], other[:, None, :, :]).reshape(len(first), 9, 3)
    ways = np.concatenate([faces[first], faces[second], crossed, apart[:, None, :]], axis=1)
    length = np.linalg.norm(ways, axis=2, keepdims=True)
    scale = np.concatenate([np.linalg.norm(one, axis=2), np.linalg.norm(other, axis=2)], axis=1).min(axis=1)
    is_way = length > _PARALLEL * scale[:, None, None] ** 2
    ways = np.where(is_way, ways / np.where(is_way, length, 1.0), 0.0)
    reach = _reach(one, balls[first], ways) + _reach(other, balls[second], ways)
    gap = np.abs(np.einsum("pwk,pk->pw", ways, apart)) - reach
    best: Floats = np.where(is_way[:, :, 0], gap, -np.inf).max(axis=1)
    return best


def _reach(axes: Floats, balls: Floats, ways: Floats) -> Floats:
    """How far shapes reach from their centres along unit vectors."""
    import numpy as np

    along_axes = np.abs(np.einsum("pak,pwk->pwa", axes, ways))
    reach: Floats = np.where(balls[:, None], np.linalg.norm(axes[:, 0], axis=1)[:, None], along_axes.sum(axis=2))
    return reach
