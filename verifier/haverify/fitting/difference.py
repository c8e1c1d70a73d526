"""The thesis' band around a curve: the difference between fits of degree 4 and of degree 2."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from haverify.fitting.knots import Knots
from haverify.recordings.cycles import Cycle
from haverify.text.record import record

if TYPE_CHECKING:
    from numpy import ndarray

    Array = ndarray[Any, Any]


@record
class Difference:
    """The band between fits of degree 4 and of degree 2, phase by phase: its mean width, the share of samples in it."""

    joint: str
    width: float
    samples: float


def difference(cycles: Sequence[Cycle], joint: str, knots: Knots) -> Difference:
    """The thesis' band (section 5.14): the difference of fits of degree 4 and 2 on either side of the one of degree 4.

    Each phase is fitted by itself. A phase with fewer than six samples has no such band and counts as outside.
    """
    import numpy as np

    t = np.concatenate([np.array(c.near[joint][0]) for c in cycles]) * float(knots.period)
    y = np.concatenate([np.array(c.near[joint][1]) for c in cycles])
    widths, inside = [], 0
    for a, b in zip(knots.at, knots.at[1:], strict=False):
        here = (float(a) <= t) & (t < float(b))
        u, v = (t[here] - float(a)) / float(b - a), y[here]
        if len(u) < 6:
            continue
        four, two = (np.polyval(np.polyfit(u, v, d), u) for d in (4, 2))
        inside += int((np.abs(v - four) <= np.abs(four - two)).sum())
        widths.append(float(np.abs(four - two).mean()))
    return Difference(joint, float(np.mean(widths or [0.0])), inside / max(len(y), 1))
