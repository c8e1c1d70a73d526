"""Recordings as files that OpenSim, spreadsheets and `haverify fit` read."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction

from haverify.maths.exact import decimal_text
from haverify.recordings.recording import JOINTS

Q = Fraction

COORDINATES = {
    "lh": "hip_flexion_l",
    "rh": "hip_flexion_r",
    "lk": "knee_angle_l",
    "rk": "knee_angle_r",
    "la": "ankle_angle_l",
    "ra": "ankle_angle_r",
}
"""The names of the joints in the model gait2354."""


def motion(name: str, times: Sequence[Q], angles: Mapping[str, Sequence[Q | None]]) -> str:
    """A `.mot` file, which is also a `.sto` file: header of version 1, degrees; a missing angle is `nan`."""
    labels = ["time", *(COORDINATES[j] for j in JOINTS)]
    head = [name, "version=1", f"nRows={len(times)}", f"nColumns={len(labels)}", "inDegrees=yes", "endheader"]
    return "\n".join([*head, "\t".join(labels), *_rows(times, angles, "\t", "nan")]) + "\n"


def separated(times: Sequence[Q], angles: Mapping[str, Sequence[Q | None]]) -> str:
    """A `.csv` file with units in its labels; a missing angle is an empty cell."""
    labels = ["time_s", *(f"{COORDINATES[j]}_deg" for j in JOINTS)]
    return "\n".join([",".join(labels), *_rows(times, angles, ",", "")]) + "\n"


def _rows(times: Sequence[Q], angles: Mapping[str, Sequence[Q | None]], between: str, gap: str) -> Iterable[str]:
    for i, t in enumerate(times):
        yield between.join([_text(t, gap), *(_text(angles[j][i], gap) for j in JOINTS)])


def _text(q: Q | None, gap: str) -> str:
    if q is None:
        return gap
    return decimal_text(q) or decimal_text(Q(round(q * 10**9), 10**9)) or gap
