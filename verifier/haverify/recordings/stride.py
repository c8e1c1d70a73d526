"""How long a stride takes, from the joint angles alone.

A recording of several strides repeats itself. One that is too short for that still shows each leg doing what the other
did half a stride before; one that is a single stride ends as it begins; one that is half a stride of a symmetric walk
ends as it begins with the legs exchanged.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from haverify.recordings.feet import values
from haverify.recordings.recording import JOINTS, Recording
from haverify.text.record import record

if TYPE_CHECKING:
    from numpy import ndarray

    Array = ndarray[Any, Any]

LOOK = 30.0  # seconds of a recording that are looked at
LOOK_RATE = 100.0  # samples a second that are enough for that
_LEAST, _MOST = 0.35, 4.0  # seconds of a stride
_ALIKE = 0.12  # mean squared difference over variance, below which two stretches are alike; unrelated ones have 2
_STILL = 4.0  # degrees: joints that move less on average stand still


@record
class Stride:
    """`seconds` of a stride; `kind` is `repeats`, `alternates`, `closes`, `mirrors`, or `` where none is seen."""

    seconds: float
    kind: str
    unlike: float


def grid(r: Recording) -> Array:
    """Evenly spaced instants of the recording, as many as it has samples."""
    import numpy as np

    return np.linspace(float(r.times[0]), float(r.times[-1]), len(r.times))


def is_still(r: Recording) -> bool:
    """Whether hips and knees move less than walking does."""
    import numpy as np

    t = grid(r)
    return bool(np.mean([np.std(values(r, j, t)) for j in ("lh", "rh", "lk", "rk")]) < _STILL)


def stride(r: Recording) -> Stride:
    """The stride of a recording whose joints move."""
    import numpy as np

    t = grid(r)
    t = t[t <= t[0] + LOOK]
    t = np.linspace(t[0], t[-1], min(len(t), int(LOOK_RATE * (t[-1] - t[0])) + 1)) if len(t) > 40 else t
    angles = {j: values(r, j, t) for j in JOINTS}
    scaled = {j: (a - a.mean()) / max(float(np.std(a)), 1.0) for j, a in angles.items()}
    step = float(t[1] - t[0]) if len(t) > 1 else 1.0
    seen = _repeats(scaled, step) or _closes(scaled, step) or _alternates(scaled, step) or _mirrors(angles, step)
    return seen or Stride(0.0, "", 2.0)


def _repeats(x: Mapping[str, Array], step: float) -> Stride | None:
    """The shortest lag after which all joints repeat themselves, over at least 0.4 of it."""
    return _least(x, step, _same, 0.4)


def _alternates(x: Mapping[str, Array], step: float) -> Stride | None:
    """The sum of the lags after which left follows right and right follows left."""
    lags = [_least(x, step, other, 0.4, half=True) for other in (_other("l"), _other("r"))]
    if lags[0] is None or lags[1] is None:
        return None
    seconds = lags[0].seconds + lags[1].seconds
    unlike = max(lags[0].unlike, lags[1].unlike)
    return Stride(_refined(x, step, seconds), "alternates", unlike)


def _refined(x: Mapping[str, Array], step: float, seconds: float) -> float:
    """The lag within 6 % of a stride at which its end is most like the beginning, where there is a tenth of it."""
    first, last = int(0.94 * seconds / step), int(1.06 * seconds / step) + 1
    last = min(last, int((len(x["lh"]) - 1) / 1.1))
    unlike = [_unlike(x, k, _same) for k in range(first, last + 1)]
    best = unlike.index(min(unlike)) if unlike else 0
    if not 0 < best < len(unlike) - 1 or unlike[best] > _ALIKE:
        return seconds
    return (first + best + _between(unlike[best - 1 : best + 2])) * step


def _closes(x: Mapping[str, Array], step: float) -> Stride | None:
    """The whole recording, where it ends as it begins."""
    import numpy as np

    unlike = float(np.mean([(v[-1] - v[0]) ** 2 for v in x.values()]))
    n = len(x["lh"]) - 1
    return Stride(n * step, "closes", unlike) if n * step >= _LEAST and unlike < _ALIKE / 4 else None


def _mirrors(angles: Mapping[str, Array], step: float) -> Stride | None:
    """Twice the recording, where it ends as it begins with the legs exchanged."""
    import numpy as np

    unlike = []
    for joint in "hka":
        right, left = angles["r" + joint], angles["l" + joint]
        spread = max(float(np.std(np.concatenate([right, left]))), 1.0)
        unlike += [(right[-1] - left[0]) / spread, (left[-1] - right[0]) / spread]
    mean, seconds = float(np.mean(np.square(unlike))), 2 * (len(angles["lh"]) - 1) * step
    return Stride(seconds, "mirrors", mean) if seconds >= _LEAST and mean < _ALIKE else None


def _same(joint: str) -> str | None:
    return joint


def _other(side: str) -> Callable[[str], str | None]:
    """For the joints of a side those of the other."""
    other = {"l": "r", "r": "l"}[side]
    return lambda joint: other + joint[1] if joint[0] == side else None


def _least(
    x: Mapping[str, Array], step: float, partner: Callable[[str], str | None], overlap: float, half: bool = False
) -> Stride | None:
    """The first lag at which joints are most alike their partners, after lags at which they are not."""
    n = len(x["lh"])
    scale = 0.5 if half else 1.0
    first = max(round(_LEAST * scale / step), 1)
    last = min(round(_MOST * scale / step), int((n - 1) / (1 + overlap)))
    unlike = [_unlike(x, k, partner) for k in range(first, last + 1)]
    best, seen_unlike = None, False
    for i in range(1, len(unlike) - 1):
        seen_unlike = seen_unlike or max(unlike[: i + 1]) > 3 * _ALIKE
        is_low = unlike[i] <= unlike[i - 1] and unlike[i] <= unlike[i + 1]
        if is_low and unlike[i] < (2.5 if half else 1) * _ALIKE and seen_unlike:
            best = i if best is None or unlike[i] < unlike[best] / 4 else best
    if best is None:
        return None
    return Stride((first + best + _between(unlike[best - 1 : best + 2])) * step, "repeats", unlike[best])


def _unlike(x: Mapping[str, Array], lag: int, partner: Callable[[str], str | None]) -> float:
    import numpy as np

    pairs = [(x[j], x[p]) for j in JOINTS if (p := partner(j)) is not None]
    return float(np.mean([np.mean((b[lag:] - a[: len(a) - lag]) ** 2) for a, b in pairs]))


def _between(three: list[float]) -> float:
    """The minimum of the parabola through three equally spaced values, from the middle one."""
    a, b, c = three
    bend = a - 2 * b + c
    return (a - c) / (2 * bend) if bend > 0 else 0.0
