"""Cycles of a recording from heel strike to heel strike of one leg, and the instants of other events in them."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Mapping
from fractions import Fraction
from functools import cached_property
from itertools import pairwise

from haverify.recordings.events import Steps
from haverify.recordings.recording import JOINTS, Recording
from haverify.recordings.stride import Stride
from haverify.text.record import record, replace

Q = Fraction

OPPOSITE = {"l": "r", "r": "l"}
_TOLERANCE = Q(35, 100)  # of a stride, by which a cycle may be longer or shorter


_CUT = Q(5, 100)  # of a stride: a recording that closes was cut at the heel strike so near to its ends


@record
class Cycle:
    """One cycle: `start` and `length` in seconds, samples as shares of it (`at[i]` in [0, 1)) with their angles.

    `events` are shares: `off` and `strike` of the opposite foot, `own` the toe-off of the foot itself. `origin` names
    the recording.
    """

    origin: str
    start: Q
    length: Q
    at: tuple[Q, ...]
    angles: Mapping[str, tuple[Q | None, ...]]
    events: Mapping[str, Q]

    @cached_property
    def near(self) -> Mapping[str, tuple[tuple[float, ...], tuple[float, ...]]]:
        """For each joint the shares and the angles that are there, in floating point."""
        shares = [float(q) for q in self.at]
        pairs = {
            j: [(s, float(v)) for s, v in zip(shares, vs, strict=True) if v is not None]
            for j, vs in self.angles.items()
        }
        return {j: (tuple(s for s, _ in ps), tuple(v for _, v in ps)) for j, ps in pairs.items()}


def timed(s: Stride, steps: Steps) -> Stride:
    """The stride as long as the events say, where two strikes of a foot under the plates say so."""
    gaps = [b - a for e in steps.of.values() for a, b in pairwise(e.strikes)]
    near = [g for g in gaps if abs(g - Q(s.seconds)) <= _TOLERANCE * Q(s.seconds) / 2]
    is_measured = all("force" in e.method for e in steps.of.values())
    return replace(s, seconds=float(sum(near) / len(near))) if is_measured and near else s


def whole(r: Recording, s: Stride, steps: Steps, leg: str) -> list[tuple[Q, Q]]:
    """Start and length of the cycles of a leg that the recording covers."""
    strikes, near = steps.of[leg].strikes, Q(s.seconds)
    return [
        (a, b - a)
        for a, b in pairwise(strikes)
        if s.kind != "mirrors" and abs(b - a - near) <= _TOLERANCE * near and r.times[0] <= a and b <= r.times[-1]
    ]


def cycles(r: Recording, s: Stride, steps: Steps, leg: str) -> list[Cycle]:
    """The whole cycles of a leg; of a recording without one, all samples as one cycle of the stride's length.

    Such a cycle begins at the heel strike that is there, or at the first sample where none is.
    """
    found = [_cycle(r, steps, leg, start, length) for start, length in whole(r, s, steps, leg)]
    return found or [_folded(r, s, steps, leg)]


def _cycle(r: Recording, steps: Steps, leg: str, start: Q, length: Q) -> Cycle:
    first, last = bisect_left(r.times, start), bisect_left(r.times, start + length)
    at = tuple((t - start) / length for t in r.times[first:last])
    angles = {j: r.angles[j][first:last] for j in JOINTS}
    return Cycle(r.name, start, length, at, angles, _events(steps, leg, start, length, False))


def _folded(r: Recording, s: Stride, steps: Steps, leg: str) -> Cycle:
    """All samples of a recording, each at its share of the stride, in order; with its mirror image where it mirrors."""
    length = Q(round(s.seconds * 10_000), 10_000)
    strikes = steps.of[leg].strikes
    start = next((t for t in strikes if r.times[0] <= t <= r.times[-1]), r.times[0])
    if s.kind == "closes" and min((start - r.times[0]) % length, (r.times[0] - start) % length) <= _CUT * length:
        start = r.times[0]
    if not strikes and s.kind == "mirrors":
        others = steps.of[OPPOSITE[leg]].strikes
        start = others[0] - length / 2 if others else start
    samples = [((t - start) / length % 1, {j: r.angles[j][i] for j in JOINTS}) for i, t in enumerate(r.times)]
    if s.kind == "mirrors":
        samples += [((at + Q(1, 2)) % 1, {j: row[OPPOSITE[j[0]] + j[1]] for j in JOINTS}) for at, row in samples]
    samples.sort(key=lambda sample: sample[0])
    angles = {j: tuple(row[j] for _, row in samples) for j in JOINTS}
    events = _events(steps, leg, start, length, True)
    if s.kind == "mirrors":
        events = _mirrored(steps, leg, start, length)
    return Cycle(r.name, start, length, tuple(at for at, _ in samples), angles, events)


def _events(steps: Steps, leg: str, start: Q, length: Q, is_folded: bool) -> dict[str, Q]:
    """The first event of each kind in the cycle."""
    other, own = steps.of[OPPOSITE[leg]], steps.of[leg]
    found = {}
    for name, times in (("off", other.offs), ("strike", other.strikes), ("own", own.offs)):
        if is_folded and times:
            found[name] = (times[0] - start) / length % 1
        first = bisect_right(times, start)
        if not is_folded and first < len(times) and times[first] < start + length:
            found[name] = (times[first] - start) / length
    return found


def _mirrored(steps: Steps, leg: str, start: Q, length: Q) -> dict[str, Q]:
    """Events of a symmetric walk: what one foot does, the other does half a stride later."""
    own, other = steps.of[leg], steps.of[OPPOSITE[leg]]
    offs = [(t - start) / length % 1 for t in own.offs] + [((t - start) / length + Q(1, 2)) % 1 for t in other.offs]
    found = {"strike": Q(1, 2)}
    if offs:
        found |= {"own": offs[0], "off": (offs[0] + Q(1, 2)) % 1}
    return found
