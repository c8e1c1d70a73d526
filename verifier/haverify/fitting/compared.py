"""Two walks beside each other, percent by percent of their cycles: distance, peak and correlation of each joint."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

from haverify.fitting.percent import POINTS, normalised
from haverify.recordings.cycles import Cycle
from haverify.recordings.phases import PHASES
from haverify.recordings.recording import JOINTS, told
from haverify.text.record import record

if TYPE_CHECKING:
    from numpy import ndarray

    Array = ndarray[Any, Any]


@record
class Cycled:
    """A walk over its cycle: `angles[joint]` (101,) in degrees at 0 .. 100 %.

    `sd` is the standard deviation between its cycles, where it has three or more. `shares` are where its phases end;
    `seconds` is its period.
    """

    name: str
    angles: Mapping[str, Array]
    sd: Mapping[str, Array]
    shares: Sequence[float]
    seconds: float


def cycled(name: str, cycles: Sequence[Cycle], shares: Sequence[float]) -> Cycled:
    """The mean of some cycles."""
    curves = {j: normalised(cycles, j) for j in JOINTS}
    sd = {j: c.std(axis=0, ddof=1) for j, c in curves.items()} if len(cycles) > 2 else {}
    seconds = sum(float(c.length) for c in cycles) / len(cycles)
    return Cycled(name, {j: c.mean(axis=0) for j, c in curves.items()}, sd, shares, seconds)


@record
class Distance:
    """How far a joint of one walk is from that of another: root mean square, largest distance (deg), correlation.

    `phases` are the root mean squares in the phases of the first walk. `score` is the root mean square over the
    standard deviation between the cycles of the first walk, where that is known.
    """

    joint: str
    rms: float
    peak: float
    correlation: float
    phases: tuple[float, ...]
    score: float | None


def shifted(a: Cycled, b: Cycled) -> tuple[Cycled, int]:
    """The second walk begun as many percent later as brings it nearest to the first, and this number.

    It is left where it is, unless the shift halves the distance: cycles may begin at another event.
    """
    import numpy as np

    def apart(k: int) -> float:
        return float(np.mean([np.mean((a.angles[j] - _rolled(b.angles[j], k)) ** 2) for j in JOINTS]))

    best = min(range(POINTS - 1), key=apart)
    if apart(best) > apart(0) / 4:
        return b, 0
    return Cycled(b.name, {j: _rolled(v, best) for j, v in b.angles.items()}, {}, b.shares, b.seconds), best


def _rolled(y: Array, percent: int) -> Array:
    """The curve begun later, round from its end to its beginning."""
    import numpy as np

    inner = np.roll(y[:-1], -percent)
    return np.append(inner, inner[0]) if percent else y


def distances(a: Cycled, b: Cycled) -> list[Distance]:
    """The distances of all joints of the second walk from the first."""
    import numpy as np

    edges = [0, *(round(100 * s) for s in a.shares), POINTS - 1]
    found = []
    for j in JOINTS:
        off = b.angles[j] - a.angles[j]
        spread = np.std(a.angles[j]) * np.std(b.angles[j])
        same = float(np.mean((a.angles[j] - a.angles[j].mean()) * (b.angles[j] - b.angles[j].mean())))
        phases = tuple(_rms(off[p : q + 1]) for p, q in pairwise(edges))
        score = float(np.sqrt(np.mean((off / np.maximum(a.sd[j], 0.1)) ** 2))) if j in a.sd else None
        peak = float(off[np.argmax(np.abs(off))])
        found.append(Distance(j, _rms(off), peak, same / float(spread) if spread > 0 else 0.0, phases, score))
    return found


def _rms(off: Array) -> float:
    import numpy as np

    return float(np.sqrt(np.mean(off**2)))


def table(a: Cycled, b: Cycled, shift: int, found: Sequence[Distance]) -> str:
    """The distances, to read."""
    later = f", begun {shift} % later" if shift else ""
    lines = [f"{b.name} ({b.seconds:.3f} s{later}) from {a.name} ({a.seconds:.3f} s), degrees:"]
    scored = any(d.score is not None for d in found)
    lines.append(
        "joint            rms    peak   corr " + ("  rms/SD" if scored else "") + "".join(f"{p:>7}" for p in PHASES)
    )
    for d in found:
        score = f"{_cell(d.score, 8)}" if d.score is not None else ""
        phases = "".join(f"{_cell(x, 7)}" for x in d.phases)
        lines.append(f"{told(d.joint):<13} {_cell(d.rms, 6)} {_cell(d.peak, 7)} {d.correlation:>6.3f} {score}{phases}")
    return "\n".join(lines) + "\n"


def _cell(x: float, width: int) -> str:
    """A number right in its column, with fewer digits where it would touch the one before."""
    ways = (format(x, f) for f in (".2f", ".0f"))
    return next((w for w in ways if len(w) < width), format(x, ".0e")).rjust(width)
