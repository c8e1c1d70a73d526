"""States that are said to be at rest: only where nothing moves them, whatever the certificate says."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.forgeries.test_attacks_on_invariants import FAULTS, World

Json = Any
SPEC = """
spec "Rest" version "1.0" unitless
param a in [1, 2]
automaton A {
  var x
  var y
  var z
  init Run where x == a and y == 0 and z == 0
  mode Run { flow { x' = XRATE; y' = YRATE; z' = z } }
}
invariant still on A: CUT inductive
"""
START = {"mode": "Run", "values": {"x": "3/2", "y": "0", "z": "0"}, "params": {"a": "3/2"}}
X, Y = ["==", [["1", "x"], ["-1", "a"]]], ["==", [["1", "y"]]]
PUT = ["put", 2, "x", ["put", 3, "y", "t"]]


def flow(formula: Json = None, keep: Json = None) -> Json:
    rest = {"rule": "rest", "proofs": [PUT, PUT]}
    return {"cuts": [{"formula": formula or ["and", X, Y], "start": "t", "keep": keep or rest}], "end": "t"}


def outcome(x: str, y: str, cut: str = "x == a and y == 0", proof: Json = None) -> str:
    world = World(SPEC.replace("XRATE", x).replace("YRATE", y).replace("CUT", cut))
    return world.forge("still", None, {"init": "t", "flow": proof or flow()}, START)


def test_what_rests_is_accepted() -> None:
    assert outcome("y * x", "x^2 - a^2") == "proved"
    assert outcome("y", "sin(x - a)") == "proved"
    assert outcome("y / (1 + x^2)", "(x - a) * y + y") == "proved"


@pytest.mark.parametrize(
    ("x", "y"),
    [
        ("y * x", "x^2 - a"),
        ("y + 1/1000", "x - a"),
        ("y", "x - a + z"),  # moved by z, which is not pinned though it stays 0
        ("y", "cos(x - a)"),
        ("y", "x - a + time"),
        ("z * y", "x - a"),
    ],
)
def test_what_moves_is_refused(x: str, y: str) -> None:
    with pytest.raises(FAULTS):
        outcome(x, y)


@pytest.mark.parametrize(
    "formula",
    [
        X,
        Y,
        ["and", X, ["<=", [["1", "y"]]]],
        ["and", X, ["==", [["1", "y", "y"]]]],
        ["and", X, ["==", [["1", "y"], ["-1", "z"]]]],
        ["and", X, ["==", [["1", "y"], ["-1", "x"], ["1", "a"]]]],
        ["and", X, X],
        ["or", X, Y],
    ],
)
def test_cuts_of_another_shape_are_refused(formula: Json) -> None:
    with pytest.raises(FAULTS):
        outcome("y * x", "x^2 - a^2", proof=flow(formula))


RATES = ("y", "x - a", "y * (x - a)", "x", "1", "z", "y + z", "x - 2", "sin(y)", "x * y - a * y + z^2")


@settings(max_examples=120, deadline=None, derandomize=True)
@given(x=st.sampled_from(RATES), y=st.sampled_from(RATES), data=st.data())
def test_only_what_rests_is_accepted(x: str, y: str, data: st.DataObject) -> None:
    """Rates that are 0 at x = a, y = 0 for all a, and do not read z."""
    proofs = data.draw(st.lists(st.sampled_from([PUT, "t", "b", ["put", 3, "y", ["put", 2, "x", "t"]]]), max_size=3))
    rests = {"y", "x - a", "y * (x - a)", "sin(y)"}
    try:
        found = outcome(x, y, proof=flow(keep={"rule": "rest", "proofs": proofs}))
    except FAULTS:
        return
    assert found == "proved" and {x, y} <= rests
