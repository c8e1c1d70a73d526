"""What the joints of a robot can do, as ordinary claims about a gait: `.ha` text that imports the gait's spec.

Position, speed and acceleration of a joint are those of an output, scaled and shifted; so the claims are about the
gait's automaton itself, hold for every value of its params, and are decided, certified and checked as any others.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from fractions import Fraction

from haverify.maths.exact import decimal_text
from haverify.robot.body import Limits, Robot
from haverify.robot.mapping import Drive, Map
from haverify.text.record import record

Q = Fraction
MADE = "// Made by haverify replay, and written anew each time."


@record
class Pace:
    """A speed factor up to which all speeds and accelerations are within limits, and one that is too fast."""

    proved: Q
    refuted: Q


def claims_text(title: str, spec: str, m: Map, robot: Robot, pace: Pace | None) -> str:
    """The claims about the joints that are driven, each joint with its own; `spec` is the path of the gait's spec."""
    blocks = [f'{MADE}\nspec "{title}" version "1.0"', f'import "{spec}" as gait']
    for d in m.drives:
        limits = robot.hinges[d.joint].limits
        assert limits is not None, "what is driven is a hinge"
        blocks += [_position(d, limits, m), _speed(d, limits, m)]
        if m.acceleration is not None:
            blocks.append(_acceleration(d, m))
    if pace is not None:
        blocks += _paces(m, robot, pace)
    return "\n\n".join(blocks) + "\n"


def names(m: Map) -> Iterator[str]:
    """The names of the claims."""
    for d in m.drives:
        yield from (f"position_{d.joint}", f"speed_{d.joint}")
        if m.acceleration is not None:
            yield f"acceleration_{d.joint}"


def _position(d: Drive, limits: Limits, m: Map) -> str:
    angle = f"{_times(d.factor)}{_sum(d.outputs)}" + (f" + {_number(d.offset)} deg" if d.offset else "")
    doc = f"The posture of {d.joint} is one that the joint can take, over the whole cycle."
    body = f"always {angle_text(limits.lower)} <= {angle} <= {angle_text(limits.upper)}"
    return _property(f"position_{d.joint}", doc, [body], m)


def _speed(d: Drive, limits: Limits, m: Map) -> str:
    doc = f"{d.joint} is never asked to turn faster than it can, within any phase."
    return _property(f"speed_{d.joint}", doc, [_speed_line(d, limits, m.speed)], m)


def _acceleration(d: Drive, m: Map) -> str:
    doc = f"{d.joint} is never asked to accelerate more than allowed, within any phase."
    return _property(f"acceleration_{d.joint}", doc, [_acceleration_line(d, m, m.speed)], m)


def _speed_line(d: Drive, limits: Limits, pace: Q) -> str:
    rate = _sum([f"der({o})" for o in d.outputs])
    return f"always abs({_times(abs(d.factor) * pace)}{rate}) <= {_number(limits.velocity)} rad/s"


def _acceleration_line(d: Drive, m: Map, pace: Q) -> str:
    assert m.acceleration is not None, "asked for where there is a limit"
    rate = _sum([f"der(der({o}))" for o in d.outputs])
    return f"always abs({_times(abs(d.factor) * pace**2)}{rate}) <= {_number(m.acceleration)} rad/s^2"


def _paces(m: Map, robot: Robot, pace: Pace) -> list[str]:
    said = (
        ("fastest", pace.proved, "At this multiple of its pace every speed the gait asks for is within limits."),
        (
            "too_fast",
            pace.refuted,
            "A little faster, one is not: the multiple before is the greatest, to four decimals.",
        ),
    )
    return [_property(name, doc, _pace_lines(m, robot, factor), m) for name, factor, doc in said]


def _pace_lines(m: Map, robot: Robot, factor: Q) -> list[str]:
    lines = []
    for d in m.drives:
        limits = robot.hinges[d.joint].limits
        assert limits is not None, "what is driven is a hinge"
        lines.append(_speed_line(d, limits, factor))
        if m.acceleration is not None:
            lines.append(_acceleration_line(d, m, factor))
    return lines


def _property(name: str, doc: str, lines: list[str], m: Map) -> str:
    expect = "expect proved"
    because = m.expected.get(name)
    if name == "too_fast":
        because = "this is the pace just beyond the greatest"
    if because is not None:
        text = because.replace("\\", "/").replace('"', "'").replace("\n", " ")
        expect = f'expect refuted because "{text}"'
    body = "".join(f"  {line}\n" for line in [*lines, expect])
    return f"/// {doc}\nproperty {name} on gait.{m.automaton} {{\n{body}}}"


def angle_text(radians: Q) -> str:
    """A limit as text: whole degrees where the file has the float nearest to them, else the number in rad.

    >>> angle_text(Fraction("-0.017453292519943295")), angle_text(Fraction(1, 2))
    ('-1 deg', '0.5 rad')
    """
    degrees = round(math.degrees(radians))
    if float(radians) == math.radians(degrees):
        return f"{degrees} deg"
    return f"{_number(radians)} rad"


def _sum(terms: Sequence[str]) -> str:
    return terms[0] if len(terms) == 1 else f"({' + '.join(terms)})"


def _times(factor: Q) -> str:
    return "" if factor == 1 else f"{_number(factor)} * "


def _number(q: Q) -> str:
    text = decimal_text(q)
    return text if text is not None else f"({q.numerator} / {q.denominator})"
