"""How much a gait leaves of what its joints can do, and where: from the extremes of polynomials, rounded down.

The claims about the joints (`claims.py`) decide whether it is negative; the numbers here are told beside them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction

from haverify.analyses.clock_model import PI
from haverify.analyses.poly_range import Ranges
from haverify.maths.polynomial import Polynomial, constant, total, variable
from haverify.robot.body import Limits, Robot
from haverify.robot.claims import Pace
from haverify.robot.cycle import Cycle
from haverify.robot.mapping import Drive, Map
from haverify.robot.trajectory import summed
from haverify.text.record import record

Q = Fraction
Ends = tuple[Q, Q]


@record
class Slack:
    """The least margin of a claim over cycle and paces, in `unit`; the mode, and the instant (s, of the replay)."""

    margin: Q
    unit: str
    mode: str
    time: Q


def slacks(cycle: Cycle, m: Map, robot: Robot, pace: Pace | None) -> dict[str, Slack]:
    """By the names of the claims; nothing where params shape the outputs."""
    found: dict[str, Slack] = {}
    if cycle.box:
        return found
    seen, limit = Ranges(), {d.joint: robot.hinges[d.joint].limits for d in m.drives}
    for d in m.drives:
        limits = limit[d.joint]
        assert limits is not None, "what is driven is a hinge"
        found[f"position_{d.joint}"] = _position(cycle, m, d, limits, seen)
        found[f"speed_{d.joint}"] = _rate(cycle, m, d, 1, limits.velocity, m.speed, seen)
        if m.acceleration is not None:
            found[f"acceleration_{d.joint}"] = _rate(cycle, m, d, 2, m.acceleration, m.speed, seen)
    for name, factor in () if pace is None else (("fastest", pace.proved), ("too_fast", pace.refuted)):
        found[name] = min(_paced(cycle, m, limit, factor, seen), key=lambda s: s.margin)
    return found


def _paced(cycle: Cycle, m: Map, limit: dict[str, Limits | None], pace: Q, seen: Ranges) -> Iterator[Slack]:
    for d in m.drives:
        limits = limit[d.joint]
        assert limits is not None, "what is driven is a hinge"
        yield _rate(cycle, m, d, 1, limits.velocity, pace, seen)
        if m.acceleration is not None:
            yield _rate(cycle, m, d, 2, m.acceleration, pace, seen)


def _position(cycle: Cycle, m: Map, d: Drive, limits: Limits, seen: Ranges) -> Slack:
    low, high = (_in_degrees(x) for x in (limits.lower, limits.upper))
    best: list[Slack] = []
    for mode, start, ends, at in extremes(cycle, d, 0, seen):
        angle = sorted(x * d.factor * (1 if d.unit == "deg" else k) for x in ends for k in _PER_RADIAN)
        least, most = angle[0] + d.offset, angle[-1] + d.offset
        best.append(Slack(min(least - low[1], high[0] - most), "deg", mode, (start + at) / m.speed))
    return min(best, key=lambda s: s.margin)


_PER_RADIAN = (180 / PI[1], 180 / PI[0])


def _in_degrees(radians: Q) -> Ends:
    """A limit in deg: exactly what was meant where the file has the float nearest to whole degrees."""
    degrees = round(math.degrees(radians))
    if float(radians) == math.radians(degrees):
        return Q(degrees), Q(degrees)
    found = sorted(radians * k for k in _PER_RADIAN)
    return found[0], found[1]


def _rate(cycle: Cycle, m: Map, d: Drive, order: int, limit: Q, pace: Q, seen: Ranges) -> Slack:
    scale = abs(d.factor) * (pace * cycle.fastest) ** order * (PI[1] / 180 if d.unit == "deg" else 1)
    unit = "rad/s" if order == 1 else "rad/s^2"
    best = [
        Slack(limit - scale * max(map(abs, ends)), unit, mode, (start + at) / m.speed)
        for mode, start, ends, at in extremes(cycle, d, order, seen)
    ]
    return min(best, key=lambda s: s.margin)


def extremes(cycle: Cycle, d: Drive, order: int, seen: Ranges) -> Iterator[tuple[str, Q, Ends, Q]]:
    """Mode, its start, enclosed extreme, instant since then: of what drives a joint, or of a derivative of it."""
    for piece in cycle.pieces:
        p: Polynomial = total(constant(c) * variable("t") ** k for k, c in enumerate(summed(piece, d.outputs)))
        for _ in range(order):
            p = p.derivative("t")
        value = p.constant
        if value is not None:
            yield piece.mode, piece.start, (value, value), Q(0)
        else:
            for end in seen.extremes(p, {"t": (Q(0), piece.length)}):
                yield piece.mode, piece.start, (end.low, end.high), end.at
