"""What a fit is worth, as a table to read."""

from __future__ import annotations

from haverify.fitting.curve import Curve
from haverify.fitting.walk import Walk
from haverify.recordings.recording import told


def table(walk: Walk) -> str:
    """One line for each joint: degree, root mean square, the proved interval, steps; and the cycles below."""
    lines = ["joint         degree    rms deg   samples from curve, deg    step   closure"]
    for c, r in zip(walk.curves, walk.residuals, strict=True):
        between = f"{float(r.low):.3f} .. {float(r.high):.3f}"
        steps = f"{_deg(float(c.jump())):>6} {_deg(_closure(c)):>9}"
        lines.append(f"{told(c.joint):<13} {c.degree:>6} {r.rms:>10.3f}   {between:<24} {steps}")
    if walk.held_out:
        lines.append("held out:")
        for c, r in zip(walk.curves, walk.held_residuals, strict=True):
            lines.append(f"{told(c.joint):<13} {'':>6} {r.rms:>10.3f}   {float(r.low):.3f} .. {float(r.high):.3f}")
    lines.append(_cycles(walk))
    return "\n".join(lines) + "\n"


def _deg(x: float) -> str:
    return "0" if x == 0 else f"{x:.3f}"


def _closure(c: Curve) -> float:
    """The step of the angle where the last phase hands over to the first."""
    return abs(float(sum(c.rows[-1])) - float(c.rows[0][0]))


def _cycles(walk: Walk) -> str:
    leg = {"l": "left", "r": "right"}[walk.options.leg]
    held = f", {len(walk.held_out)} held out" if walk.held_out else ""
    kind = {"alternates": " (no whole one; its length from the legs' alternation)", "mirrors": " (half of it mirrored)"}
    more = kind.get(walk.strides[0].kind, "") if len(walk.cycles) == 1 else ""
    return (
        f"{len(walk.training)} cycles of the {leg} leg{held}, {float(walk.knots.period):.4f} s{more}; {walk.methods[0]}"
    )
