"""Recordings of potentiometers and force sensors in counts: calibrated, corrected to zero, smoothed; raw ones are kept.

A potentiometer turns 300 deg over counts 0 .. 999; a count of the force sensor is 9.8/100 N. Source: V. B. Semwal,
"Data Driven Computational Model for Bipedal Walking and Push Recovery", IIIT Allahabad, 2016, section 4.2 and eq. 4;
its eq. 3 prints 300/100 for the angle, by which a turn of the sensor would be 2997 deg (`printed_degrees`).

In a `.csv` such columns are called `hip_l_counts` ... and `force_counts`. Remarks at its head calibrate: `# counts
999`, `# range 300 deg`, `# rate 50 Hz` where there is no time, `# invert knee_l` for a sensor that turns the other
way.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.recordings.columns import Columns, columns_of, numbers
from haverify.recordings.labels import joint_of
from haverify.recordings.leaps import settled
from haverify.recordings.recording import JOINTS, Angles, Recording, told
from haverify.text.record import record
from haverify.text.source import Source
from haverify.text.span import Span

if TYPE_CHECKING:
    from numpy import ndarray

    Array = ndarray[Any, Any]

Q = Fraction

NEWTONS = Q(98, 1000)  # of a count of force
_MILLION = 1_000_000


@record
class Calibration:
    """Degrees over all counts, how many those are, samples a second (None: a column of times), joints to turn round."""

    counts: Q = Q(999)
    degrees: Q = Q(300)
    rate: Q | None = None
    inverted: frozenset[str] = frozenset()

    def angle(self, joint: str, count: Q, zero: Q) -> Q:
        """Degrees from the posture at which the sensor shows `zero`."""
        turned = (count - zero) * self.degrees / self.counts
        return -turned if joint in self.inverted else turned


def printed_degrees(count: Q, zero: Q) -> Q:
    """The angle by eq. 3 as printed.

    >>> printed_degrees(Q(999), Q(0))
    Fraction(2997, 1)
    """
    return (count - zero) * 300 / 100


@record
class Counted:
    """What sensors recorded: `raw` counts, the recording made of them, and forces in newtons (empty: none)."""

    raw: Mapping[str, tuple[Q, ...]]
    recording: Recording
    newtons: tuple[Q, ...]


def has_counts(labels: str) -> bool:
    """Whether a line of labels is one of counts."""
    return re.search(r"_counts\b", labels, re.IGNORECASE) is not None


def counted(source: Source, start: int, separator: str) -> tuple[Counted | None, list[Diagnostic]]:
    """The recording in a file of counts, whose labels begin at `start`; angles count from the first row, upright."""
    how = _calibration(source.text[:start])
    columns, found = columns_of(source, start, separator)
    if columns is None or found:
        return None, found
    at = {joint_of(re.sub("_counts$", "", x)): i for i, x in enumerate(columns.labels)}
    missing = [j for j in JOINTS if j not in at]
    if missing:
        return None, [Diagnostic("HA224", f"no column for {', '.join(map(told, missing))}", columns.spans[0])]
    raw: dict[str, tuple[Q, ...]] = {}
    for joint in JOINTS:
        raw[joint], more = _within(columns, at[joint], how)
        found += more
    times = _times(columns, how)
    if not times:
        message = "no column `time`, and no remark `# rate 50 Hz`"
        found.append(Diagnostic("HA224", message, Span(source.path, start, start + 1)))
    if found:
        return None, found
    turned = {j: tuple(how.angle(j, c, raw[j][0]) for c in raw[j]) for j in JOINTS}
    rough = Recording(source.path, source.sha256, tuple(times), turned, where=lambda j, i: columns.span(i, at[j]))
    clean, found = settled(rough, "single")  # before smoothing, which would spread a leap
    angles = {j: _smooth(times, clean.angles[j]) for j in JOINTS}
    force = next((i for i, x in enumerate(columns.labels) if x.lower().startswith("force")), None)
    newtons = tuple((v or Q(0)) * NEWTONS for v in numbers(columns, force)[0]) if force is not None else ()
    facts = (f"{how.counts} counts over {how.degrees} deg from the first row, smoothed by a cubic spline",)
    made = Recording(source.path, source.sha256, tuple(times), angles, rounding=Q(1, _MILLION), facts=facts)
    return Counted(raw, made, newtons), found


def _calibration(head: str) -> Calibration:
    def of(pattern: str) -> str | None:
        m = re.search(rf"^#\s*{pattern}", head, re.MULTILINE | re.IGNORECASE)
        return m[1] if m else None

    inverted = re.findall(r"^#\s*invert\s+(\S+)", head, re.MULTILINE | re.IGNORECASE)
    rate = of(r"rate\s+([\d.]+)")
    return Calibration(
        Q(of(r"counts\s+(\d+)") or 999),
        Q(of(r"range\s+([\d.]+)\s*deg") or 300),
        Q(rate) if rate else None,
        frozenset(j for x in inverted if (j := joint_of(x))),
    )


def _within(columns: Columns, column: int, how: Calibration) -> tuple[tuple[Q, ...], list[Diagnostic]]:
    """The counts of a sensor; an error where one is missing or beyond its range."""
    values, found = numbers(columns, column)
    for i, v in enumerate(values):
        if not found and (v is None or not 0 <= v <= how.counts):
            said = columns.rows[i][column] or "nothing"
            message = f"{said} in column {columns.labels[column]}; counts are 0 .. {how.counts}"
            found.append(Diagnostic("HA108" if v is not None else "HA210", message, columns.span(i, column)))
    return tuple(v or Q(0) for v in values), found


def _times(columns: Columns, how: Calibration) -> list[Q]:
    at = next((i for i, x in enumerate(columns.labels) if x.lower() in ("time", "time_s", "t")), None)
    if at is not None:
        return [t for t in numbers(columns, at)[0] if t is not None]
    return [Q(k) / how.rate for k in range(len(columns.rows))] if how.rate else []


def _smooth(times: Sequence[Q], angles: Angles) -> Angles:
    """The cubic smoothing spline through the angles that are there, as smooth as cross-validation finds best."""
    import numpy as np
    from scipy.interpolate import make_smoothing_spline

    x, there = np.array([float(t) for t in times]), [k for k, a in enumerate(angles) if a is not None]
    y = np.array([float(angles[k] or 0) for k in there])
    if len(there) < 5:
        return angles
    steps = (x - x[0]) / np.mean(np.diff(x))  # the search for the smoothness is at home in steps of about 1
    return tuple(Q(round(float(v) * _MILLION), _MILLION) for v in make_smoothing_spline(steps[there], y)(steps))
