"""Recordings of walks for tests: those in `models/walks`, and made-up ones with known strides."""

import math
import random
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction as Q
from pathlib import Path

from haverify.recordings.recording import Recording
from haverify.recordings.write import motion
from haverify.run.recordings import Recorded, recorded
from haverify.text.record import replace

WALKS = Path(__file__).parents[1] / "models" / "walks"
TRIAL = "subject01_walk1_ik_long.mot"


def files(*names: str) -> Recorded:
    """What some files of `models/walks` hold."""
    return recorded(str(WALKS / n) for n in names)


def walk_of(name: str) -> Recording:
    """The recording in a file of `models/walks`."""
    (r,) = files(name).recordings
    return r


def codes(found: Sequence[object]) -> list[str]:
    """The codes of findings."""
    return [d.code for d in found]  # type: ignore[attr-defined]


def made(seconds: float, period: float = 1.1, rate: float = 100.0, noise: float = 0.0, seed: int = 1) -> Recording:
    """A made-up walk: right heel strikes near 0, `period`, ... ; the left leg does the same half a period later."""
    draw = random.Random(seed)
    times = [Q(k, round(rate)) for k in range(round(seconds * rate) + 1)]
    angles = {
        side + joint: tuple(
            Q(round((curve(float(t) / period + shift) + draw.gauss(0, noise)) * 10_000), 10_000) for t in times
        )
        for side, shift in (("r", 0.0), ("l", 0.5))
        for joint, curve in CURVES.items()
    }
    return Recording("made.mot", "0" * 64, tuple(times), angles)


def _hip(s: float) -> float:
    return 5 + 22 * math.cos(2 * math.pi * s) + 3 * math.sin(4 * math.pi * s)


def _knee(s: float) -> float:
    s %= 1
    return -5 - 58 * math.exp(-(((s - 0.72) / 0.105) ** 2)) - 14 * math.exp(-(((s - 0.15) / 0.09) ** 2))


def _ankle(s: float) -> float:
    s %= 1
    return 4 * math.sin(2 * math.pi * (s - 0.2)) - 14 * math.exp(-(((s - 0.63) / 0.06) ** 2))


CURVES: Mapping[str, Callable[[float], float]] = {"h": _hip, "k": _knee, "a": _ankle}


def cut(r: Recording, first: int, last: int) -> Recording:
    """The samples from `first` up to, not including, `last`."""
    angles = {j: v[first:last] for j, v in r.angles.items()}
    return replace(r, times=r.times[first:last], angles=angles)


def as_motion(r: Recording) -> str:
    """A recording as the text of a `.mot` file."""
    return motion("made", r.times, r.angles)
