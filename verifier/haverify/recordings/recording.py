"""A recording of a walk: joint angles of both legs over time, and what else its file tells about the feet."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from fractions import Fraction
from functools import cached_property

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.text.record import field, record
from haverify.text.span import Span

Q = Fraction
Angles = tuple[Q | None, ...]

JOINTS = ("lh", "rh", "lk", "rk", "la", "ra")
"""Left and right hip, knee, ankle; degrees; flexion of the hip +, of the knee -, dorsiflexion of the ankle +."""

NAMES = {"h": "hip", "k": "knee", "a": "ankle", "l": "left", "r": "right"}


def told(joint: str) -> str:
    """A joint in words.

    >>> told("lk")
    'left knee'
    """
    return f"{NAMES[joint[0]]} {NAMES[joint[1]]}"


@record
class Events:
    """Heel strikes and toe-offs of one leg, in seconds, in order; `method` says where they come from."""

    strikes: tuple[Q, ...] = ()
    offs: tuple[Q, ...] = ()
    method: str = ""


@record
class Track:
    """Heel and toe of one foot over the recording's times, metres: x forward of the pelvis, y above the floor."""

    heel_x: tuple[float, ...]
    toe_x: tuple[float, ...]
    heel_y: tuple[float, ...]
    toe_y: tuple[float, ...]


@record
class Forces:
    """Vertical ground reaction force in newtons under each foot (`l`, `r`) at its own times, in seconds."""

    path: str
    times: tuple[Q, ...]
    vertical: Mapping[str, tuple[Q, ...]]


def nowhere(joint: str, sample: int) -> Span | None:
    """The place of a sample that no text file holds."""
    del joint, sample
    return None


@record
class Recording:
    """A recording.

    `times` increase, in seconds; `angles[joint]` has one value or None (missing) for each, in degrees with the signs of
    `JOINTS`. `rounding` is how far a value may be from the recorded one (0 where the file is in degrees). `facts` are
    sentences for the documentation of what is made of the recording. `where(joint, i)` is the place of a sample.
    """

    path: str
    sha256: str
    times: tuple[Q, ...]
    angles: Mapping[str, Angles]
    rounding: Q = Q(0)
    tracks: Mapping[str, Track] = field(default_factory=dict)
    marked: Mapping[str, Events] = field(default_factory=dict)
    facts: tuple[str, ...] = ()
    where: Callable[[str, int], Span | None] = nowhere

    @cached_property
    def clock(self) -> tuple[float, ...]:
        """The times in floating point."""
        return tuple(float(t) for t in self.times)

    @cached_property
    def near(self) -> Mapping[str, tuple[float, ...]]:
        """The angles in floating point, NaN where one is missing."""
        return {j: tuple(math.nan if v is None else float(v) for v in vs) for j, vs in self.angles.items()}

    @property
    def name(self) -> str:
        """The file's name without folder and suffix."""
        return self.path.replace("\\", "/").rsplit("/", 1)[-1].rsplit(".", 1)[0]

    @property
    def duration(self) -> Q:
        return self.times[-1] - self.times[0]


@record
class Read:
    """What a file comes to: a recording, or ground forces, or neither where `found` says why."""

    recording: Recording | None
    forces: Forces | None
    found: tuple[Diagnostic, ...]
