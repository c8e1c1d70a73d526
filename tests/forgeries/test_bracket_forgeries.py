"""Starts in brackets: accepted where equations certainly have a common zero there, refused elsewhere."""

from __future__ import annotations

import copy
from collections.abc import Callable
from typing import Any

import pytest
from tests.forgeries.test_attacks_on_invariants import FAULTS, World

from haverify.analyses.portfolio import decide_all
from haverify.evidence.verdict import Proved, Refuted

Json = Any
TURN = """
spec "Roots" version "1.0" unitless
automaton Turn {
  var x in [-5, 5]
  var y
  init Go where x^2 == 2 and y^2 == x + 1 and x >= 1
  mode Go { flow { x' = -y; y' = x } }
}
property near on Turn { always x^2 + y^2 <= 5; expect proved }
"""
ROOT = """
spec "Roots" version "1.0" unitless
automaton Turn {
  var x in [-5, 5]
  var y
  init Go where x^2 == 2 and y == 0
  mode Go { flow { x' = -y; y' = x } }
}
property near on Turn { always x^2 + y^2 <= 2; expect proved }
property low on Turn { always y <= 1; expect refuted because "it turns" }
"""


@pytest.fixture(scope="module")
def roots() -> tuple[World, dict[str, Json]]:
    """The world of a start that is a root of 2, and what is said of its claims."""
    world = World(ROOT)
    found = decide_all(world.spec)
    assert isinstance(found["near"].verdict, Proved)
    assert isinstance(found["low"].verdict, Refuted)
    return world, {name: e.certificate for name, e in found.items()}


def test_a_start_in_a_bracket_is_accepted(roots: tuple[World, dict[str, Json]]) -> None:
    world, certificates = roots
    assert world.verdict("near", certificates["near"]) == "proved"


FORGED: dict[str, Callable[[Json], Json]] = {
    "no zero in it": lambda _: {"x": ["1", "7/5"], "y": "0"},
    "two zeros in it": lambda _: {"x": ["-2", "2"], "y": "0"},
    "turned round": lambda v: {"x": v["x"][::-1], "y": "0"},
    "empty": lambda _: {"x": ["1", "1"], "y": "0"},
    "of what an equation gives otherwise": lambda v: {"x": v["x"], "y": ["1/10", "1/2"]},
    "out of its range": lambda _: {"x": ["1", "6"], "y": "0"},
    "a number near it": lambda v: {"x": v["x"][0], "y": "0"},
    "of three numbers": lambda v: {"x": [*v["x"], "2"], "y": "0"},
    "of no numbers": lambda _: {"x": ["a", "b"], "y": "0"},
    "another coordinate off": lambda v: {"x": v["x"], "y": "1/10"},
}


@pytest.mark.parametrize("name", FORGED)
def test_a_forged_bracket_is_refused(name: str, roots: tuple[World, dict[str, Json]]) -> None:
    world, certificates = roots
    given = copy.deepcopy(certificates["near"])
    start = given["goals"][0]["start"]
    start["values"] = FORGED[name](start["values"])
    with pytest.raises(FAULTS):
        world.verdict("near", given)


def test_two_equations_need_a_common_zero() -> None:
    world = World(TURN)
    given = decide_all(world.spec)["near"].certificate
    assert given is not None
    assert world.verdict("near", given) == "proved"
    start = given["goals"][0]["start"]
    assert all(isinstance(q, list) for q in start["values"].values())
    start["values"]["y"] = ["1", "3/2"]  # the square of y is 2.41
    with pytest.raises(FAULTS):
        world.verdict("near", given)
