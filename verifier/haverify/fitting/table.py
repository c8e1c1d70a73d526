"""What a fit is worth, as a table to read."""

from __future__ import annotations

from haverify.fitting.bands import coverage, difference
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
    lines += _bands(walk)
    lines.append(_cycles(walk))
    return "\n".join(lines) + "\n"


def _bands(walk: Walk) -> list[str]:
    """What bands hold: of held-out cycles, or of those they are made of where none are."""
    lines = []
    cycles, of = (walk.held_out, "held-out") if walk.held_out else (walk.training, "the same")
    if walk.bands:
        held = [coverage(b, cycles) for b in walk.bands]
        what = "recordings" if walk.bands[0].count < len(walk.training) else "cycles"
        samples, whole = (sum(x) / len(held) for x in ([c.samples for c in held], [c.cycles for c in held]))
        lines.append(
            f"band of 95 %: mean +- {walk.bands[0].k:.2f} standard deviations of {walk.bands[0].count} {what} holds "
            f"{samples:.1%} of the samples and {whole:.1%} of the curves of {of} cycles"
        )
    between = [difference(walk.training, c.joint, walk.knots) for c in walk.curves]
    mean = sum(d.samples for d in between) / len(between)
    lines.append(f"band between fits of degree 4 and 2: holds {mean:.1%} of the samples it is made of")
    return lines


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
    cycles = "1 cycle" if len(walk.training) == 1 else f"{len(walk.training)} cycles"
    return f"{cycles} of the {leg} leg{held}, {float(walk.knots.period):.4f} s{more}; {walk.methods[0]}"
