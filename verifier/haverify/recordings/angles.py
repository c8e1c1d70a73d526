"""Columns of joint angles to a recording: the unit decided, the sign of the knee turned, gaps told."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from fractions import Fraction

from haverify.diagnostics.codes import is_error
from haverify.diagnostics.diagnostic import Diagnostic, Severity
from haverify.recordings.columns import Columns, numbers
from haverify.recordings.labels import joint_of, joints
from haverify.recordings.recording import JOINTS, Angles, Recording, told
from haverify.text.record import record
from haverify.text.span import Span

Q = Fraction

# pi to 40 digits; a converted angle is rounded to a millionth of a degree, far coarser.
_DEGREES_PER_RADIAN = Q(180) / Q(31415926535897932384626433832795028841972, 10**40)
_MILLIONTH = Q(1, 1_000_000)

_SECONDS = Q(1)
_MANY = 15  # samples from which on their distance can be judged
_SLOWEST = Q(3, 20)  # seconds between samples: fewer than seven a second show no walk

_DEGREES = Q(360)
_TURN = Q(7)  # no joint turns by so many radians; as degrees, no walk has so small a range of the knee


@record
class Stated:
    """The unit a file states for its angles (`deg`, `rad` or empty), the words that state it, and their place."""

    unit: str
    why: str
    span: Span | None


def recording(
    columns: Columns, time: int, stated: Stated, scale: Q = _SECONDS, absent: Collection[str] = ()
) -> tuple[Recording | None, list[Diagnostic]]:
    """The recording that columns hold; `scale` is the unit of its times in seconds, `absent` joints may be missing."""
    at = joints(columns.labels)
    missing = [j for j in JOINTS if j not in at and j not in absent]
    if missing or not at:
        return None, [_missing(columns, missing or list(JOINTS))]
    times, found = _times(columns, time, scale)
    found += _twice(columns, at)
    values: dict[str, list[Q | None]] = {}
    for joint in JOINTS:
        values[joint], more = numbers(columns, at[joint]) if joint in at else ([None] * len(columns.rows), [])
        found += more
    if any(is_error(d) for d in found):
        return None, found
    unit, more = _unit(values, stated)
    found += more
    if unit is None:
        return None, found
    angles = {j: _degrees(v, unit) for j, v in values.items()}
    found += _beyond_a_turn(columns, at, angles)
    if any(is_error(d) for d in found):
        return None, found
    angles, more = _knees(columns, at, angles)
    found += more
    kept, more = _whole(columns, at, times, angles)
    found += more
    if not kept:
        return None, found
    whole = {j: tuple(angles[j][i] for i in kept) for j in JOINTS}
    facts = (f"angles in {'degrees' if unit == 'deg' else 'radians'} ({stated.why or 'as its values show'})",)
    source = columns.source
    rounding = Q(0) if unit == "deg" else _MILLIONTH
    return Recording(
        source.path,
        source.sha256,
        tuple(times[i] for i in kept),
        whole,
        rounding=rounding,
        facts=facts,
        where=lambda joint, i: columns.span(kept[i], at[joint]),
    ), found


def _twice(columns: Columns, at: Mapping[str, int]) -> list[Diagnostic]:
    """A warning for each joint that two columns hold."""
    found = []
    for i, label in enumerate(columns.labels):
        joint = joint_of(label)
        if joint is not None and at[joint] != i:
            first = columns.labels[at[joint]]
            message = f"{label} is a second column for the {told(joint)}; the first, {first}, is read"
            found.append(Diagnostic("HA221", message, columns.spans[i]))
    return found


def _missing(columns: Columns, joints: list[str]) -> Diagnostic:
    message = f"no column for {', '.join(told(j) for j in joints)}"
    notes = (f"columns: {', '.join(columns.labels[:30])}",)
    span = columns.spans[0].to(columns.spans[-1])
    return Diagnostic("HA224", message, span, notes=notes, help="names such as hip_flexion_r, knee_angle_l are known")


def _times(columns: Columns, time: int, scale: Q) -> tuple[list[Q], list[Diagnostic]]:
    """The instants; an error where one is missing or not later than the one before."""
    values, found = numbers(columns, time)
    for i, t in enumerate(values):
        before = values[i - 1] if i else None
        if t is None:
            found.append(Diagnostic("HA210", "no time in this row", columns.span(i, time)))
        elif before is not None and t <= before:
            found.append(_back(columns, i, time))
    if not found and len(values) >= _MANY:
        found += _steps(columns, time, [t * scale for t in values if t is not None])
    return [t * scale for t in values if t is not None], found[:5]


def _back(columns: Columns, row: int, time: int) -> Diagnostic:
    """What a time that does not increase is called: percent that begin again are several cycles."""
    now, before, label = columns.rows[row][time], columns.rows[row - 1][time], columns.labels[time]
    if "percent" in label.lower() or label == "%":
        message = f"{label} begins again, {now} after {before}: several cycles in one table"
        return Diagnostic("HA210", message, columns.span(row, time), help="write each cycle to a file of its own")
    return Diagnostic("HA210", f"time does not increase: {now} after {before}", columns.span(row, time))


def _steps(columns: Columns, time: int, times: list[Q]) -> list[Diagnostic]:
    """An error where samples are so far apart that the time is in another unit, milliseconds or percent."""
    mean = (times[-1] - times[0]) / (len(times) - 1)
    if mean <= _SLOWEST:
        return []
    message = f"samples are {float(mean):.4g} s apart on average: is the time in milliseconds, or in percent?"
    advice = "in a .csv call the column `time [ms]` or `percent`"
    return [Diagnostic("HA108", message, columns.spans[time], severity=Severity.ERROR, help=advice)]


def _unit(values: Mapping[str, list[Q | None]], stated: Stated) -> tuple[str | None, list[Diagnostic]]:
    """The unit of the angles: the stated one where the size of the values allows it, else what the values show."""
    knees = [v for j in ("lk", "rk") for v in values[j] if v is not None]
    largest = max((abs(v) for vs in values.values() for v in vs if v is not None), default=Q(0))
    span = max(knees, default=Q(0)) - min(knees, default=Q(0))
    shows = "deg" if largest > _TURN else "rad" if Q(1, 4) < span else ""
    if stated.unit and shows and shows != stated.unit:
        return None, [_implausible(stated, largest, span)]
    if stated.unit:
        return stated.unit, []
    if shows == "deg":
        words = {"deg": "degrees", "rad": "radians"}[shows]
        message = (
            f"the file does not state the unit of its angles; with values up to {float(largest):.4g} they are {words}"
        )
        return shows, [Diagnostic("HA106", message, stated.span, severity=Severity.INFORMATION)]
    message = f"the file does not state the unit of its angles, and values up to {float(largest):.3g} could be both"
    return None, [Diagnostic("HA106", message, stated.span, help="haverify fit --angles rad (or deg)")]


def _implausible(stated: Stated, largest: Q, span: Q) -> Diagnostic:
    if stated.unit == "rad":
        message = f"`{stated.why}` states radians, but values go up to {float(largest):.4g}: more than a turn"
        return Diagnostic("HA108", message, stated.span, severity=Severity.ERROR, help="haverify fit --angles deg")
    message = f"`{stated.why}` states degrees, but the knees move by {float(span):.3g} only, as in radians"
    return Diagnostic("HA108", message, stated.span, severity=Severity.ERROR, help="haverify fit --angles rad")


def _degrees(values: list[Q | None], unit: str) -> Angles:
    if unit == "deg":
        return tuple(values)
    return tuple(None if v is None else Q(round(v * _DEGREES_PER_RADIAN * 1_000_000), 1_000_000) for v in values)


def _beyond_a_turn(columns: Columns, at: Mapping[str, int], angles: Mapping[str, Angles]) -> list[Diagnostic]:
    """An error at the first sample that no joint can reach."""
    for j in at:
        for i, v in enumerate(angles[j]):
            if v is not None and abs(v) > _DEGREES:
                message = f"the {told(j)} is at {float(v):.4g} deg, more than a turn"
                return [Diagnostic("HA108", message, columns.span(i, at[j]), severity=Severity.ERROR)]
    return []


def _knees(
    columns: Columns, at: Mapping[str, int], angles: Mapping[str, Angles]
) -> tuple[dict[str, Angles], list[Diagnostic]]:
    """The angles with knee flexion negative: a knee bends further one way than it can the other.

    The outermost samples, a fiftieth at each end, are not asked: a few wrong ones shall not turn the others.
    """
    turned: dict[str, Angles] = dict(angles)
    spans = []
    for joint in ("lk", "rk"):
        there = sorted(v for v in angles[joint] if v is not None)
        few = len(there) // 50
        if there and there[-1 - few] > -there[few]:
            turned[joint] = tuple(None if v is None else -v for v in angles[joint])
            spans.append(columns.spans[at[joint]])
    if not spans:
        return turned, []
    which = "the knee" if len(spans) == 2 else "one knee"
    message = f"flexion of {which} is positive here; it is turned: flexion negative, as in gait2354"
    return turned, [Diagnostic("HA223", message, spans[0])]


def _whole(
    columns: Columns, at: Mapping[str, int], times: list[Q], angles: Mapping[str, Angles]
) -> tuple[list[int], list[Diagnostic]]:
    """The rows in which some joint is there; rows in which all six are exactly 0 are missing ones."""
    empty = [i for i in range(len(times)) if all(not angles[j][i] for j in JOINTS)]
    gone = {j: sum(1 for i in range(len(times)) if angles[j][i] is None) for j in at}
    kept = [i for i in range(len(times)) if i not in set(empty)]
    found = []
    if empty:
        zeros = "zeros" if angles[next(iter(at))][empty[0]] is not None else "gaps"
        message = f"{len(empty)} rows hold {zeros} in all six joints: they are left out"
        found.append(Diagnostic("HA222", message, columns.span(empty[0], next(iter(at.values())))))
    elif any(gone.values()):
        worst = max(gone, key=lambda j: gone[j])
        first = next(i for i in range(len(times)) if angles[worst][i] is None)
        message = f"{sum(gone.values())} angles are missing, most of the {told(worst)}; they are left out"
        found.append(Diagnostic("HA222", message, columns.span(first, at[worst])))
    if not kept:
        found.append(Diagnostic("HA224", "no row holds angles", columns.spans[0]))
    return kept, found
