"""What the whole body does, enclosed over the whole cycle by the kernel: heights, centre of mass, ground's wrench.

Time here is the automaton's own; the replay's pace enters as a factor of speeds and accelerations.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from haverify.maths.interval import Interval
from haverify.robot.body import Description
from haverify.robot.chain import lumps, point, posture, spun
from haverify.robot.cycle import Cycle, Piece
from haverify.robot.formula import Formulas, Number, Vector, exact
from haverify.robot.mapping import Map
from haverify.solvers.kernel import Fineness, Listing, Pair, along
from haverify.text.record import record

Q = Fraction
GRAVITY = Q("9.81")
QUANTITIES = (
    *(f"sole_{k}_{c}" for k in range(4) for c in "xyz"),
    *(f"com_{c}" for c in "xyz"),
    "force_z",
    "grip",
    "over_front",
    "over_back",
    "over_left",
    "over_right",
)


@record
class Stretch:
    """What the quantities lie in between two instants (s) since a mode began; None where one has no enclosure."""

    mode: str
    low: float
    high: float
    values: dict[str, Pair] | None


@record
class Formulated:
    """The tapes of one mode: positions as functions of time, quantities of these and their two derivatives."""

    positions: Listing
    readout: Listing


def formulated(d: Description, m: Map, piece: Piece) -> Formulated:
    """The swing sole's corners, the centre of mass, the ground's force and its moments over the stance sole's edges.

    With r_i the centres of moving bodies, L_i their spins and M the whole mass, the ground supplies the force
    F = M (c'' + g) and, about the origin, the moment N = sum m_i r_i x (r_i'' + g) + L_i'. The moment that holds the
    body back from tipping over an edge is F_z times the distance of the zero moment point from it: positive inside.
    `grip` is (mu F_z)^2 less the square of the force along the ground: positive within the friction cone.
    """
    f = Formulas()
    time = f.variable(0)
    placed = posture(f, d, m, piece, time)
    swing = d.feet["right" if m.stance[piece.mode] == "left" else "left"]
    corners = [point(f, placed[swing], c) for c in d.sole.corners]
    bodies = [b for b in lumps(f, d, m, piece) if b.mass]
    centres = [f.plus(placed[b.link].at, f.turned(placed[b.link].turn, b.com)) for b in bodies]
    spins = [spun(f, b, placed) for b in bodies]
    outputs = [c for v in (*corners, *centres, *spins) for c in v]
    return Formulated(f.listing(outputs), _readout(d, m, [b.mass for b in bodies], len(outputs)))


def _readout(d: Description, m: Map, masses: list[Q], outputs: int) -> Listing:
    f = Formulas()

    def vector(k: int, derivative: int) -> Vector:
        x, y, z = (f.variable(derivative * outputs + 3 * k + i) for i in range(3))
        return (x, y, z)

    pace, n = m.speed, len(masses)
    corners = [vector(k, 0) for k in range(4)]
    whole = sum(masses, Q(0))
    com = f.scaled(
        _sum(f, [f.scaled(vector(4 + i, 0), exact(mass)) for i, mass in enumerate(masses)]), exact(1 / whole)
    )
    force, moments = (exact(0), exact(0), exact(whole * GRAVITY)), []
    for i, mass in enumerate(masses):
        rate = f.scaled(vector(4 + i, 2), exact(pace**2))
        felt = (rate[0], rate[1], f.add(rate[2], exact(GRAVITY)))
        force = f.plus(force, f.scaled(rate, exact(mass)))
        moments.append(f.scaled(f.cross(vector(4 + i, 0), felt), exact(mass)))
        # a spin holds one factor of the pace; its derivative brings the other
        moments.append(f.scaled(vector(4 + n + i, 1), exact(pace)))
    moment = _sum(f, moments)
    force_z = force[2]
    along_ground = f.add(f.mul(force[0], force[0]), f.mul(force[1], force[1]))
    grip = f.sub(f.mul(exact(d.friction**2), f.mul(force_z, force_z)), along_ground)
    (back, front), (right, left) = d.sole.x, d.sole.y
    ahead, aside = f.sub(exact(0), moment[1]), moment[0]  # the zero moment point times the force
    holding = [
        f.sub(f.mul(exact(front), force_z), ahead),
        f.sub(ahead, f.mul(exact(back), force_z)),
        f.sub(f.mul(exact(left), force_z), aside),
        f.sub(aside, f.mul(exact(right), force_z)),
    ]
    found: list[Number] = [*(c for v in corners for c in v), *com, force_z, grip, *holding]
    return f.listing(found)


def _sum(f: Formulas, vectors: list[Vector]) -> Vector:
    total = vectors[0]
    for v in vectors[1:]:
        total = f.plus(total, v)
    return total


def enclosed(d: Description, m: Map, cycle: Cycle, widths: Mapping[str, float], fineness: Fineness) -> list[Stretch]:
    """The whole cycle, mode by mode, until every quantity is as narrow as its entry of `widths` asks for."""
    found = []
    wanted = [widths[name] for name in QUANTITIES]
    for piece in cycle.pieces:
        made = formulated(d, m, piece)
        end = Interval.at(piece.length).high
        for low, high, values in along(made.positions, made.readout, 2, (0.0, end), wanted, fineness):
            named = None if values is None else dict(zip(QUANTITIES, values, strict=True))
            found.append(Stretch(piece.mode, low, high, named))
    return found


def enclosed_finely(d: Description, m: Map, cycle: Cycle, share: float = 0.05) -> list[Stretch]:
    """The same, each quantity to a share of the range it has over the cycle."""
    coarse = enclosed(d, m, cycle, dict.fromkeys(QUANTITIES, 0.0), Fineness(depth=3))
    ends = {name: [s.values[name] for s in coarse if s.values is not None] for name in QUANTITIES}
    widths = {
        name: share * (max(p[1] for p in pairs) - min(p[0] for p in pairs)) + 1e-9
        for name, pairs in ends.items()
        if pairs
    }
    return enclosed(d, m, cycle, {name: widths.get(name, 0.0) for name in QUANTITIES}, Fineness())
