"""What a fitted walk claims: every bound comes from outside the fit, every expectation from exact evaluation."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import ceil, floor

from haverify.fitting.bounds import fastest, ranges
from haverify.fitting.curve import Curve, Residual, value
from haverify.fitting.exact_ranges import outside, steepest
from haverify.fitting.tables import Row, text
from haverify.fitting.walk import Walk
from haverify.recordings.phases import PHASES
from haverify.recordings.recording import JOINTS, told

Q = Fraction
Picked = Sequence[Row]

LIMITS = {"h": ("hip", Q(-30), Q(120)), "k": ("knee", Q(-135), Q(10)), "a": ("ankle", Q(-50), Q(20))}
"""Normal ranges of motion of adults (American Academy of Orthopaedic Surgeons, Joint Motion, 1965); 10 deg of
hyperextension of the knee."""


TOLERANCE = Q(5)
"""How much further, in degrees, samples of recordings that are tried may lie: what clinical gait analysis regards as a
reasonable error (J. L. McGinley et al., The reliability of three-dimensional kinematic gait measurements, Gait &
Posture 29, 2009, 360-369)."""


def claims(walk: Walk, recorded: Picked, held: Picked) -> str:
    """All claims, as text."""
    parts = [_limits(), *_continuous(walk)]
    for curve, residual in zip(walk.curves, walk.residuals, strict=True):
        if recorded:
            parts.append(_near(curve, residual, "Recorded", "recorded", recorded, walk.is_tried))
        if held:
            parts.append(_near(curve, residual, "Held", "held_out", held, walk.is_tried))
    parts += [_ranges(walk, c, r) for c, r in zip(walk.curves, walk.residuals, strict=True)]
    return "\n".join([*parts, *_possible(walk), *_bounded(walk), _fast(walk), _round(walk)])


def _limits() -> str:
    lines = [f"const {n}_motion: deg = [{text(a)} deg, {text(b)} deg]" for n, a, b in LIMITS.values()]
    return (
        "/// Ranges of motion of adults: American Academy of Orthopaedic Surgeons, Joint Motion, 1965, with 10 deg of\n"
        "/// hyperextension of the knee. Only declared: nothing here was fitted.\n" + "\n".join(lines) + "\n"
    )


def _expect(is_true: bool, because: str = "") -> str:
    return "  expect proved\n" if is_true else f'  expect refuted because "{because}"\n'


def _continuous(walk: Walk) -> list[str]:
    """Steps at the boundaries, the end of the cycle included: none up to the order of the fit."""
    names = (("joined", "Angles", "{0} == pre({0})"), ("smooth", "Velocities", "der({0}) == pre(der({0}))"))
    parts = []
    for name, what, claim in names[: walk.options.order + 1]:
        lines = "".join(f"  always jumped implies {claim.format(j)}\n" for j in JOINTS)
        doc = f"/// {what} have no step where phases hand over, nor where the cycle closes: exactly, by construction.\n"
        parts.append(f"{doc}property {name} on Walk {{\n{lines}  expect proved\n}}\n")
    return parts


def _near(curve: Curve, residual: Residual, table: str, name: str, rows: Picked, is_tried: bool) -> str:
    """Samples lie as far from the curve as the residual of the training cycles says, to a thousandth of a degree.

    Of held-out cycles of the same recordings it is known whether this holds, and expected. Of recordings that are tried
    it is asked, with some tolerance.
    """
    j = curve.joint
    room = TOLERANCE if is_tried and table == "Held" else Q(0)
    off = [(row[j] - value(curve.rows[PHASES.index(phase)], u), phase) for phase, _, u, row in rows]
    within = [d for d, _ in off] if table == "Recorded" else []  # local times were rounded: millionths of a degree
    low = Q(floor(min([residual.low, *within]) * 1000), 1000) - room
    high = Q(ceil(max([residual.high, *within]) * 1000), 1000) + room
    far = max(((d, phase) for d, phase in off if not low <= d <= high), key=lambda x: abs(x[0]), default=None)
    bounds = f"{table}[p][i].{j} - {j.upper()}[p]({table}[p][i].u) in [{text(low)} deg, {text(high)} deg]"
    because = f"{float(far[0]):.3f} deg in {far[1]}" if far else ""
    what = "Held-out" if table == "Held" else "Recorded"
    how = f"within {text(room)} deg of" if room else "as near as"
    return (
        f"/// {what} samples of the {told(j)} are {how} those it was fitted to: the proved residual.\n"
        f"property {name}_{j} {{\n"
        f"  holds forall p in Phase: forall i in {table}Pick: {bounds}\n"
        f"{_expect(far is None or (table == 'Held' and is_tried), because)}}}\n"
    )


def _ranges(walk: Walk, curve: Curve, residual: Residual) -> str:
    j = curve.joint
    cycles = walk.training if walk.is_tried else walk.held_out or walk.training
    low, high = walk.shifts[walk.curves.index(curve)] if walk.shifts else (Q(0), Q(0))
    bounds = [(a + low, b + high) for a, b in ranges(cycles, curve, residual)]
    gone = outside(curve, [(a - low, b - high) for a, b in bounds])
    lines = "".join(
        f"  always at({p}) implies {text(a)} deg <= {j} <= {text(b)} deg\n"
        for p, (a, b) in zip(PHASES, bounds, strict=True)
    )
    because = "; ".join(f"{PHASES[k]} {a:.2f} .. {b:.2f} deg" for k, a, b in gone)
    what = "held-out" if walk.held_out and not walk.is_tried else "recorded"
    doc = f"/// The {told(j)} stays where the {what} samples of each phase lie, but for the residual.\n"
    return f"{doc}property range_{j} on Walk {{\n{lines}{_expect(not gone, because)}}}\n"


def _possible(walk: Walk) -> list[str]:
    """A joint moves as joints can."""
    parts = []
    for joint, (name, low, high) in LIMITS.items():
        curves = [c for c in walk.curves if c.joint[1] == joint]
        gone = {c.joint: outside(c, [(low, high)] * len(PHASES)) for c in curves}
        lines = "".join(f"  always {c.joint} in {name}_motion\n" for c in curves)
        because = "; ".join(
            f"{j} {min(g[1] for g in gs):.1f} .. {max(g[2] for g in gs):.1f} deg" for j, gs in gone.items() if gs
        )
        parts.append(f"property {name}s_move_as_joints_can on Walk {{\n{lines}{_expect(not because, because)}}}\n")
    return parts


def _bounded(walk: Walk) -> list[str]:
    """A joint stays where the fit was told to keep it."""
    parts = []
    for joint, bounds in walk.options.bounds.items():
        name = LIMITS[joint][0]
        shifts = [s for c, s in zip(walk.curves, walk.shifts, strict=False) if c.joint[1] == joint] or [(Q(0), Q(0))]
        low, high = bounds.low + min(a for a, _ in shifts), bounds.high + max(b for _, b in shifts)
        lines = "".join(f"  always {text(low)} deg <= {s}{joint} <= {text(high)} deg\n" for s in "lr")
        doc = f"/// The {name}s stay in the interval that was declared for the fit.\n"
        parts.append(f"{doc}property {name}s_in_bounds on Walk {{\n{lines}  expect proved\n}}\n")
    return parts


def _fast(walk: Walk) -> str:
    """Speeds against the recorded steps, at the mean walking speed."""
    lines, gone = [], []
    for c in walk.curves:
        bound = fastest(walk.training if walk.is_tried else walk.held_out or walk.training, c)
        speed = steepest(c)
        lines.append(f"  always abs(der({c.joint})) <= {text(bound)} deg/s * speed\n")
        if speed > bound:
            gone.append(f"{c.joint} {float(speed):.0f} deg/s")
    doc = "/// No joint is more than a quarter faster than the fastest recorded step of 15 ms, at any walking speed.\n"
    return f"{doc}property velocity on Walk {{\n{''.join(lines)}{_expect(not gone, '; '.join(gone))}}}\n"


def _round(walk: Walk) -> str:
    return (
        "/// The walk goes on: it never blocks, and each phase comes.\n"
        "property no_lock on Walk { never stuck; expect proved }\n"
        "property visited for p in Phase on Walk {\n"
        f"  can reach at(p) within {text(walk.knots.period)} s\n"
        "  expect proved\n"
        "}\n"
    )
