"""Flowpipes to be drawn: few boxes, which hold all that they stand for."""

from __future__ import annotations

import json
from math import sin

from haverify.evidence.flowpipe import Stretch, flowpipe_json


def wave(count: int, jumps: int = 0) -> Stretch:
    """Boxes of width 0.02 around a sine, steps of 0.01."""
    steps = [((k / 100, (k + 1) / 100), [(sin(k / 100) - 0.01, sin(k / 100) + 0.01)]) for k in range(count)]
    return Stretch("Run", jumps, [(-0.01, 0.01)], steps)


def test_a_few_steps_are_kept_as_they_are() -> None:
    steps = [((0.0, 0.5), [(1.0, 2.0), (0.0, 0.25)]), ((0.5, 1.0), [(1.5, 2.5), (0.125, 0.5)])]
    value = flowpipe_json(["x", "y"], [Stretch("Run", 3, [(1.0, 1.0), (0.0, 0.0)], steps)])
    assert value["names"] == ["x", "y"]
    (piece,) = value["pieces"]
    assert (piece["mode"], piece["jumps"], piece["start"]) == ("Run", 3, [[1.0, 1.0], [0.0, 0.0]])
    assert piece["steps"] == [[0.0, 0.5, 1.0, 2.0, 0.0, 0.25], [0.5, 1.0, 1.5, 2.5, 0.125, 0.5]]


def test_many_steps_are_joined_and_hold_the_same() -> None:
    whole = wave(3000)
    steps = flowpipe_json(["x"], [whole])["pieces"][0]["steps"]
    assert len(steps) <= 500
    assert steps[0][0] == 0 and steps[-1][1] == 30
    for (start, end), [(low, high)] in whole.steps:
        below, above = next(s[2:] for s in steps if s[0] <= start + 1e-6 and end <= s[1] + 1e-6)
        assert below - 1e-5 <= low <= high <= above + 1e-5


def test_however_many_pieces_there_are_it_stays_small() -> None:
    value = flowpipe_json(["x"], [wave(200, jumps=k) for k in range(600)])
    assert len(json.dumps(value)) < 100_000


def test_pieces_without_a_step_are_left_out() -> None:
    assert flowpipe_json(["x"], [Stretch("Run", 0, [(0.0, 1.0)], [])])["pieces"] == []
