"""The robot's posture and motion as formulas of time, the stance sole lying still on the ground.

From the stance foot outwards each body is placed by the joint that leads to it, forwards or backwards. Lengths and
masses are the exact decimals of the URDF, angles exact polynomials of time, standing joints exact quarter turns or
enclosed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction

from haverify.maths.interval import Interval
from haverify.robot.body import Description, Joint, Link, Robot
from haverify.robot.cycle import Piece
from haverify.robot.formula import (
    NOWHERE,
    ONE,
    UNTURNED,
    ZERO,
    Formulas,
    Matrix,
    Number,
    Vector,
    exact,
    transposed,
)
from haverify.robot.mapping import Map
from haverify.robot.trajectory import angle
from haverify.text.record import record

Q = Fraction


@record
class Placed:
    """A body: its axes (columns of `turn`), origin and angular velocity in the world; `turns` if it moves at all."""

    turn: Matrix
    at: Vector
    spin: Vector


@record
class Turn:
    """A joint over a stretch of time: sine and cosine of its angle, its speed (rad/s)."""

    sine: Number
    cosine: Number
    speed: Number


def posture(f: Formulas, d: Description, m: Map, piece: Piece, time: Number) -> dict[str, Placed]:
    """Every link over one mode, by name, as formulas of the time since it began (s, the automaton's own)."""
    side = m.stance[piece.mode]
    foot = d.feet[side]
    placed = {foot: Placed(UNTURNED, (ZERO, ZERO, exact(-d.sole.z)), NOWHERE)}
    pending = [foot]
    touching = _touching(d.robot)
    while pending:
        name = pending.pop()
        for joint in touching.get(name, ()):
            other = joint.child if joint.parent == name else joint.parent
            if other not in placed:
                turn = _turn(f, m, piece, joint, time)
                step = _outwards if joint.parent == name else _inwards
                placed[other] = step(f, placed[name], joint, turn)
                pending.append(other)
    return placed


def _touching(robot: Robot) -> dict[str, list[Joint]]:
    found: dict[str, list[Joint]] = {}
    for j in robot.joints:
        found.setdefault(j.parent, []).append(j)
        found.setdefault(j.child, []).append(j)
    return found


def _turn(f: Formulas, m: Map, piece: Piece, joint: Joint, time: Number) -> Turn:
    if not joint.turns:
        return Turn(ZERO, ONE, ZERO)
    coefficients = angle(piece, m, joint.name)
    if len(coefficients) == 1:
        return _still(f, *coefficients[0])
    radians = [Number(c * _degree() if is_degrees else c) for c, is_degrees in coefficients]
    slopes = [f.mul(exact(k), c) for k, c in enumerate(radians)][1:]
    sine, cosine = f.sine_and_cosine(_horner(f, radians, time))
    return Turn(sine, cosine, f.mul(Number(m.speed), _horner(f, slopes, time)))


def _still(f: Formulas, value: Q, is_degrees: bool) -> Turn:
    if is_degrees and value % 90 == 0:
        quarter = int(value // 90) % 4
        return Turn(exact((0, 1, 0, -1)[quarter]), exact((1, 0, -1, 0)[quarter]), ZERO)
    radians = _degree() * value if is_degrees else Interval.at(value)
    return Turn(Number(radians.sin()), Number(radians.cos()), ZERO)


def _degree() -> Interval:
    return Interval.at(1).atan() * 4 / 180


def _horner(f: Formulas, coefficients: Sequence[Number], time: Number) -> Number:
    value = ZERO
    for c in reversed(coefficients):
        value = f.add(f.mul(value, time), c)
    return value


def _about(f: Formulas, axis: tuple[Q, Q, Q], t: Turn) -> Matrix:
    """The rotation about a coordinate axis, by columns the child's axes."""
    k = next(i for i in range(3) if axis[i])
    s = t.sine if axis[k] > 0 else f.sub(ZERO, t.sine)
    n, c = f.sub(ZERO, s), t.cosine
    if k == 0:
        return ((ONE, ZERO, ZERO), (ZERO, c, n), (ZERO, s, c))
    if k == 1:
        return ((c, ZERO, s), (ZERO, ONE, ZERO), (n, ZERO, c))
    return ((c, n, ZERO), (s, c, ZERO), (ZERO, ZERO, ONE))


def _outwards(f: Formulas, parent: Placed, j: Joint, t: Turn) -> Placed:
    """The child of a joint."""
    turn = f.product(parent.turn, _about(f, j.axis, t))
    at = f.plus(parent.at, f.turned(parent.turn, constants(j.origin)))
    spin = f.plus(parent.spin, f.scaled(f.turned(turn, constants(j.axis)), t.speed))
    return Placed(turn, at, spin)


def _inwards(f: Formulas, child: Placed, j: Joint, t: Turn) -> Placed:
    """The parent of a joint."""
    turn = f.product(child.turn, transposed(_about(f, j.axis, t)))
    at = f.minus(child.at, f.turned(turn, constants(j.origin)))
    spin = f.minus(child.spin, f.scaled(f.turned(turn, constants(j.axis)), t.speed))
    return Placed(turn, at, spin)


def constants(v: Sequence[Q]) -> Vector:
    """A vector of rationals."""
    x, y, z = (exact(c) for c in v)
    return (x, y, z)


def point(f: Formulas, p: Placed, at: Sequence[Q]) -> Vector:
    """A point of a body in the world."""
    return f.plus(p.at, f.turned(p.turn, constants(at)))


@record
class Lump:
    """Links that move as one: mass, centre and inertia about it in the axes of `link`, the one they are welded to."""

    link: str
    mass: Q
    com: Vector
    inertia: Matrix


def lumps(f: Formulas, d: Description, m: Map, piece: Piece) -> list[Lump]:
    """The bodies that move against each other over one mode; each joint between two lumps is driven."""
    above = {j.child: j for j in d.robot.joints}
    groups: dict[str, list[tuple[Link, Placed]]] = {}
    within: dict[str, tuple[str, Placed]] = {d.robot.base: (d.robot.base, Placed(UNTURNED, NOWHERE, NOWHERE))}
    for j in d.robot.joints:
        home, parent = within[j.parent]
        if m.drive(j.name) is not None:
            within[j.child] = (j.child, Placed(UNTURNED, NOWHERE, NOWHERE))
        else:
            within[j.child] = (home, _outwards(f, parent, j, _turn(f, m, piece, j, ZERO)))
    assert len(within) == len(above) + 1, "joints stand in an order from the base outwards"
    for name, (home, placed) in within.items():
        groups.setdefault(home, []).append((d.robot.links[name], placed))
    return [_lump(f, home, members) for home, members in groups.items()]


def _lump(f: Formulas, home: str, members: list[tuple[Link, Placed]]) -> Lump:
    mass = sum((link.mass for link, _ in members), Q(0))
    if not mass:
        return Lump(home, mass, NOWHERE, (NOWHERE, NOWHERE, NOWHERE))
    centres = [point(f, placed, link.com) for link, placed in members]
    com = NOWHERE
    for (link, _), c in zip(members, centres, strict=True):
        com = f.plus(com, f.scaled(c, exact(link.mass / mass)))
    inertia: Matrix = (NOWHERE, NOWHERE, NOWHERE)
    for (link, placed), c in zip(members, centres, strict=True):
        own = f.product(f.product(placed.turn, _tensor(link)), transposed(placed.turn))
        apart = _steiner(f, f.minus(c, com), exact(link.mass))
        a, b, c3 = (f.plus(f.plus(r, s), t) for r, s, t in zip(inertia, own, apart, strict=True))
        inertia = (a, b, c3)
    return Lump(home, mass, com, inertia)


def _tensor(link: Link) -> Matrix:
    xx, yy, zz, xy, xz, yz = (exact(v) for v in link.inertia)
    return ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))


def _steiner(f: Formulas, r: Vector, mass: Number) -> Matrix:
    """`m (r.r 1 - r r^T)`."""
    square = f.dot(r, r)
    rows: list[Vector] = []
    for i in range(3):
        x, y, z = (f.mul(mass, f.sub(square if i == k else ZERO, f.mul(r[i], r[k]))) for k in range(3))
        rows.append((x, y, z))
    return (rows[0], rows[1], rows[2])


def spun(f: Formulas, lump: Lump, placed: Mapping[str, Placed]) -> Vector:
    """The angular momentum of a lump about its own centre, in the world."""
    p = placed[lump.link]
    inward = f.turned(transposed(p.turn), p.spin)
    return f.turned(p.turn, f.turned(lump.inertia, inward))
