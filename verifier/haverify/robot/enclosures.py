"""What the whole body does, enclosed over the whole cycle by the kernel: heights, centre of mass, ground's wrench.

Time here is the automaton's own; the replay's pace enters as a factor of speeds and accelerations.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import partial

from haverify.maths.bernstein import Box
from haverify.maths.interval import Interval
from haverify.robot.body import Description, Joint
from haverify.robot.chain import Load, Lump, constants, loaded, loads, lumps, point, posture, spun
from haverify.robot.cycle import Cycle, Piece
from haverify.robot.formula import NOWHERE, ZERO, Formulas, Number, Vector, exact
from haverify.robot.mapping import Map
from haverify.robot.threads import at_once
from haverify.solvers.kernel import Fineness, Listing, Pair, along
from haverify.text.record import record

Q = Fraction
GRAVITY = Q("9.81")
_TORQUE = 0.05  # N m, narrow enough beside the ranges of motors
_LOOKS = 5  # instants of a mode
EDGES = ("front", "back", "left", "right")
QUANTITIES = (
    *(f"sole_{k}_{c}" for k in range(4) for c in "xyz"),
    *(f"com_{c}" for c in "xyz"),
    *(f"push_{c}" for c in "xyz"),
    *(f"tip_{edge}" for edge in EDGES),
)


@record
class Stretch:
    """What the quantities lie in between two instants (s) since a mode began; None where one has no enclosure.

    `box` are the params' values for which they do, where outputs read params.
    """

    mode: str
    low: float
    high: float
    values: dict[str, Pair] | None
    box: Box


@record
class Formulated:
    """The tapes of one mode: positions as functions of time, quantities of these and their two derivatives."""

    positions: Listing
    readout: Listing
    names: tuple[str, ...]


def quantities(d: Description, m: Map) -> tuple[str, ...]:
    """The names of all quantities of a robot."""
    return (*QUANTITIES, *(f"{kind}_{joint.name}" for joint in loaded(d, m) for kind in ("hold", "move")))


def formulated(d: Description, m: Map, piece: Piece, box: Box) -> Formulated:
    """The swing sole's corners, the centre of mass, and what the ground and the joints have to supply.

    With r_i the centres of bodies, L_i their spins and M the whole mass, the ground supplies the force M (c'' + g) and,
    about the origin, the moment sum m_i r_i x (r_i'' + g) + L_i'. What weight asks for follows from positions; what
    motion asks for grows with the square of the pace, and is enclosed here for the automaton's own: `push` is
    sum m_i r_i'', `tip_e` the part of the moment that holds the body back from tipping over an edge e of the stance
    sole, `move_j` the part of a joint's torque. `hold_j` is the torque that weight asks for.
    """
    f = Formulas()
    placed = posture(f, d, m, piece, f.variable(0), box)
    side = m.stance[piece.mode]
    swing = d.feet["right" if side == "left" else "left"]
    corners = [point(f, placed[swing], c) for c in d.sole.corners]
    bodies = lumps(f, d, m, piece)
    centres = [f.plus(placed[b.link].at, f.turned(placed[b.link].turn, b.com)) for b in bodies]
    spins = [spun(f, b, placed[b.link]) for b in bodies]
    hinges = loaded(d, m)
    origins = [placed[j.child].at for j in hinges]
    axes = [f.turned(placed[j.child].turn, constants(j.axis)) for j in hinges]
    outputs = [c for v in (*corners, *centres, *spins, *origins, *axes) for c in v]
    return Formulated(f.listing(outputs), _readout(d, d.feet[side], bodies, hinges, len(outputs)), quantities(d, m))


def _readout(d: Description, foot: str, bodies: list[Lump], hinges: list[Joint], outputs: int) -> Listing:
    f, n = Formulas(), len(bodies)

    def vector(k: int, derivative: int) -> Vector:
        x, y, z = (f.variable(derivative * outputs + 3 * k + i) for i in range(3))
        return (x, y, z)

    shares: dict[str, Load] = {}
    for i, body in enumerate(bodies):
        mass, at = exact(body.mass), vector(4 + i, 0)
        pull = f.scaled(vector(4 + i, 2), mass)
        moment = f.plus(f.cross(at, pull), vector(4 + n + i, 1))
        shares[body.link] = Load(mass, f.scaled(at, mass), pull, moment)
    carried = loads(f, d, foot, shares)
    every = carried.every
    com = f.scaled(every.lever, exact(1 / d.robot.mass))
    found: list[Number] = [*(c for k in range(4) for c in vector(k, 0)), *com, *every.pull]
    found += _tipping(f, d, every.pull, every.moment)
    for i, joint in enumerate(hinges):
        origin, axis = vector(4 + 2 * n + i, 0), vector(4 + 2 * n + len(hinges) + i, 0)
        load, sign = carried.beyond[joint.name], exact(-1 if joint.name in carried.inwards else 1)
        arm = f.minus(load.lever, f.scaled(origin, load.mass))
        hold = f.cross(arm, (ZERO, ZERO, exact(GRAVITY)))
        move = f.minus(load.moment, f.cross(origin, load.pull))
        found += [f.mul(sign, f.dot(axis, hold)), f.mul(sign, f.dot(axis, move))]
    return f.listing(found)


def _tipping(f: Formulas, d: Description, push: Vector, moment: Vector) -> list[Number]:
    """The motion's part of the moments that hold the body back from each edge, in the order of `EDGES`."""
    (back, front), (right, left) = d.sole.x, d.sole.y
    ahead, aside = f.sub(ZERO, moment[1]), moment[0]  # the zero moment point times the force
    return [
        f.sub(f.mul(exact(front), push[2]), ahead),
        f.sub(ahead, f.mul(exact(back), push[2])),
        f.sub(f.mul(exact(left), push[2]), aside),
        f.sub(aside, f.mul(exact(right), push[2])),
    ]


