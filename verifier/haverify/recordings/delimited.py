"""`.csv` and tab-separated files: a line of labels with units, rows of numbers; lines that begin with `#` are remarks.

The unit stands in the label (`knee_r_deg`, `knee_r [rad]`, `time [ms]`). A column `percent` in place of a time makes
the cycle one second long.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from fractions import Fraction

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.recordings.angles import Stated, recording
from haverify.recordings.columns import Columns, columns_of
from haverify.recordings.counts import counted, has_counts
from haverify.recordings.labels import joint_of
from haverify.recordings.phone import has_ends, phoned
from haverify.recordings.recording import Recording
from haverify.text.source import Source

_UNIT = re.compile(r"[\[(_ ](deg|degrees|rad|radians)[\])]?$", re.IGNORECASE)
_TIME = re.compile(r"^(time|t)([\[(_ ]+(s|ms|sec|seconds)[\])]?)?$", re.IGNORECASE)
_SCALES = {"ms": Fraction(1, 1000), "percent": Fraction(1, 100)}


def delimited(
    source: Source, angles: str = "", absent: Collection[str] = ()
) -> tuple[Recording | None, list[Diagnostic]]:
    """The recording in a file of separated values; `angles` is the unit the caller states for those without one."""
    start = _after_remarks(source.text)
    labels = source.text[start:].split("\n", 1)[0]
    if has_counts(labels):
        sensed, found = counted(source, start, _separator(labels))
        return sensed.recording if sensed else None, found
    if has_ends(labels):
        return phoned(source, start, _separator(labels))
    columns, found = columns_of(source, start, _separator(labels))
    if columns is None or any(d.code == "HA210" for d in found):
        return None, found
    time, scale = _time(columns)
    if time is None:
        span = columns.spans[0].to(columns.spans[-1])
        return None, [*found, Diagnostic("HA224", "no column `time` (or `percent`)", span)]
    if mixed := _mixed(columns):
        return None, [*found, mixed]
    stated = _stated(columns, angles)
    made, more = recording(columns, time, stated, scale, absent)
    return made, [*found, *more]


def _after_remarks(text: str) -> int:
    at = 0
    while text.startswith(("#", "\n"), at):
        at = text.find("\n", at) + 1 or len(text)
    return at


def _separator(line: str) -> str:
    return max(",;\t", key=line.count)


def _time(columns: Columns) -> tuple[int | None, Fraction]:
    for i, label in enumerate(columns.labels):
        m = _TIME.match(label)
        if m:
            return i, _SCALES.get((m[3] or "s").lower(), Fraction(1))
    for i, label in enumerate(columns.labels):
        if label.lower() in ("percent", "cycle_percent", "%"):
            return i, _SCALES["percent"]
    return None, Fraction(1)


def _mixed(columns: Columns) -> Diagnostic | None:
    """An error where labels state degrees for one joint and radians for another."""
    units = [(m[1].lower()[:3], i) for i, x in enumerate(columns.labels) if joint_of(x) and (m := _UNIT.search(x))]
    other = next((i for unit, i in units if unit != units[0][0]), None)
    if other is None:
        return None
    message = f"{columns.labels[units[0][1]]} and {columns.labels[other]} are in different units"
    return Diagnostic("HA106", message, columns.spans[other], help="write all angles in one unit")


def _stated(columns: Columns, angles: str) -> Stated:
    """The unit in the labels of joints, if it is the same in all of them."""
    found = {}
    for i, label in enumerate(columns.labels):
        m = _UNIT.search(label)
        if joint_of(label) and m:
            found[m[1].lower()[:3]] = (label, columns.spans[i])
    if len(found) == 1:
        unit, (label, span) = next(iter(found.items()))
        return Stated(unit, f"column {label}", span)
    return Stated(angles, f"--angles {angles}" if angles else "", columns.spans[0])
