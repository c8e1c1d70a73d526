"""Samples that leap away from their neighbours and back: one, or a few in a row, told and left out where that is clear.

A sample is compared with the cubic through the two samples on either side of it (or of the run it is in). It leaps
where it is further off than a joint moves in that time, and eight times as far as the samples around it are: the
outlier rule of F. R. Hampel (Journal of the American Statistical Association 69, 1974, 383-393), in its usual form for
series, on what interpolation leaves. One sample alone is left out: no joint gets there and back between two others.
Longer runs may be movement, and stay unless the caller says otherwise.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.recordings.recording import JOINTS, Recording, told
from haverify.text.record import record, replace

if TYPE_CHECKING:
    from numpy import ndarray

    Array = ndarray[Any, Any]

LONGEST = 5  # samples of a run
_FLOOR = 2.0  # degrees at 60 Hz by which a sample has to be off; by the square of the gap more over a longer one
_GAP = 1 / 60
_BENDING = 0.1  # seconds
_TIMES = 8 * 1.4826  # median distances of the samples around; 1.4826 makes them standard deviations
_AROUND = 10
_SHOWN = 5
_MOST = 0.05  # of the samples of a joint: more are noise, no leaps


@record
class Leap:
    """`count` samples from `first` on, which lie `off` degrees from the curve through their neighbours.

    `count` is 0 where something leaps near `first` without coming clearly back.
    """

    joint: str
    first: int
    count: int
    off: float


def settled(r: Recording, outliers: str) -> tuple[Recording, list[Diagnostic]]:
    """The recording without the samples that leap, and what is said of them.

    `outliers`: `single` (only runs of one are left out), `drop` (all), `keep` (none).
    """
    found = leaps(r)
    if not found:
        return r, []
    longest = {"single": 1, "drop": LONGEST}.get(outliers, 0)
    gone = [x for x in found if 0 < x.count <= longest]
    angles = {j: list(vs) for j, vs in r.angles.items()}
    for x in gone:
        for i in range(x.first, x.first + x.count):
            angles[x.joint][i] = None
    return replace(r, angles={j: tuple(vs) for j, vs in angles.items()}), _told(r, found, gone, outliers)


def leaps(r: Recording) -> list[Leap]:
    """The leaps of all joints, in order of time; none of a joint in which they are so many that they are noise."""
    import numpy as np

    found = []
    for joint in JOINTS:
        y = np.array(r.near[joint])
        there = np.flatnonzero(np.isfinite(y))
        if len(there) > 2 * LONGEST:
            here = leaping(np.array(r.clock)[there], y[there])
            last = {i: int(there[i + max(n, 1) - 1]) for i, n, _ in here}
            found += [Leap(joint, int(there[i]), n, off) for i, n, off in here if last[i] - there[i] <= n]
    return sorted(found, key=lambda x: (x.first, JOINTS.index(x.joint)))


def leaping(t: Array, y: Array) -> list[tuple[int, int, float]]:
    """(first sample, how many, distance) of the runs of a series that leap; short ones before long ones.

    Last those that leap without coming back, with 0 for how many.
    """
    import numpy as np

    gone, found = np.zeros(len(y), dtype=bool), list[tuple[int, int, float]]()
    for count in range(1, LONGEST + 1):
        there = np.flatnonzero(~gone)
        for first, off in _runs(t[there], y[there], count):
            run = there[first : first + count]
            if run[-1] - run[0] == count - 1:
                gone[run] = True
                found.append((int(run[0]), count, off))
    there = np.flatnonzero(~gone)
    distances, likely = _likely(t[there], y[there], 1)
    for k in likely:
        at = int(there[k])
        if not any(abs(at - i) <= 2 * LONGEST for i, _, _ in found):
            found.append((at, 0, float(distances[k])))
    return found


def _likely(t: Array, y: Array, count: int) -> tuple[Array, list[int]]:
    """How far runs of one length are off, and which of them stand out, the farthest first; none of too many."""
    import numpy as np

    off, size, strict = _offs(t, y, count)
    over = np.abs(off) / strict
    found = [int(k) for k in np.argsort(-over)[: int((over > 1).sum())] if _stands_out(off, size, int(k))]
    return off, found if len(found) <= _MOST * len(y) + LONGEST else []


def _runs(t: Array, y: Array, count: int) -> list[tuple[int, float]]:
    """The runs of one length that leap, with their distance; farthest ones are looked at first."""
    off, likely = _likely(t, y, count)
    found: list[tuple[int, float]] = []
    for k in likely:
        first = min(_choices(k, count, len(y)), key=lambda i: _left_over(t, y, i, count))
        beside = [i for i, _ in found if abs(i - first) <= count + 1]
        if not beside and _left_over(t, y, first, count) <= 1:
            found.append((first, float(off[first])))
    return found


def _choices(k: int, count: int, n: int) -> list[int]:
    """The samples that a leap seen at `k` may be: at an end of the series also the one beside it."""
    if count == 1 and k < 2:
        return [0, 1]
    return [n - 1, n - 2] if count == 1 and k > n - 3 else [k]


def _left_over(t: Array, y: Array, first: int, count: int) -> float:
    """How far samples around a run still are off without it, as a multiple of what joints can do."""
    import numpy as np

    begin, end = max(first - 6, 0), first + count + 6
    kept = [k for k in range(begin, min(end, len(y))) if not first <= k < first + count]
    off, _, strict = _offs(t[kept], y[kept], 1)
    near = slice(max(first - begin - 2, 0), first - begin + 2)
    return float(np.max(np.abs(off[near]) / strict[near]))


def _stands_out(off: Array, size: Array, k: int) -> bool:
    """Whether a run is far off in comparison with those around it, too."""
    import numpy as np

    beside = np.concatenate([size[max(k - _AROUND, 0) : max(k - 2, 0)], size[k + 3 : k + 3 + _AROUND]])
    return len(beside) > 0 and abs(off[k]) > _TIMES * float(np.median(beside))


def _offs(t: Array, y: Array, count: int) -> tuple[Array, Array, Array]:
    """How far each run of `count` samples is off at least (0: not all to one side) and at most; how far joints may be.

    Runs of more than one sample that take longer than a joint needs to bend and stretch may be off by any distance.
    """
    import numpy as np

    first = np.arange(len(y) - count + 1)
    begin = np.clip(first - 2, 0, len(y) - count - 4)
    four = begin[:, None] + np.arange(4)
    four = np.where(four >= first[:, None], four + count, four)
    each, wide = [], np.zeros(len(first))
    for k in range(count):
        weights = _weights(t[four], t[first + k])
        each.append(y[first + k] - (weights * y[four]).sum(axis=1))
        wide = np.maximum(wide, np.abs(weights).sum(axis=1))
    off = np.array(each)
    least = np.where((off > 0).all(axis=0), off.min(axis=0), np.where((off < 0).all(axis=0), off.max(axis=0), 0.0))
    gap = t[np.minimum(first + count, len(t) - 1)] - t[np.maximum(first - 1, 0)]
    usual = np.maximum(1.0, (gap / (2 * _GAP)) ** 2)
    if count > 1:
        usual[gap > _BENDING] = np.inf
    return least, np.abs(off).max(axis=0), _FLOOR * usual * np.maximum(wide / 1.7, 1.0)


def _weights(at: Array, x: Array) -> Array:
    """Lagrange's weights (n, 4) of four instants each for the value of their cubic at `x` (n,)."""
    import numpy as np

    weights = np.ones(at.shape)
    for i in range(4):
        for j in range(4):
            if i != j:
                weights[:, i] *= (x - at[:, j]) / (at[:, i] - at[:, j])
    return weights


def _told(r: Recording, found: Sequence[Leap], gone: Sequence[Leap], outliers: str) -> list[Diagnostic]:
    shown = []
    for x in found[:_SHOWN]:
        many = {0: "and does not clearly come back", 1: "for one sample"}.get(x.count, f"for {x.count} samples")
        what = f"the {told(x.joint)} leaps by {x.off:.1f} deg at {float(r.times[x.first]):.4g} s {many}"
        done = "left out" if x in gone else "kept"
        advice = "" if x in gone or outliers == "keep" or not x.count else "haverify fit --outliers drop leaves it out"
        shown.append(Diagnostic("HA227", f"{what}: {done}", r.where(x.joint, x.first), help=advice or None))
    if len(found) > _SHOWN:
        rest = found[_SHOWN:]
        left = sum(1 for x in rest if x in gone)
        message = f"{r.path}: {len(rest)} more leaps, {left} of them left out"
        shown.append(Diagnostic("HA227", message))
    return shown
