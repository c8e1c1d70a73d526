"""Bands around a joint's curve: mean +- k standard deviations over cycles or recordings, and what they hold.

Two of 95 %: one for the samples of a further curve, percent by percent, and a wider one for the whole of it. Both come
with the shares they hold of curves they are not made of, since a band holds what it was made of too well.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from haverify.fitting.deviations import along_a_curve, at_a_point, roughness
from haverify.fitting.percent import POINTS, Percents, percents
from haverify.recordings.cycles import Cycle
from haverify.text.record import record

if TYPE_CHECKING:
    from numpy import ndarray

    Array = ndarray[Any, Any]

LEAST = 3
"""Curves that a band of samples needs."""
LEAST_WHOLE = 5
"""Curves that a band of whole curves needs: with fewer it would be tens of deviations wide and say nothing."""
FOLDS = 10


@record
class Band:
    """`mean` and `sd` (101,) of `count` cycles or recordings by percent.

    95 % of the samples of a further one lie within `k` deviations, 95 % of whole curves within `whole` (None: too few).
    """

    joint: str
    mean: Array
    sd: Array
    k: float
    whole: float | None
    count: int
    roughness: float
    samples: int  # of a cycle

    @property
    def low(self) -> Array:
        return self.mean - self.k * self.sd

    @property
    def high(self) -> Array:
        return self.mean + self.k * self.sd


@record
class Coverage:
    """The share of samples in the band for samples, of whole curves in the one for curves (None: there is none)."""

    samples: float
    curves: float | None


def band(cycles: Sequence[Cycle], joint: str) -> Band | None:
    """The band of a joint for a further cycle, or recording where there are three or more; None of fewer than three."""
    return _band(percents(cycles, joint))


def _band(p: Percents) -> Band | None:
    n = p.count
    if n < LEAST:
        return None
    means = _means(p.between, p)
    rough = roughness(means)
    return Band(
        p.joint, means.mean(axis=0), _deviation(p), at_a_point(n), whole(n, rough, p.samples), n, rough, p.samples
    )


def whole(n: int, rough: float, samples: int) -> float | None:
    """How many deviations hold whole curves; None of too few."""
    return along_a_curve(n, rough, samples) if n >= LEAST_WHOLE else None


def _means(curves: Array, p: Percents) -> Array:
    """The mean curve of each unit (units, 101)."""
    import numpy as np

    total = np.zeros((p.count, POINTS))
    np.add.at(total, p.unit, curves)
    return np.asarray(total / np.bincount(p.unit)[:, None])


def _deviation(p: Percents) -> Array:
    """The standard deviation of a sample of a further unit.

    The variance between means of units has but a part of that between cycles of one: 1/m of it in the mean of m cycles.
    The rest is added.
    """
    import numpy as np

    means, sizes = _means(p.nearest, p), np.bincount(p.unit)
    variance = means.var(axis=0, ddof=1)
    freedom = len(p.unit) - p.count
    if freedom > 0:
        within = ((p.nearest - means[p.unit]) ** 2).sum(axis=0) / freedom
        variance = variance + within * (1 - float(np.mean(1 / sizes)))
    return np.asarray(np.sqrt(variance))


def coverage(b: Band, cycles: Sequence[Cycle]) -> Coverage:
    """How much of some cycles a band holds."""
    import numpy as np

    grid = np.linspace(0, 1, POINTS)
    far = []
    for c in cycles:
        at, y = map(np.array, c.near[b.joint])
        off = np.abs(y - np.interp(at, grid, b.mean))
        far.append(off / np.maximum(np.interp(at, grid, b.sd), 1e-9))
    samples = float((np.concatenate(far) <= b.k).mean())
    return Coverage(samples, None if b.whole is None else float(np.mean([f.max() <= b.whole for f in far])))


def in_turns(cycles: Sequence[Cycle], joint: str) -> Coverage | None:
    """What bands hold of curves left out when they are made: each unit in turn, or a tenth of them; None of too few.

    Units count alike, however many cycles they have.
    """
    import numpy as np

    p = percents(cycles, joint)
    parts = min(p.count, FOLDS)
    found: list[Coverage] = []
    for part in range(parts):
        out = p.unit % parts == part
        b = _band(p.where(~out))
        if b is not None:
            for unit in np.unique(p.unit[out]):
                left = [c for c, u in zip(cycles, p.unit, strict=True) if u == unit]
                found.append(coverage(b, left))
    if not found:
        return None
    curves = [c.curves for c in found if c.curves is not None]
    return Coverage(float(np.mean([c.samples for c in found])), float(np.mean(curves)) if curves else None)


def csv(bands: Sequence[Band]) -> str:
    """The bands of some joints, by percent, to a thousandth of a degree."""
    columns = [(f"{b.joint}_{name}", values) for b in bands for name, values in _edges(b)]
    labels = ",".join(["percent", *(name for name, _ in columns)])
    rows = [",".join([str(p), *(_text(float(v[p])) for _, v in columns)]) for p in range(POINTS)]
    return "\n".join([labels, *rows]) + "\n"


def _edges(b: Band) -> list[tuple[str, Array]]:
    edges = [("low", b.low), ("high", b.high)]
    if b.whole is not None:
        edges += [("curve_low", b.mean - b.whole * b.sd), ("curve_high", b.mean + b.whole * b.sd)]
    return edges


def _text(x: float) -> str:
    return str(float(Fraction(round(x * 1000), 1000)))
