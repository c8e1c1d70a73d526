"""Inputs in flows: what is shown holds for all their values, and nothing is made of their derivatives."""

from __future__ import annotations

from typing import Any

import pytest
from tests.forgeries.test_attacks_on_invariants import FAULTS, World

from haverify.analyses.portfolio import decide_all
from haverify.evidence.verdict import Proved, Unknown

Json = Any
SPEC = """
spec "Inputs" version "1.0" unitless
INPUT
automaton A {
  OWN
  var x
  init Run where x == START
  mode Run { domain DOMAIN; flow { x' = RATE }; edge kick: -> Run when GUARD do x := RESET }
}
invariant i on A: x <= 1 inductive
"""
CUT = ["<=", [["1", "x"], ["-1"]]]
BARRIER = {"rule": "barrier", "proofs": ["b"]}
LIE = {"rule": "lie", "ranks": [[1, None, []]], "forward": "b", "backward": "b"}
TEXTS = {
    "INPUT": "",
    "OWN": "input u in [-1, 1]",
    "START": "0",
    "DOMAIN": "x >= -9",
    "RATE": "u - 2 * x",
    "GUARD": "x > 3",
    "RESET": "0",
}


def world(**texts: str) -> World:
    text = SPEC
    for word, replacement in {**TEXTS, **texts}.items():
        text = text.replace(word, replacement)
    return World(text)


def outcome(keep: Json = BARRIER, cut: Json = CUT, edge: Json = "b", start: str = "0", **texts: str) -> str:
    flow = {"cuts": [{"formula": cut, "start": "b", "keep": keep}], "end": "t"}
    here = {"mode": "Run", "values": {"x": start}, "params": {}}
    return world(**texts).forge("i", None, {"init": "b", "flow": flow, "edge": edge}, here)


def test_what_holds_for_all_inputs_is_accepted() -> None:
    assert outcome() == "proved"
    assert outcome(INPUT="input w in [-1, 1/2]", OWN="", RATE="w - x") == "proved"
    assert outcome(GUARD="u > 0", RESET="u") == "proved"
    grows = {"rule": "growth", "cofactor": [["1", "u"]], "band": None, "proof": "b"}
    assert outcome(grows, RATE="u * (x - 1)") == "proved"


@pytest.mark.parametrize(
    "texts",
    [
        {"OWN": "input u in [-1, 2]"},
        {"OWN": "input u in [-1, 3]"},
        {"RATE": "u * x"},
        {"GUARD": "u > 0", "RESET": "2 * u"},
        {"OWN": "input u"},
        {"DOMAIN": "x >= u"},
        {"START": "u"},
        {"OWN": "input u in [1, -1]"},
    ],
)
def test_what_fails_for_some_input_is_refused(texts: dict[str, str]) -> None:
    with pytest.raises(FAULTS):
        outcome(**texts)


def test_inputs_have_no_derivatives_and_are_in_no_formula() -> None:
    for keep, cut in (
        (LIE, CUT),
        (BARRIER, ["<=", [["1", "u"], ["-1"]]]),
        (BARRIER, ["<=", [["1", "x", "u"], ["-1"]]]),
    ):
        with pytest.raises(FAULTS):
            outcome(keep, cut)


def test_analyses_know_inputs() -> None:
    for texts, kind in (({}, Proved), ({"OWN": "input u in [-1, 3]"}, Unknown), ({"DOMAIN": "x >= u"}, Unknown)):
        assert isinstance(decide_all(world(**texts).spec, ["i"])["i"].verdict, kind)
