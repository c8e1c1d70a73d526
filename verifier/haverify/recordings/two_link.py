"""The leg as two links in a plane: joint angles from the position of its end, both ways of bending, and back.

The first axis points down, the second forward. The hip turns the thigh from the first axis, the knee the shank from the
thigh; flexion of the hip is positive, of the knee negative, so a human leg bends the second way.
Source: V. B. Semwal, "Data Driven Computational Model for Bipedal Walking and Push Recovery", IIIT Allahabad, 2016,
eq. 11 and 12; its Algorithm 1 differs from them (`as_printed`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from haverify.text.record import record

Point = tuple[float, float]


@record
class Bent:
    """Hip and knee in degrees."""

    hip: float
    knee: float


@record
class OutOfReach:
    """The end is `distance` from the hip, but a leg reaches from `least` to `most`."""

    distance: float
    least: float
    most: float

    def __str__(self) -> str:
        return f"{self.distance:.4g} from the hip, but the leg reaches {self.least:.4g} .. {self.most:.4g}"


def forward(bent: Bent, thigh: float, shank: float) -> Point:
    """Where the end is.

    >>> forward(Bent(0.0, 0.0), 0.4, 0.4)
    (0.8, 0.0)
    """
    hip, both = math.radians(bent.hip), math.radians(bent.hip + bent.knee)
    return thigh * math.cos(hip) + shank * math.cos(both), thigh * math.sin(hip) + shank * math.sin(both)


def inverse(end: Point, thigh: float, shank: float) -> tuple[Bent, Bent] | OutOfReach:
    """Both ways to reach a point: with the knee bent forward (positive), and backward as people's are."""
    x, y = end
    distance, least, most = math.hypot(x, y), abs(thigh - shank), thigh + shank
    if not least - 1e-9 * most <= distance <= most * (1 + 1e-9) or distance == 0:
        return OutOfReach(distance, least, most)
    cosine = (x * x + y * y - thigh * thigh - shank * shank) / (2 * thigh * shank)
    knee = math.acos(min(1.0, max(-1.0, cosine)))
    return _bent(x, y, knee, thigh, shank), _bent(x, y, -knee, thigh, shank)


def _bent(x: float, y: float, knee: float, thigh: float, shank: float) -> Bent:
    hip = math.atan2(y, x) - math.atan2(shank * math.sin(knee), thigh + shank * math.cos(knee))
    return Bent(math.degrees(hip), math.degrees(knee))


def as_printed(ends: Sequence[Point], thigh: float, shank: float) -> list[Bent]:
    """Algorithm 1 as it is printed: cosines divided by the largest of them, k2 made with a cosine for a sine.

    Neither is in eq. 11 and 12; `forward` does not lead back to the ends.
    """
    cosines = [(x * x + y * y - thigh * thigh - shank * shank) / (2 * thigh * shank) for x, y in ends]
    largest, found = max(cosines), []
    for (x, y), c in zip(ends, cosines, strict=True):
        cosine = c / largest
        sine = math.sqrt(max(0.0, 1 - cosine * cosine))
        hip = math.atan2(y, x) - math.atan2(shank * cosine, thigh + shank * cosine)
        found.append(Bent(math.degrees(hip), math.degrees(math.atan2(sine, cosine))))
    return found
