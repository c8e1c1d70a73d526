"""Hips and knees three times: as the automaton has them, as they were recorded, as the robot can follow them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from haverify.robot.body import Robot
from haverify.robot.cycle import Cycle, Piece
from haverify.robot.mapping import Drive, Map
from haverify.text.record import record

Points = list[tuple[float, float]]


@record
class Compared:
    """An output over the recording's instants (s from the cycle's start): three curves in deg, and rms differences.

    `robot` is the commanded angle, stopped at the joint's limits, in the gait's own sign: what the joint can reach.
    """

    output: str
    joint: str
    automaton: Points
    recording: Points
    robot: Points
    limits: tuple[float, float]  # of the output, where the robot's joint stops
    fit_rms: float  # automaton against recording
    robot_rms: float  # robot against automaton
    whole_rms: float  # robot against recording
    modes: list[str]  # at each instant


def compared(
    cycle: Cycle, m: Map, robot: Robot, times: Sequence[float], angles: Mapping[str, Sequence[float]]
) -> list[Compared]:
    """Every hip and knee, that is every joint which one output alone drives and which was recorded."""
    found: list[Compared] = []
    instants = [t - times[0] for t in times if t - times[0] <= float(cycle.length)]
    modes = [_piece(cycle, t).mode for t in instants]
    for d in m.drives:
        if len(d.outputs) == 1 and d.outputs[0] in angles and not d.outputs[0].endswith("a"):
            values = [_value(cycle, d.outputs[0], t) for t in instants]
            reached = [_reached(d, robot, v) for v in values]
            seen = list(angles[d.outputs[0]])[: len(instants)]
            one, two, three = (list(zip(instants, c, strict=True)) for c in (values, seen, reached))
            rms = _rms(values, seen), _rms(reached, values), _rms(reached, seen)
            found.append(Compared(d.outputs[0], d.joint, one, two, three, _ends(d, robot), *rms, modes))
    return found


def _value(cycle: Cycle, output: str, t: float) -> float:
    piece = _piece(cycle, t)
    dwell = t - float(piece.start)
    return sum(float(c) * dwell**k for k, c in enumerate(piece.outputs[output]))


def _piece(cycle: Cycle, t: float) -> Piece:
    return next((p for p in cycle.pieces if t < float(p.start + p.length)), cycle.pieces[-1])


def _ends(d: Drive, robot: Robot) -> tuple[float, float]:
    limits = robot.hinges[d.joint].limits
    assert limits is not None, "what is driven is a hinge"
    ends = [math.copysign(1, d.factor) * math.degrees(v) for v in (limits.lower, limits.upper)]
    return min(ends), max(ends)


def _reached(d: Drive, robot: Robot, value: float) -> float:
    limits = robot.hinges[d.joint].limits
    assert limits is not None, "what is driven is a hinge"
    low, high = math.degrees(limits.lower), math.degrees(limits.upper)
    commanded = float(d.factor) * value + float(d.offset)
    return min(max(commanded, low), high) * (1 if d.factor > 0 else -1)


def _rms(one: Sequence[float], other: Sequence[float]) -> float:
    return math.sqrt(sum((a - b) ** 2 for a, b in zip(one, other, strict=True)) / len(one))
