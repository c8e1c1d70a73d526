"""Markers to joint angles in the sagittal plane, and the tracks of heels and toes.

The plane is spanned by the vertical and the walking direction, the horizontal direction in which the feet point on
average. The thigh's angle is from the vertical (no pelvis is needed), the knee's from the thigh, the ankle's the angle
of shank and sole less a right angle, less its median: feet have no common neutral position among marker sets.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from haverify.diagnostics.diagnostic import Diagnostic, Severity
from haverify.recordings.recording import JOINTS, Events, Recording, Track
from haverify.text.record import record
from haverify.text.span import Span

if TYPE_CHECKING:
    from numpy import ndarray

    Array = ndarray[Any, Any]

POINTS = ("hip", "knee", "ankle", "heel", "toe")

_MILLION = 1_000_000


@record
class Markers:
    """Points of both legs: `points["lknee"]` has shape (n, 3), metres, NaN where missing; `up` is the vertical axis.

    `lines` are the places of the frames, where they have any.
    """

    path: str
    sha256: str
    times: tuple[Fraction, ...]
    points: Mapping[str, Array]
    up: int
    span: Span
    marked: Mapping[str, Events]
    lines: tuple[Span, ...] = ()


def angles_of(markers: Markers) -> tuple[Recording | None, list[Diagnostic]]:
    """The recording of joint angles; frames in which a point of the legs is missing are left out."""
    import numpy as np

    found: list[Diagnostic] = []
    forward = _forward(markers)
    if forward is None:
        return None, [Diagnostic("HA224", "no frame shows both feet", markers.span)]
    found += _sides(markers, forward) + _walks_backward(markers, forward)
    plane = {k: np.stack([v @ forward, v[:, markers.up]], axis=1) for k, v in markers.points.items()}
    values = _angles(plane)
    whole = np.all(np.isfinite(np.stack([values[j] for j in JOINTS])), axis=0)
    if not whole.any():
        return None, [*found, Diagnostic("HA224", "no frame shows all points of both legs", markers.span)]
    kept = _longest(whole)
    if len(kept) < len(whole):
        first, last = (float(markers.times[k]) for k in (kept[0], kept[-1]))
        message = (
            f"{len(kept)} of {len(whole)} frames ({first:.3f} .. {last:.3f} s) show all points; others are left out"
        )
        found.append(Diagnostic("HA222", message, markers.span))
    if any(d.severity is Severity.ERROR for d in found):
        return None, found
    return _recording(markers, plane, values, kept), found


def _recording(markers: Markers, plane: Mapping[str, Array], values: Mapping[str, Array], kept: list[int]) -> Recording:
    angles = {j: tuple(Fraction(round(float(values[j][k]) * _MILLION), _MILLION) for k in kept) for j in JOINTS}
    facts = ("angles from markers in the sagittal plane: the thigh's from the vertical, the ankle's from its median",)
    times = tuple(markers.times[k] for k in kept)
    tracks = {s: _track(plane, s, kept) for s in ("l", "r")}
    return Recording(
        markers.path,
        markers.sha256,
        times,
        angles,
        rounding=Fraction(1, _MILLION),
        tracks=tracks,
        marked=markers.marked,
        facts=facts,
        where=lambda _, i: markers.lines[kept[i]] if markers.lines else markers.span,
    )


def _longest(whole: Array) -> list[int]:
    """The longest stretch of whole frames; gaps of up to three frames do not end it."""
    best: list[int] = []
    run: list[int] = []
    for k in [int(k) for k in whole.nonzero()[0]]:
        run = [*run, k] if run and k - run[-1] <= 4 else [k]
        best = max(best, run, key=len) if len(run) >= len(best) else best
    return best


def _forward(markers: Markers) -> Array | None:
    """The unit vector of the floor in which the feet point, heel to toe, on average over both."""
    import numpy as np

    feet = [markers.points[f"{s}toe"] - markers.points[f"{s}heel"] for s in ("l", "r")]
    mean = sum(np.nanmean(f, axis=0) for f in feet if np.isfinite(f).any())
    if isinstance(mean, int):
        return None
    mean = np.array(mean)
    mean[markers.up] = 0.0
    length = float(np.linalg.norm(mean))
    return mean / length if length > 0 else None


def _sides(markers: Markers, forward: Array) -> list[Diagnostic]:
    """A warning where the left hip lies to the right of the right one."""
    import numpy as np

    up = np.eye(3)[markers.up]
    left = np.cross(up, forward)
    apart = float(np.nanmean((markers.points["lhip"] - markers.points["rhip"]) @ left))
    if not apart < 0:
        return []
    message = f"the left hip is {-apart:.3f} m to the right of the right one"
    notes = ("either left and right are swapped in the names of the markers, or the sideways axis is mirrored",)
    return [Diagnostic("HA225", message, markers.span, notes=notes)]


def _walks_backward(markers: Markers, forward: Array) -> list[Diagnostic]:
    """A warning where the hips move against the direction of the feet."""
    import numpy as np

    hips = (markers.points["lhip"] + markers.points["rhip"]) @ forward / 2
    there = hips[np.isfinite(hips)]
    if len(there) < 2 or there[-1] - there[0] > -0.3:
        return []
    message = f"the walk goes backward: the hips move {there[0] - there[-1]:.2f} m against the direction of the feet"
    return [Diagnostic("HA223", message, markers.span)]


def _angles(plane: Mapping[str, Array]) -> dict[str, Array]:
    """Degrees of the six joints, each (n,), NaN where a point is missing."""
    import numpy as np

    found = {}
    for s in ("l", "r"):
        hip, knee, ankle, heel, toe = (plane[s + p] for p in POINTS)
        thigh, shank, foot = (np.degrees(a) for a in (_lean(knee - hip), _lean(ankle - knee), _lean(toe - heel)))
        found[s + "h"] = _wrapped(thigh)
        found[s + "k"] = _wrapped(shank - thigh)
        bent = _wrapped(foot - shank - 90.0)
        found[s + "a"] = bent - np.nanmedian(bent) if np.isfinite(bent).any() else bent
    return found


def _lean(d: Array) -> Array:
    """The angle of a vector from straight down, forward positive."""
    import numpy as np

    return np.arctan2(d[:, 0], -d[:, 1])


def _wrapped(a: Array) -> Array:
    return (a + 180.0) % 360.0 - 180.0


def _track(plane: Mapping[str, Array], side: str, kept: list[int]) -> Track:
    """Heel and toe relative to the midpoint of the hips along the walk, and above the floor."""
    middle = (plane["lhip"][:, 0] + plane["rhip"][:, 0]) / 2
    heel, toe = plane[side + "heel"], plane[side + "toe"]
    columns = (heel[:, 0] - middle, toe[:, 0] - middle, heel[:, 1], toe[:, 1])
    return Track(*(tuple(float(c[k]) for k in kept) for c in columns))
