"""The events of both feet: from ground forces where measured, as annotated, else from the motion of the feet."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from haverify.diagnostics.diagnostic import Diagnostic, Severity
from haverify.recordings.feet import tracks
from haverify.recordings.forces import contacts
from haverify.recordings.kinematic import velocity, zeni
from haverify.recordings.recording import Events, Forces, Recording, Track
from haverify.recordings.stride import Stride, grid
from haverify.text.record import record

if TYPE_CHECKING:
    from numpy import ndarray

    Array = ndarray[Any, Any]
    Method = Callable[[Track, Array, float], Events]

Q = Fraction

METHODS = {"zeni": zeni, "velocity": velocity}


@record
class Steps:
    """The events of both legs (`l`, `r`); `marked` and forces agree with the motion, or are not used."""

    of: Mapping[str, Events]
    found: tuple[Diagnostic, ...] = ()


def steps(r: Recording, s: Stride, forces: Forces | None = None, method: str = "zeni") -> Steps:
    """The events of a recording, whose stride is `s`.

    Where the recording closes, it is followed round and round, so that events at its ends are seen.
    """
    moved = moving(r, s, method)
    if forces is not None and _overlap(r, forces) > s.seconds / 2:
        stood = {side: contacts(forces, side) for side in ("l", "r")}
        return _agreeing(stood, moved, s, forces.path)
    if any(e.strikes for e in r.marked.values()):
        return _settled(r.marked, s)
    return Steps(moved)


def moving(r: Recording, s: Stride, method: str) -> dict[str, Events]:
    """The events that a kinematic method finds."""
    import numpy as np

    times = grid(r)
    if r.tracks:
        times, of = np.array(r.clock), dict(r.tracks)
    else:
        of = tracks(r, times)
    if s.kind == "closes":
        return {side: _round(METHODS[method], track, times, s) for side, track in of.items()}
    return {side: METHODS[method](track, times, s.seconds) for side, track in of.items()}


def _round(method: Method, track: Track, times: Array, s: Stride) -> Events:
    """The events of one stride that closes: it is repeated three times, and the middle one counts."""
    import numpy as np

    n = len(times) - 1
    long = np.concatenate([times[:-1] + k * s.seconds for k in range(3)])
    thrice = Track(*(tuple(c[:n]) * 3 for c in (track.heel_x, track.toe_x, track.heel_y, track.toe_y)))
    seen = method(thrice, long, s.seconds)
    shift = Q(round(s.seconds * 10_000), 10_000)
    low, high = Q(float(times[0])) + shift, Q(float(times[0])) + 2 * shift
    strikes, offs = (tuple(t - shift for t in ts if low <= t < high) for ts in (seen.strikes, seen.offs))
    return Events(strikes, offs, seen.method)


def _overlap(r: Recording, forces: Forces) -> float:
    return float(min(r.times[-1], forces.times[-1]) - max(r.times[0], forces.times[0]))


def _agreeing(stood: dict[str, Events], moved: dict[str, Events], s: Stride, path: str) -> Steps:
    """Events from plates, unless they contradict the motion by a quarter of a stride or more."""
    straight, crossed = (_apart(stood, moved, sides) for sides in ("lr", "rl"))
    if straight is None or straight < s.seconds / 8:
        return Steps(stood)
    if crossed is not None and crossed < s.seconds / 8:
        message = f"the right foot strikes when {path} says the left one does: legs are swapped in one of the files"
        return Steps(moved, (Diagnostic("HA225", message, severity=Severity.ERROR),))
    message = f"{path} and the motion of the feet differ by {straight:.2f} s: forces of another walk? they are not used"
    return Steps(moved, (Diagnostic("HA226", message, severity=Severity.WARNING),))


def _apart(stood: dict[str, Events], moved: dict[str, Events], sides: str) -> float | None:
    """The mean distance of strikes in the motion from the nearest ones under the plates, where both are there."""
    gaps = []
    for a, b in zip("lr", sides, strict=True):
        there = stood[b].strikes
        inside = [t for t in moved[a].strikes if there and there[0] - Q(1, 4) <= t <= there[-1] + Q(1, 4)]
        gaps += [min(abs(float(t - q)) for q in there) for t in inside]
    return sum(gaps) / len(gaps) if gaps else None


def _settled(marked: Mapping[str, Events], s: Stride) -> Steps:
    """Annotated events; of two closer than a third of a stride, which no foot can do, the one that fits the stride."""
    found, kept = [], {}
    for side, events in marked.items():
        strikes, a = _single(events.strikes, s.seconds)
        offs, b = _single(events.offs, s.seconds)
        kept[side] = Events(strikes, offs, events.method)
        if a + b:
            name = "left" if side == "l" else "right"
            message = f"{a + b} annotated events of the {name} foot come too soon; those that fit the stride stay"
            found.append(Diagnostic("HA226", message, severity=Severity.WARNING))
    return Steps(kept, tuple(found))


def _single(times: tuple[Q, ...], period: float) -> tuple[tuple[Q, ...], int]:
    """One instant of each group of close ones, and how many are left out."""
    groups: list[list[Q]] = []
    for t in times:
        if groups and t - groups[-1][-1] < Q(period) / 3:
            groups[-1].append(t)
        else:
            groups.append([t])
    best = tuple(
        min(g, key=lambda t: _misfit(t, groups[max(k - 1, 0) : k] + groups[k + 1 : k + 2], period))
        for k, g in enumerate(groups)
    )
    return best, len(times) - len(groups)


def _misfit(t: Q, beside: list[list[Q]], period: float) -> float:
    """How far the gaps to the neighbours are from whole strides."""
    shares = [[abs(float(t - other)) / period for other in g] for g in beside]
    return sum(min(abs(x - round(x)) for x in g) for g in shares)
