"""Marker names to the points of the legs that angles need."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from numpy import ndarray

    Array = ndarray[Any, Any]

# For each point the names that stand for it, the better one first; several in a tuple: their midpoint. `S` is the side.
NAMES: Mapping[str, Sequence[tuple[str, ...]]] = {
    "hip": (
        ("SHJC",),
        ("S.GTR",),
        ("SGTR",),
        ("SHIP",),
        ("S_hip",),
        ("SASI", "SPSI"),
        ("S.ASIS", "S.PSIS"),
        ("SASIS", "SPSIS"),
    ),
    "knee": (
        ("SKJC",),
        ("S.Knee", "S.Knee.Medial"),
        ("S.Knee",),
        ("SKNE", "SKNM"),
        ("SKNE",),
        ("SLFC", "SMFC"),
        ("SKnee",),
        ("S_knee",),
    ),
    "ankle": (
        ("SAJC",),
        ("S.Ankle", "S.Ankle.Medial"),
        ("S.Ankle",),
        ("SANK", "SANM"),
        ("SANK",),
        ("SLMAL", "SMMAL"),
        ("SAnkle",),
        ("S_ankle",),
    ),
    "heel": (("SCAL",), ("S.Heel",), ("SHEE",), ("SHeel",), ("S_heel",)),
    "toe": (("SMT2",), ("S.MT2",), ("STOE",), ("S.MT1", "S.MT5"), ("SMT1", "SMT5"), ("SMT5",), ("SToe",), ("S_toe",)),
}
_WORDS = {"l": ("L", "left"), "r": ("R", "right")}


def points_of(markers: Mapping[str, Array]) -> tuple[dict[str, Array], list[str]]:
    """The points `lhip` ... `rtoe` from named markers, and those for which no marker is there."""
    lowered = {k.lower().split(":")[-1]: v for k, v in markers.items()}
    found: dict[str, Array] = {}
    missing = []
    for side, words in _WORDS.items():
        for point, choices in NAMES.items():
            named = ([n.replace("S", w, 1).lower() for n in c] for c in choices for w in words)
            best = next((names for names in named if all(n in lowered for n in names)), None)
            if best is None:
                missing.append(f"{words[1]} {point}")
            else:
                found[side + point] = (
                    sum(lowered[n] for n in best[1:]) / len(best) + lowered[best[0]] / len(best)
                    if len(best) > 1
                    else lowered[best[0]]
                )
    return found, missing
