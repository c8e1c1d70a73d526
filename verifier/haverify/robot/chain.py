"""The robot's posture and motion as formulas of time, the stance sole lying still on the ground.

From the stance foot outwards each body is placed by the joint that leads to it, forwards or backwards. Lengths and
masses are the exact decimals of the URDF, angles exact polynomials of time, standing joints exact quarter turns or
enclosed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import zip_longest

from haverify.maths.bernstein import Box
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
from haverify.robot.mapping import Drive, Map
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


def posture(f: Formulas, d: Description, m: Map, piece: Piece, time: Number, box: Box) -> dict[str, Placed]:
    """Every link over one mode, by name, as formulas of the time since it began (s, the automaton's own).

    Coefficients are enclosed over the params of `box`.
    """
    foot = d.feet[m.stance[piece.mode]]
    return spread(f, d, m, piece, time, box, {foot: Placed(UNTURNED, (ZERO, ZERO, exact(-d.sole.z)), NOWHERE)})


def seen_from_base(f: Formulas, d: Description, m: Map, piece: Piece, time: Number, box: Box) -> dict[str, Placed]:
    """The same as seen from the base, which is at the origin."""
    return spread(f, d, m, piece, time, box, {d.robot.base: Placed(UNTURNED, NOWHERE, NOWHERE)})


def spread(
    f: Formulas, d: Description, m: Map, piece: Piece, time: Number, box: Box, placed: dict[str, Placed]
) -> dict[str, Placed]:
    """Every link, placed from one that is."""
    pending = list(placed)
    touching = _touching(d.robot)
    while pending:
        name = pending.pop()
        for joint in touching.get(name, ()):
            other = joint.child if joint.parent == name else joint.parent
            if other not in placed:
                turn = _turn(f, m, piece, joint, time, box)
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


def _turn(f: Formulas, m: Map, piece: Piece, joint: Joint, time: Number, box: Box) -> Turn:
    if not joint.turns:
        return Turn(ZERO, ONE, ZERO)
    drive = m.drive(joint.name)
    if drive is None:
        ((value, is_degrees),) = angle(piece, m, joint.name)
        return _still(f, value, is_degrees)
    radians = [Number(c) for c in _driven(piece, drive, box)]
    slopes = [f.mul(exact(k), c) for k, c in enumerate(radians)][1:]
    sine, cosine = f.sine_and_cosine(_horner(f, radians, time))
    return Turn(sine, cosine, _horner(f, slopes, time))


def _driven(piece: Piece, drive: Drive, box: Box) -> list[Interval]:
    """The coefficients (rad) of a driven joint's angle."""
    unit = _degree() if drive.unit == "deg" else Interval.at(1)
    rows = [piece.over(name, box) for name in drive.outputs]
    found = []
    for terms in zip_longest(*rows, fillvalue=(Q(0), Q(0))):
        low, high = (sum((t[end] for t in terms), Q(0)) for end in (0, 1))
        found.append(Interval.between(low, high) * drive.factor * unit)
    return [found[0] + _degree() * drive.offset, *found[1:]]


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


def loaded(d: Description, m: Map) -> list[Joint]:
    """The hinges beyond which something is driven or stands: the others hold arms and a head still."""
    above = {j.child: j for j in d.robot.joints}
    found: set[str] = set()
    for end in (*d.feet.values(), *(d.robot.hinges[drive.joint].child for drive in m.drives)):
        while end in above:
            found.add(above[end].name)
            end = above[end].parent
    return [j for j in d.robot.hinges.values() if j.name in found]


def lumps(f: Formulas, d: Description, m: Map, piece: Piece) -> list[Lump]:
    """The bodies between the joints that are loaded."""
    parted = {j.name for j in loaded(d, m)}
    within: dict[str, tuple[str, Placed]] = {d.robot.base: (d.robot.base, _UNMOVED)}
    for j in d.robot.joints:
        home, parent = within[j.parent]
        if j.name in parted:
            within[j.child] = (j.child, _UNMOVED)
        else:
            within[j.child] = (home, _outwards(f, parent, j, _turn(f, m, piece, j, ZERO, {})))
    groups: dict[str, list[tuple[Link, Placed]]] = {}
    for name, (home, placed) in within.items():
        groups.setdefault(home, []).append((d.robot.links[name], placed))
    return [_lump(f, home, members) for home, members in groups.items() if any(link.mass for link, _ in members)]


_UNMOVED = Placed(UNTURNED, NOWHERE, NOWHERE)


def _lump(f: Formulas, home: str, members: list[tuple[Link, Placed]]) -> Lump:
    mass = sum((link.mass for link, _ in members), Q(0))
    centres = [point(f, placed, link.com) for link, placed in members]
    com = NOWHERE
    for (link, _), c in zip(members, centres, strict=True):
        com = f.plus(com, f.scaled(c, exact(link.mass / mass)))
    inertia: Matrix = (NOWHERE, NOWHERE, NOWHERE)
    for (link, placed), c in zip(members, centres, strict=True):
        own = f.product(f.product(placed.turn, _tensor(link)), transposed(placed.turn))
        apart = _steiner(f, f.minus(c, com), exact(link.mass))
        x, y, z = (f.plus(f.plus(r, s), t) for r, s, t in zip(inertia, own, apart, strict=True))
        inertia = (x, y, z)
    return Lump(home, mass, com, inertia)


@record
class Load:
    """Of some links: mass, sum of `m r`, of `m r''` and of the moments of motion about the origin."""

    mass: Number
    lever: Vector
    pull: Vector
    moment: Vector

    def with_(self, f: Formulas, other: Load) -> Load:
        """Of both."""
        lever, pull = f.plus(self.lever, other.lever), f.plus(self.pull, other.pull)
        return Load(f.add(self.mass, other.mass), lever, pull, f.plus(self.moment, other.moment))


@record
class Loads:
    """What each joint carries when a foot stands, by joint, and all together; `inwards`: it carries its parent."""

    beyond: Mapping[str, Load]
    every: Load
    inwards: frozenset[str]


def loads(f: Formulas, d: Description, foot: str, shares: Mapping[str, Load]) -> Loads:
    """Sums over the links beyond each joint, seen from the foot that stands."""
    touching = _touching(d.robot)
    beyond: dict[str, Load] = {}
    inwards: set[str] = set()

    def gathered(link: str, through: str) -> Load:
        load = shares.get(link, Load(ZERO, NOWHERE, NOWHERE, NOWHERE))
        for j in touching.get(link, ()):
            if j.name != through:
                if j.child == link:
                    inwards.add(j.name)
                beyond[j.name] = gathered(j.parent if j.child == link else j.child, j.name)
                load = load.with_(f, beyond[j.name])
        return load

    return Loads(beyond, gathered(foot, ""), frozenset(inwards))


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


def spun(f: Formulas, lump: Lump, p: Placed) -> Vector:
    """The angular momentum of a lump about its own centre, in the world."""
    inward = f.turned(transposed(p.turn), p.spin)
    return f.turned(p.turn, f.turned(lump.inertia, inward))
