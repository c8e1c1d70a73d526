"""What share a right band may hold of few curves: 95 % on average, and each time more or less.

Curves are drawn that are as many and as rough as those of the walk, from a normal population. Bands are made of some of
them, as they are made of the walk's, and tried on the others.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import exp, pi
from typing import TYPE_CHECKING, Any

from haverify.fitting.bands import FOLDS, Band, whole
from haverify.fitting.deviations import at_a_point
from haverify.text.record import record

if TYPE_CHECKING:
    from numpy import ndarray

    Array = ndarray[Any, Any]

_DRAWS, _POINTS, _HARMONICS = 400, 34, 16
_MOST = 40
"""Curves drawn at most: shares of more vary less, so that the range told is too wide."""
_JOINTS = 3
"""Hip, knee and ankle are drawn apart from each other; the left and the right one of a person are taken as alike."""


@record
class Range:
    """Between what 95 of 100 shares of a right band lie: of samples, and of whole curves (None: there is no band)."""

    samples: tuple[float, float]
    curves: tuple[float, float] | None


def of_held_out(bands: Sequence[Band], tried: int) -> Range:
    """Bands of `n` units, tried on others."""
    n = min(bands[0].count, _MOST)
    drawn = _drawn(_roughness(bands), n + min(tried, _MOST))
    return _range([_shares(drawn[..., :n, :], drawn[..., n:, :], bands)])


def of_turns(bands: Sequence[Band], units: int) -> Range:
    """Each of some units in turn, or a tenth of them, tried on bands of the others."""
    import numpy as np

    n = min(units, _MOST)
    drawn, parts = _drawn(_roughness(bands), n), min(n, FOLDS)
    turns = [np.arange(n) % parts == part for part in range(parts)]
    return _range([_shares(drawn[..., ~out, :], drawn[..., out, :], bands) for out in turns])


def _roughness(bands: Sequence[Band]) -> float:
    return sum(b.roughness for b in bands) / len(bands)


def _drawn(rough: float, units: int) -> Array:
    """Curves of mean 0 and deviation 1 (draws, joints, units, points), the same in each call: harmonics by chance."""
    import numpy as np

    weights = np.array(_spectrum(rough))
    angle = 2 * pi * np.outer(np.arange(1, _HARMONICS + 1), np.arange(_POINTS) / _POINTS)
    waves = np.concatenate([np.ones((1, _POINTS)), np.cos(angle), np.sin(angle)])
    scale = np.sqrt(np.concatenate([weights, weights[1:]]))
    chance = np.random.default_rng(1).standard_normal((_DRAWS, _JOINTS, units, len(scale)))
    return np.asarray((chance * scale) @ waves)


def _spectrum(rough: float) -> list[float]:
    """Variances of harmonics, 1 in sum, whose curves are as rough: `2 pi sqrt(sum w_k k^2)` is their roughness."""
    narrow, wide = 1e-3, 1e3
    for _ in range(60):
        middle = (narrow * wide) ** 0.5
        weights = _weights(middle)
        is_rough = 2 * pi * sum(w * k * k for k, w in enumerate(weights)) ** 0.5 > rough
        narrow, wide = (narrow, middle) if is_rough else (middle, wide)
    return _weights(narrow)


def _weights(spread: float) -> list[float]:
    bell = [exp(-((k / spread) ** 2) / 2) for k in range(_HARMONICS + 1)]
    return [b / sum(bell) for b in bell]


def _shares(training: Array, tried: Array, bands: Sequence[Band]) -> tuple[Array, Array | None]:
    """The share of samples, and of curves, of each draw (draws,) in a band."""
    import numpy as np

    mean, sd = training.mean(axis=2, keepdims=True), training.std(axis=2, ddof=1, keepdims=True)
    far = np.abs(tried - mean) / sd
    n = training.shape[2]
    wide = whole(n, _roughness(bands), bands[0].samples)
    samples = (far <= at_a_point(n)).mean(axis=(1, 2, 3))
    return samples, None if wide is None else (far.max(axis=3) <= wide).mean(axis=(1, 2))


def _range(parts: Sequence[tuple[Array, Array | None]]) -> Range:
    curves = [c for _, c in parts if c is not None]
    return Range(_ends([s for s, _ in parts]), _ends(curves) if curves else None)


def _ends(parts: Sequence[Array]) -> tuple[float, float]:
    import numpy as np

    low, high = np.quantile(np.mean(parts, axis=0), (0.025, 0.975))
    return float(low), float(high)
