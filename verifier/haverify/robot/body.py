"""A robot as exact data: links, joints, limits, soles. Metres, kilograms, radians, seconds."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from functools import cached_property

from haverify.text.record import record
from haverify.text.span import Span

Q = Fraction
Vector = tuple[Q, Q, Q]
NEAR = 2  # bodies with at most so many joints between them touch as they are made


@record
class Limits:
    """What a joint can do: positions (rad), greatest speed (rad/s) and torque (N m)."""

    lower: Q
    upper: Q
    velocity: Q
    effort: Q


@record
class Joint:
    """A hinge, or a weld (`limits` None): `child` turns about `axis` through `origin` in the frame of `parent`."""

    name: str
    parent: str
    child: str
    origin: Vector
    axis: Vector
    limits: Limits | None
    span: Span | None = None

    @property
    def turns(self) -> bool:
        """Whether it is a hinge."""
        return self.limits is not None


@record
class Shape:
    """What a link may collide with: a box with half its `size`, or a ball with its radius thrice, about `centre`."""

    is_ball: bool
    size: Vector
    centre: Vector


@record
class Link:
    """A rigid body: its mass, centre and inertia about the centre (xx, yy, zz, xy, xz, yz), all in its own axes.

    `shapes` is None where the file has one that is not read.
    """

    name: str
    mass: Q
    com: Vector
    inertia: tuple[Q, Q, Q, Q, Q, Q]
    span: Span | None = None
    shapes: tuple[Shape, ...] | None = ()


@record
class Robot:
    """A tree of links joined by joints, the base first; joints stand in an order from the base outwards."""

    name: str
    base: str
    links: Mapping[str, Link]
    joints: tuple[Joint, ...]

    @cached_property
    def hinges(self) -> dict[str, Joint]:
        """The joints that turn, by name."""
        return {j.name: j for j in self.joints if j.turns}

    @cached_property
    def mass(self) -> Q:
        """The whole mass."""
        return sum((link.mass for link in self.links.values()), Q(0))

    def path(self, link: str) -> list[Joint]:
        """The joints from the base to a link."""
        above = {j.child: j for j in self.joints}
        found: list[Joint] = []
        while link in above:
            found.append(above[link])
            link = above[link].parent
        return found[::-1]


@record
class Sole:
    """A rectangle on the ground under a foot, in the foot's frame."""

    x: tuple[Q, Q]
    y: tuple[Q, Q]
    z: Q

    @property
    def corners(self) -> tuple[Vector, ...]:
        """Its corners in turn."""
        (a, b), (c, d) = self.x, self.y
        return ((b, d, self.z), (b, c, self.z), (a, c, self.z), (a, d, self.z))


@record
class Description:
    """What a robot's folder says: the robot, its feet by side, their soles, friction.

    `advice` tells that speed and torque limits are placeholders: checks against them are told and decide nothing.
    """

    robot: Robot
    urdf: str  # path
    feet: Mapping[str, str]
    sole: Sole
    friction: Q
    advice: bool
    advice_because: str
    map: str | None  # path of the map to take when none is named


def inertia_trouble(link: Link) -> str:
    """Why a mass and an inertia belong to no rigid body; empty where they may.

    The inertia is positive definite, and no principal moment exceeds the sum of the other two: with T its trace and
    J the matrix, both J and (T/2) 1 - J are positive (semi)definite. Decided exactly, by leading minors.
    """
    if link.mass < 0:
        return "its mass is negative"
    xx, yy, zz, xy, xz, yz = link.inertia
    if link.mass == 0:
        return "it has an inertia but no mass" if any(link.inertia) else ""
    if not _is_definite((xx, yy, zz, xy, xz, yz)):
        return "its inertia is not positive definite"
    half = (xx + yy + zz) / 2
    if not _is_definite((half - xx, half - yy, half - zz, -xy, -xz, -yz)):
        return "one principal moment of inertia is at least the sum of the other two"
    return ""


def _is_definite(m: tuple[Q, ...]) -> bool:
    xx, yy, zz, xy, xz, yz = m
    second = xx * yy - xy * xy
    third = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz)
    return xx > 0 and second > 0 and third > 0