def _sum(f: Formulas, vectors: list[Vector]) -> Vector:
    total = NOWHERE
    for v in vectors:
        total = f.plus(total, v)
    return total


@record
class Tape:
    """The tapes of a mode, and how long it takes at most (s)."""

    mode: str
    made: Formulated
    length: float


@record
class Tapes:
    """The tapes of all modes for some values of the params, made once for several looks."""

    modes: list[Tape]
    box: Box

    def enclosed(self, widths: Mapping[str, float], fineness: Fineness) -> list[Stretch]:
        """The whole cycle, until every quantity is as narrow as its entry of `widths` asks for."""
        asked = [(t, (0.0, t.length), [widths[name] for name in t.made.names]) for t in self.modes]
        found = at_once([partial(_along, t.made, time, wanted, fineness) for t, time, wanted in asked])
        return [Stretch(t.mode, *one, self.box) for t, each in zip(self.modes, found, strict=True) for one in each]

    def ranges(self) -> dict[str, float]:
        """How far each quantity ranges over some instants: it decides how finely to look, and nothing else."""
        found: dict[str, list[float]] = {name: [] for t in self.modes for name in t.made.names}
        for t in self.modes:
            for k in range(_LOOKS):
                at = t.length * k / (_LOOKS - 1)
                for *_, values in _along(t.made, (at, at), [0.0] * len(t.made.names), Fineness(depth=0)):
                    for name, (low, high) in (values or {}).items():
                        found[name] += [low, high]
        return {name: max(ends) - min(ends) if ends else 0.0 for name, ends in found.items()}


def tapes(d: Description, m: Map, cycle: Cycle, box: Box) -> Tapes:
    """The tapes of a cycle."""
    made = [Tape(p.mode, formulated(d, m, p, box), Interval.at(p.length).high) for p in cycle.pieces]
    return Tapes(made, box)


def _along(
    made: Formulated, time: Pair, wanted: Sequence[float], fineness: Fineness
) -> list[tuple[float, float, dict[str, Pair] | None]]:
    found = along(made.positions, made.readout, 2, time, wanted, fineness)
    return [(low, high, None if v is None else dict(zip(made.names, v, strict=True))) for low, high, v in found]


def enclosed_finely(made: Tapes, share: float = 0.07) -> list[Stretch]:
    """The whole cycle, each quantity to a share of the range it has over the cycle, torques at least to 0.05 N m."""
    widths = {
        name: share * width + (_TORQUE if name.startswith(("hold", "move")) else 1e-9)
        for name, width in made.ranges().items()
    }
    return made.enclosed(widths, Fineness(depth=7) if made.box else Fineness())
