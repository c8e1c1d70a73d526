"""Roots, logarithms and inverses: slopes only where they have one, starts only where they are defined."""

from __future__ import annotations

from typing import Any

import pytest
from tests.forgeries.test_attacks_on_invariants import FAULTS, World

Json = Any
SPEC = """
spec "Partial" version "1.0" unitless
automaton A {
  var x
  var y
  init Run where x == START and y == 0
  mode Run { domain DOMAIN; flow { x' = XRATE; y' = YRATE } }
}
invariant i on A: CLAIM inductive
"""
GROWS = {"rule": "growth", "cofactor": [], "band": None, "proof": "b"}


def outcome(claim: str, literal: Json, start: Json, keep: Json = None, **texts: str) -> str:
    given = {"START": "1", "DOMAIN": "x >= 1/2 and x <= 4", "XRATE": "1", "YRATE": "0", "CLAIM": claim} | texts
    text = SPEC
    for word, replacement in given.items():
        text = text.replace(word, replacement)
    world = World(text)
    flow = {"cuts": [{"formula": literal, "start": "t", "keep": keep or GROWS}], "end": "b"}
    here = {"mode": "Run", "values": {"x": start, "y": "0"}, "params": {}}
    return world.forge("i", None, {"init": "b", "flow": flow}, here)


def at_least(name: str, bound: str) -> Json:
    return ["<=", [["-1", name], [bound]]]


@pytest.mark.parametrize(("function", "bound"), [("sqrt(x)", "1/2"), ("log(x)", "-1")])
def test_what_grows_is_accepted_where_it_has_a_slope(function: str, bound: str) -> None:
    name = function.replace("x", "1*x")
    literal = at_least(name, bound)
    assert outcome(f"{function} >= {bound}", literal, "1") == "proved"
    for domain in ("x >= 0 and x <= 4", "true", "x >= -1", "x <= 4"):
        with pytest.raises(FAULTS):
            outcome(f"{function} >= {bound}", literal, "1", DOMAIN=domain)


def test_a_root_at_its_end_has_no_slope() -> None:
    """`x' = -x`, and sqrt(x) <= 2 would need its slope at 0, which is not there; the rate may read a root at 0."""
    literal = ["<=", [["1", "sqrt(1*x)"], ["-2"]]]
    with pytest.raises(FAULTS):
        outcome("sqrt(x) <= 2", literal, "1", DOMAIN="x >= 0", XRATE="-x")
    falls = ["<=", [["1", "x"], ["-1"]]]
    assert outcome("x <= 1", falls, "1", DOMAIN="x >= 0 and x <= 9", XRATE="-sqrt(x)") == "proved"
    with pytest.raises(FAULTS):
        outcome("x <= 1", falls, "1", DOMAIN="x >= -1 and x <= 9", XRATE="-sqrt(x)")


def test_a_root_is_no_smooth_rate_of_what_rests() -> None:
    """`x' = sqrt(x)` leaves 0 though it may stay there."""
    rest = {"rule": "rest", "proofs": [["put", 0, "x", "b"]]}
    literal = ["==", [["1", "x"]]]
    with pytest.raises(FAULTS):
        outcome("x == 0", literal, "0", rest, START="0", DOMAIN="x >= 0", XRATE="sqrt(x)")


def test_a_rate_may_have_a_divisor_that_the_domain_keeps_from_0() -> None:
    literal = ["<=", [["-1", "x"], ["1"]]]
    assert outcome("x >= 1", literal, "1", XRATE="1 / x") == "proved"
    assert outcome("x >= 1", literal, "1", XRATE="1 / x", DOMAIN="x >= 1/2") == "proved"
    for domain in ("true", "x >= 0", "x >= -1"):
        with pytest.raises(FAULTS):
            outcome("x >= 1", literal, "1", XRATE="1 / x", DOMAIN=domain)


ROOT = [["1", "sqrt(2)"]]
MORE = ["<=", [["-1", "x"], ["1"]]]


def test_a_start_may_have_an_irrational_value() -> None:
    assert outcome("x >= 1", MORE, ROOT, START="sqrt(2)") == "proved"
    assert outcome("x >= 1", MORE, [["1", "pi"], ["-1"]], START="pi - 1") == "proved"


@pytest.mark.parametrize(
    "start",
    ["1414/1000", [["1", "sqrt(3)"]], [["1", "x"]], [["1", "y"], *ROOT], [["1", "time"]], [["2", "sqrt(2)"]], [], "x"],
)
def test_other_values_are_no_start(start: Json) -> None:
    with pytest.raises(FAULTS):
        outcome("x >= 1", MORE, start, START="sqrt(2)")


@pytest.mark.parametrize("start", ["sqrt(-2)", "log(0)", "log(-1)"])
def test_what_is_not_defined_is_no_start(start: str) -> None:
    name = start if start != "log(0)" else "log()"
    with pytest.raises(FAULTS):
        outcome("x >= 1 or x < 1", True, [["1", name]], START=start)


JUMPING = """
spec "Jumping" version "1.0" unitless
automaton A {
  var x
  var y
  init Run where x == 0 and y == 1
  mode Run {
    flow { x' = 0; y' = YRATE }
    edge e: -> Run when GUARD do { x := RESET }
  }
}
invariant i on A: x <= 1 inductive
"""


def jumping(guard: str, reset: str, yrate: str = "0") -> str:
    world = World(JUMPING.replace("GUARD", guard).replace("RESET", reset).replace("YRATE", yrate))
    literal = ["<=", [["1", "x"], ["-1"]]]
    flow = {"cuts": [{"formula": literal, "start": "t", "keep": GROWS}], "end": "b"}
    here = {"mode": "Run", "values": {"x": "0", "y": "1"}, "params": {}}
    return world.forge("i", None, {"init": "b", "edge": "b", "flow": flow}, here)


def test_what_a_jump_reads_is_defined_where_it_is_made() -> None:
    """`sqrt(y) - sqrt(y)` is 0 where y is not below 0, and has no value elsewhere (LANGUAGE S1)."""
    for reset in ("sqrt(y) - sqrt(y)", "0 * log(y + 1)", "1"):
        assert jumping("y >= 0", reset) == "proved"
    assert jumping("y <= 0", "1") == "proved"
    for guard, reset in (("y <= 0", "sqrt(y) - sqrt(y)"), ("true", "0 * sqrt(y)"), ("y >= 0", "0 * log(y)")):
        with pytest.raises(FAULTS):
            jumping(guard, reset)


def test_what_cancels_in_a_rate_is_evaluated() -> None:
    assert jumping("true", "1", "sqrt(1 + 0 * y)") == "proved"
    for rate in ("sqrt(y) - sqrt(y)", "0 * log(y)"):
        with pytest.raises(FAULTS):
            jumping("true", "1", rate)
