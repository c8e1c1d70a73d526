"""Declared bounds against what was recorded, and against the curves that were to stay in them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from haverify.diagnostics.diagnostic import Diagnostic, Severity
from haverify.fitting.bounded import Interval
from haverify.fitting.curve import Curve
from haverify.fitting.exact_ranges import outside
from haverify.recordings.cycles import Cycle
from haverify.recordings.recording import JOINTS, NAMES, told


def contradictions(bounds: Mapping[str, Interval], cycles: Sequence[Cycle]) -> list[Diagnostic]:
    """What samples say against declared bounds: an error where more than half of those of a joint lie outside."""
    found = []
    for j in JOINTS:
        here = bounds.get(j[1])
        values = [v for c in cycles for v in c.angles[j] if v is not None]
        out = [v for v in values if here and not here.low <= v <= here.high]
        if here is None or not out:
            continue
        farthest = max(out, key=lambda v: max(v - here.high, here.low - v))
        message = (
            f"--bound {NAMES[j[1]]}={_text(here)}: {len(out)} of {len(values)} samples of the {told(j)} lie outside,"
            f" as far as {float(farthest):.2f} deg"
        )
        if len(out) > len(values) / 2:
            turned = sum(1 for v in values if here.low <= -v <= here.high) > len(values) / 2  # the other sign is meant
            advice = f"--bound {NAMES[j[1]]}={_text(Interval(-here.high, -here.low))}" if turned else None
            found.append(Diagnostic("HA228", message, severity=Severity.ERROR, help=advice))
        else:
            found.append(Diagnostic("HA228", f"{message}; the curve stays inside all the same"))
    return found


def broken(bounds: Mapping[str, Interval], curves: Sequence[Curve]) -> list[Diagnostic]:
    """An error for each curve that does not stay in its bounds, exactly."""
    found = []
    for c in curves:
        here = bounds.get(c.joint[1])
        gone = outside(c, [(here.low, here.high)] * len(c.rows)) if here else []
        if here and gone:
            least, most = min(a for _, a, _ in gone), max(b for _, _, b in gone)
            message = (
                f"--bound {NAMES[c.joint[1]]}={_text(here)}: no curve of degree {c.degree} for the {told(c.joint)} that"
                f" stays inside was found; the nearest goes to {least:.3f} .. {most:.3f} deg"
            )
            found.append(Diagnostic("HA228", message, severity=Severity.ERROR, help="try another --degree"))
    return found


def _text(i: Interval) -> str:
    return f"{float(i.low):g}..{float(i.high):g}"
