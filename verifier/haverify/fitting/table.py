"""What a fit is worth, as a table to read."""

from __future__ import annotations

from math import ceil, floor

from haverify.fitting.bands import Coverage, coverage, in_turns
from haverify.fitting.curve import Curve
from haverify.fitting.difference import difference
from haverify.fitting.luck import Range, of_held_out, of_turns
from haverify.fitting.percent import POINTS, normalised, percents
from haverify.fitting.walk import Walk
from haverify.recordings.recording import told


def table(walk: Walk) -> str:
    """One line for each joint: degree, root mean squares, the interval of all samples, steps; and the cycles below.

    The mean cycle is what one curve can meet; what samples lie off it is also how much cycles differ.
    """
    lines = [
        "joint         degree   rms deg: mean cycle   samples   samples from curve, deg    step   closure",
    ]
    for c, r in zip(walk.curves, walk.residuals, strict=True):
        between = f"{float(r.low):.3f} .. {float(r.high):.3f}"
        steps = f"{_deg(float(c.jump())):>6} {_deg(_closure(c)):>9}"
        met = f"{missed(walk, c):>21.3f} {r.rms:>9.3f}"
        lines.append(f"{told(c.joint):<13} {c.degree:>6} {met}   {between:<24} {steps}")
    if walk.held_out:
        lines.append("held out:")
        for c, r in zip(walk.curves, walk.held_residuals, strict=True):
            lines.append(f"{told(c.joint):<13} {'':>28} {r.rms:>9.3f}   {float(r.low):.3f} .. {float(r.high):.3f}")
    lines += _bands(walk)
    lines.append(_cycles(walk))
    return "\n".join(lines) + "\n"


def missed(walk: Walk, curve: Curve) -> float:
    """The root mean square of a curve from the mean of the cycles it was fitted to, percent by percent."""
    import numpy as np

    mean = normalised(walk.training, curve.joint).mean(axis=0)
    t = np.linspace(0, float(walk.knots.period), POINTS)[:-1]
    return float(np.sqrt(np.mean((curve.at(t) - mean[:-1]) ** 2)))


def _bands(walk: Walk) -> list[str]:
    """What bands hold of cycles that are held out, and of each cycle or recording that they are made without."""
    lines = []
    if walk.bands:
        b = walk.bands[0]
        what = "recordings" if b.count < len(walk.training) else "cycles"
        wide = [f"{w:.2f}" for w in sorted({round(b.whole, 2) for b in walk.bands if b.whole is not None})]
        whole = f"; of whole curves {' .. '.join(dict.fromkeys((wide[0], wide[-1])))}" if wide else ""
        lines.append(f"band of 95 % of samples: mean +- {b.k:.2f} standard deviations of {b.count} {what}{whole}")
    if walk.bands and walk.held_out:
        held = _shares([coverage(b, walk.held_out) for b in walk.bands])
        tried = len({c.origin for c in walk.held_out} if what == "recordings" else walk.held_out)
        lines.append(f"  of held-out cycles it holds {held}")
        lines.append(_lucky(of_held_out(walk.bands, tried)))
    turns = [in_turns(walk.whole_sample, c.joint) for c in walk.curves]
    if all(turns):
        lines.append(f"  of what is left out in turns it holds {_shares([t for t in turns if t is not None])}")
        if walk.bands:
            lines.append(_lucky(of_turns(walk.bands, percents(walk.whole_sample, walk.curves[0].joint).count)))
    between = [difference(walk.training, c.joint, walk.knots) for c in walk.curves]
    mean = sum(d.samples for d in between) / len(between)
    lines.append(f"band between fits of degree 4 and 2: holds {mean:.1%} of the samples it is made of")
    return lines


def _shares(held: list[Coverage]) -> str:
    """Shares of samples and of whole curves, means over joints."""
    whole = [c.curves for c in held if c.curves is not None]
    curves = f", the wider one {sum(whole) / len(whole):.1%} of whole curves" if whole else ""
    return f"{sum(c.samples for c in held) / len(held):.1%} of samples{curves}"


def _lucky(r: Range) -> str:
    """What a band that is right holds of as few."""
    curves = f", the wider one {_percent(r.curves)} of curves" if r.curves else ""
    return f"    (a right band holds {_percent(r.samples)} of samples{curves}, 95 times of 100)"


def _percent(ends: tuple[float, float]) -> str:
    return f"{floor(100 * ends[0])} to {ceil(100 * ends[1])}%"


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
