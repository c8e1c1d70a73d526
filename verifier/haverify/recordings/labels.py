"""Which column holds which joint: the names that programs and laboratories give to sagittal angles."""

from __future__ import annotations

import re
from collections.abc import Sequence

from haverify.recordings.recording import JOINTS

_SIDES = {"l": "l", "left": "l", "r": "r", "right": "r"}
_JOINTS = {"hip": "h", "knee": "k", "ankle": "a"}
_PLANES = {
    "", "flexion", "flex", "angle", "angles", "flexext", "sagittal", "dorsiflexion", "fe", "value",
    "deg", "degrees", "rad", "radians",
}  # fmt: skip


def joint_of(label: str) -> str | None:
    """The joint (`lh` ... `ra`) whose sagittal angle a label names, None where it names something else.

    State paths count by their coordinate: `/jointset/hip_r/hip_flexion_r/value`. Speeds do not count. The names that
    joints have in specs count, too.

    >>> [joint_of(x) for x in ("hip_flexion_r", "/jointset/knee_l/knee_angle_l/value", "hip_adduction_r", "LAnkle")]
    ['rh', 'lk', None, 'la']
    """
    words = _words(_coordinate(label))
    if words and words[0] in JOINTS and all(w in _PLANES for w in words[1:]):
        return words[0]
    side = [_SIDES[w] for w in words if w in _SIDES]
    joint = [_JOINTS[w] for w in words if w in _JOINTS]
    rest = [w for w in words if w not in _SIDES and w not in _JOINTS]
    if len(side) != 1 or len(joint) != 1 or any(w not in _PLANES for w in rest):
        return None
    return side[0] + joint[0]


def _coordinate(label: str) -> str:
    parts = [p for p in label.split("/") if p]
    if len(parts) < 2:
        return label
    return "" if parts[-1] != "value" else parts[-2]


def _words(label: str) -> list[str]:
    label = re.sub(r"\[.*?\]|\(.*?\)", "", label)
    label = re.sub(r"^([LR])(?=Hip|Knee|Ankle)", r"\1_", label)
    label = re.sub(r"([a-z])([A-Z])", r"\1_\2", label)
    label = re.sub(r"^([lr])(?=hip|knee|ankle)", r"\1_", label.lower())
    return [w for w in re.split(r"[^a-z]+", label) if w]


def joints(labels: Sequence[str]) -> dict[str, int]:
    """The column of each joint that is there; of two for one joint the first."""
    found: dict[str, int] = {}
    for i, label in enumerate(labels):
        joint = joint_of(label)
        if joint is not None:
            found.setdefault(joint, i)
    return found


def loads(labels: Sequence[str]) -> dict[str, int]:
    """The columns of the vertical ground force under the right and the left foot.

    Plates without a side in their name are taken in OpenSim's order: the first is under the right foot.
    """
    found = [i for i, x in enumerate(labels) if re.search(r"force.*_vy$", x, re.IGNORECASE)]
    named = {s: i for i in found for s in ("r", "l") if re.search(rf"(^|_){s}_", labels[i], re.IGNORECASE)}
    return named if len(named) == 2 else dict(zip(("r", "l"), found, strict=False))
