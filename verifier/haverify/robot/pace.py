"""The greatest multiple of a gait's pace at which every speed and acceleration it asks for is within limits.

A speed grows as the pace and an acceleration as its square, so each limit allows the pace up to a number that follows
exactly from the extremes of polynomials. The least of them is rounded down to four decimals; that it is allowed and
that one more is not are claims (`claims.py`), decided like all others: this module only proposes.
"""

from __future__ import annotations

from fractions import Fraction
from math import isqrt

from haverify.analyses.clock_model import PI
from haverify.analyses.poly_range import Ranges
from haverify.robot.body import Robot
from haverify.robot.claims import Pace
from haverify.robot.cycle import Cycle
from haverify.robot.mapping import Drive, Map
from haverify.robot.slack import extremes

Q = Fraction
STEP = Q(1, 10_000)


def greatest_pace(cycle: Cycle, m: Map, robot: Robot) -> Pace | None:
    """The pace to try to prove, and the one to refute; None where nothing moves or params change more than the pace."""
    if not cycle.pace_only:
        return None
    found, seen = [], Ranges()
    for d in m.drives:
        limits = robot.hinges[d.joint].limits
        assert limits is not None, "what is driven is a hinge"
        scale = abs(d.factor) * (PI[1] / 180 if d.unit == "deg" else 1)  # to rad; above, so that the pace is below
        speed = scale * _greatest(cycle, d, 1, seen) * cycle.fastest
        if speed:
            found.append(limits.velocity / speed)
        if m.acceleration is not None and (most := scale * _greatest(cycle, d, 2, seen) * cycle.fastest**2):
            found.append(_root(m.acceleration / most))
    if not found:
        return None
    pace = min(found) // STEP * STEP
    return Pace(pace, pace + STEP) if pace > 0 else None


def _root(q: Q) -> Q:
    """The square root rounded down, to far more digits than are used."""
    scale = 10**12
    return Q(isqrt(q.numerator * scale**2 // q.denominator), scale)


def _greatest(cycle: Cycle, d: Drive, order: int, seen: Ranges) -> Q:
    """The greatest magnitude of a derivative of what drives a joint, at the pace followed."""
    return max(abs(end) for _, _, ends, _ in extremes(cycle, d, order, seen) for end in ends)
