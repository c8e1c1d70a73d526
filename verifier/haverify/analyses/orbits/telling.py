"""A periodic orbit that is proved, in words and in a certificate."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import ceil, floor, log10
from typing import Any

from haverify.analyses.orbits.linear import Disc
from haverify.analyses.orbits.newton import Fixed
from haverify.analyses.orbits.orbit import Passed, Plane
from haverify.maths.digits import rational_text
from haverify.maths.interval import Interval

Q = Fraction


def told(plane: Plane, fixed: Fixed, passed: Passed, multipliers: Sequence[Disc]) -> str:
    """Period, a state with P and the multipliers, each with how far it is off at most."""
    variables = plane.model.automaton.vars
    second = "" if plane.model.spec.unitless else " s"
    state = ", ".join(f"{v.name} = {_number(passed.state[v.name])}{_unit(v.unit)}" for v in variables)
    shown = ", ".join(_multiplier(d) for d in multipliers)
    jumps = len(fixed.lap.landings)
    count = f" with {jumps} jump{'' if jumps == 1 else 's'}" if jumps else ""
    return f"period {_number(fixed.lap.time)}{second}{count}, multipliers {shown}, passing {state}"


def _unit(unit: object) -> str:
    text = str(unit) if unit is not None else ""
    return f" {text}" if text and text != "1" else ""


def _number(x: Interval) -> str:
    """The middle and how far it is off at most."""
    low, high = x.exactly()
    return _about((low + high) / 2, (high - low) / 2)


def _about(middle: Q, radius: Q) -> str:
    """A number rounded where it is not known better, and how far it is off, rounding included."""
    if radius == 0 and middle.denominator <= 10**6:
        return rational_text(middle)
    places = max(1, 1 - floor(log10(radius))) if 0 < radius < 1 else 18
    rounded = Q(round(middle * 10**places), 10**places)
    off = radius + abs(middle - rounded)
    power = floor(log10(off)) if off else -places
    digits = ceil(off / Q(10) ** power)
    sign = "-" if rounded < 0 else ""
    whole, part = divmod(abs(rounded).numerator * 10**places // abs(rounded).denominator, 10**places)
    return f"{sign}{whole}.{part:0{places}d} (+-{digits}e{power})"


def _multiplier(d: Disc) -> str:
    if abs(d.imaginary) <= d.radius:
        return _about(d.real, d.radius)
    sign = "+" if d.imaginary > 0 else "-"
    return f"{_about(d.real, d.radius)} {sign} {_about(abs(d.imaginary), d.radius)} i"


def entry_of(plane: Plane, fixed: Fixed) -> dict[str, Any]:
    """The orbit as an entry of a certificate: the section, the box with one fixed point, the period."""
    return {
        "kind": "cycle",
        "mode": plane.mode,
        "section": [plane.variable, rational_text(Q(plane.value))],
        "box": {v: [rational_text(q) for q in x.exactly()] for v, x in fixed.box.items()},
        "period": [rational_text(q) for q in fixed.lap.time.exactly()],
    }
