"""Recordings of phones on the legs: the end of each leg in the plane, to hip and knee by two links.

In a `.csv` such columns are called `left_x`, `left_y`, `right_x`, `right_y`: down and forward from hip to ankle.
Remarks at its head tell the leg: `# thigh 0.43`, `# shank 0.41`, in the unit of the columns, and `# rate 50 Hz` where
there is no time. Columns of ankle angles are read where they are there. Source: V. B. Semwal, "Data Driven
Computational Model for Bipedal Walking and Push Recovery", IIIT Allahabad, 2016, section 6.4. It puts readings of an
accelerometer in for positions; accelerations are refused here, since they tell no place.
"""

from __future__ import annotations

import math
import re
from fractions import Fraction

from haverify.diagnostics.diagnostic import Diagnostic, Severity
from haverify.recordings.columns import Columns, columns_of, numbers
from haverify.recordings.labels import joint_of
from haverify.recordings.recording import JOINTS, Angles, Recording
from haverify.recordings.two_link import OutOfReach, forward, inverse
from haverify.text.source import Source

Q = Fraction

_ENDS = ("left_x", "left_y", "right_x", "right_y")
_SPEEDING = re.compile(r"(^|[^a-z])(a[xyz]|acc\w*|g_?f[xyz]?|gf[xyz])([^a-z]|$)", re.IGNORECASE)
_MILLION = 1_000_000
_FEW = 0.05  # of the samples of a leg: more that are out of reach mean another length or unit


def has_ends(labels: str) -> bool:
    """Whether a line of labels is one of positions, or of accelerations, of legs."""
    names = [x.strip().lower() for x in re.split("[,;\t]", labels)]
    return "left_x" in names or (any(_SPEEDING.search(x) for x in names) and not any(map(joint_of, names)))


def phoned(source: Source, start: int, separator: str) -> tuple[Recording | None, list[Diagnostic]]:
    """The recording in a file of ends of legs, whose labels begin at `start`; knees bend backward as people's do."""
    columns, found = columns_of(source, start, separator)
    if columns is None or found:
        return None, found
    head, at = source.text[:start], {x.lower(): i for i, x in enumerate(columns.labels)}
    lengths = [_remark(head, "thigh"), _remark(head, "shank")]
    times, found = _times(columns, at, _remark(head, "rate"))
    found += _lacking(columns, at, lengths)
    if found:
        return None, found
    angles: dict[str, Angles] = {}
    for side, name in (("l", "left"), ("r", "right")):
        bent, more = _leg(columns, at[f"{name}_x"], at[f"{name}_y"], float(lengths[0] or 1), float(lengths[1] or 1))
        found += more
        angles |= {side + "h": bent[0], side + "k": bent[1]}
        angles[side + "a"], more = _ankle(columns, side, len(times))
        found += more
    if any(d.severity is Severity.ERROR or d.code == "HA210" for d in found):
        return None, found
    facts = (f"hips and knees by two links of {lengths[0]} and {lengths[1]}",)
    whole = {j: angles[j] for j in JOINTS}
    made = Recording(source.path, source.sha256, tuple(times), whole, rounding=Q(1, _MILLION), facts=facts)
    return made, found


def _remark(head: str, name: str) -> Q | None:
    m = re.search(rf"^#\s*{name}\s+(\d+(?:\.\d+)?)", head, re.MULTILINE | re.IGNORECASE)
    return Q(m[1]) if m and Q(m[1]) else None


def _lacking(columns: Columns, at: dict[str, int], lengths: list[Q | None]) -> list[Diagnostic]:
    line = columns.spans[0].to(columns.spans[-1])
    if any(name not in at for name in _ENDS):
        speeds = [i for i, x in enumerate(columns.labels) if _SPEEDING.search(x)]
        if speeds:
            message = f"column {columns.labels[speeds[0]]} holds accelerations, which tell no place of a leg"
            advice = "record positions left_x, left_y, right_x, right_y from hip to ankle, or joint angles"
            return [Diagnostic("HA224", message, columns.spans[speeds[0]], help=advice)]
        return [Diagnostic("HA224", f"no column {' or '.join(n for n in _ENDS if n not in at)}", line)]
    if None in lengths:
        advice = "write `# thigh 0.43` and `# shank 0.41` at the head, in the unit of the columns"
        return [Diagnostic("HA224", "nothing tells how long thigh and shank are", line, help=advice)]
    return []


def _times(columns: Columns, at: dict[str, int], rate: Q | None) -> tuple[list[Q], list[Diagnostic]]:
    column = next((at[n] for n in ("time", "time_s", "t") if n in at), None)
    if column is None:
        found = [Diagnostic("HA224", "no column `time`, and no remark `# rate 50 Hz`", columns.spans[0])]
        return [Q(k) / rate for k in range(len(columns.rows))] if rate else [], [] if rate else found
    values, found = numbers(columns, column)
    for i, t in enumerate(values):
        before = values[i - 1] if i else None
        if not found and (t is None or (before is not None and t <= before)):
            found.append(Diagnostic("HA210", "time is missing or does not increase", columns.span(i, column)))
    return [t for t in values if t is not None], found


def _leg(
    columns: Columns, x: int, y: int, thigh: float, shank: float
) -> tuple[tuple[Angles, Angles], list[Diagnostic]]:
    """Hip and knee of one leg; samples out of reach are missing, and an error where they are many."""
    xs, found = numbers(columns, x)
    ys, more = numbers(columns, y)
    hips, knees, gone = list[Q | None](), list[Q | None](), list[tuple[int, OutOfReach]]()
    for i, (a, b) in enumerate(zip(xs, ys, strict=True)):
        ways = None if a is None or b is None else inverse((float(a), float(b)), thigh, shank)
        if isinstance(ways, OutOfReach):
            gone.append((i, ways))
        if ways is None or isinstance(ways, OutOfReach):
            hips.append(None)
            knees.append(None)
            continue
        assert math.dist(forward(ways[1], thigh, shank), (float(a or 0), float(b or 0))) < 1e-6 * (thigh + shank)
        hips.append(Q(round(ways[1].hip * _MILLION), _MILLION))
        knees.append(Q(round(ways[1].knee * _MILLION), _MILLION))
    found += more
    if gone:
        i, first = gone[0]
        message = f"{len(gone)} of {len(xs)} ends of the leg are out of reach, the first {first}"
        severity = Severity.ERROR if len(gone) > _FEW * len(xs) else Severity.WARNING
        found.append(Diagnostic("HA222", message, columns.span(i, x), severity=severity))
    return (tuple(hips), tuple(knees)), found


def _ankle(columns: Columns, side: str, count: int) -> tuple[Angles, list[Diagnostic]]:
    """The recorded ankle in degrees; a foot at a right angle, and a warning, where none was."""
    column = next((i for i, x in enumerate(columns.labels) if joint_of(x) == side + "a"), None)
    if column is not None:
        values, found = numbers(columns, column)
        return tuple(values), found
    message = f"no ankle of the {'left' if side == 'l' else 'right'} leg was recorded: 0 deg stands for it"
    return (Q(0),) * count, [Diagnostic("HA222", message, columns.spans[0])]
