"""The core of a small automaton, byte for byte, and expressions there and back."""

import json

from tests.unit.elaborate.texts import healthy

from haverify.model.core import canonical, expr_from_json, expr_to_json, to_core

BALL = """spec "Ball" version "1.0"
const g: m/s^2 = 9.81 m/s^2
param c in [0.7, 0.8]
automaton Ball {
  var h: m
  var v: m/s
  init Fall where 10 m <= h <= 10.2 m and v == 0 m/s
  mode Fall {
    domain h >= 0 m
    flow { h' = v; v' = -g }
    urgent edge bounce: -> Fall when h <= 0 m and v < 0 m/s do v := -c * v
  }
}
property height on Ball { within 5 s, 20 jumps; always h <= 1020 cm; expect proved margin > 1 mm }
"""
CORE = {
    "schema": "haverify.core/1",
    "spec": {"name": "Ball", "version": "1.0", "unitless": False},
    "units": [], "enums": [], "inputs": [], "tables": [], "networks": [], "assumptions": [], "systems": [],
    "cellular": [], "relations": [], "fuzzy": [], "cells": [],
    "constants": [{"name": "g", "type": "real", "unit": "m/s^2", "value": "981/100", "half": None}],
    "params": [{"name": "c", "unit": "1", "low": "7/10", "high": "4/5", "default": None}],
    "automata": [{
        "name": "Ball", "constants": [], "params": [], "inputs": [], "lets": [], "priorities": [],
        "vars": [
            {"name": "h", "type": "real", "unit": "m", "low": None, "high": None},
            {"name": "v", "type": "real", "unit": "m/s", "low": None, "high": None},
        ],
        "init": [{"mode": "Fall", "with": [], "where": [
            "and", ["<=", "10", ["var", "h"]], ["<=", ["var", "h"], "51/5"], ["==", ["var", "v"], "0"]]}],
        "modes": [{
            "name": "Fall", "domain": [">=", ["var", "h"], "0"], "lets": [], "terminal": False,
            "flow": [{"var": "h", "rate": ["var", "v"]}, {"var": "v", "rate": ["neg", ["const", "g"]]}],
        }],
        "edges": [{
            "name": "bounce", "source": "Fall", "target": "Fall", "urgent": True,
            "guard": ["and", ["<=", ["var", "h"], "0"], ["<", ["var", "v"], "0"]],
            "resets": [{"var": "v", "to": ["*", ["neg", ["param", "c"]], ["var", "v"]]}],
        }],
    }],
    "claims": [{
        "name": "height", "on": "Ball", "kind": "property", "horizon": {"time": "5", "jumps": 20}, "assume": [],
        "which": [], "using": [], "method": None, "inductive": False,
        "goals": [{"kind": "always", "condition": ["<=", ["var", "h"], "51/5"], "window": None, "within": None,
                   "attracting": False}],
        "expect": {"verdict": "proved", "margin": [">", "1", "mm"], "share": None, "because": None},
    }],
}  # fmt: skip


def test_the_core_of_a_ball() -> None:
    assert to_core(healthy(BALL)) == CORE


def test_canonical_json() -> None:
    text = canonical({"b": [1, "é"], "a": None})
    assert text == '{"a":null,"b":[1,"é"]}\n'.encode()
    assert canonical(to_core(healthy(BALL))) == canonical(json.loads(canonical(CORE)))


def test_expressions_there_and_back() -> None:
    texts = [
        "1/3", True, ["pi"], ["time"], ["scale", "1/180", 1, ["var", "x"]], ["sym", "E", "a"],
        ["if", ["at", "M"], "1", "2"], ["field", ["next", "C", ["bound", "c"]], "leg"],
        ["forall", "c", "Cell", ["defined", ["next", "C", ["bound", "c"]]]], ["table", "T", "y", ["time"]],
        ["fuzzy", "F", "out", [["a", "1"], ["b", ["var", "x"]]]], ["covered", "F", "a", "1/2"],
        ["until", "0", "1", ["jumped"], ["jump", "e"]], ["is", "a", "small"], ["cell", "Cell", "0101"],
        ["net", "N", "u", ["var", "x"]], ["related", "R", ["bound", "c"]], ["pre", ["let", "y"]],
        ["strength", "F", "t"],
    ]  # fmt: skip
    for value in texts:
        assert expr_to_json(expr_from_json(value)) == value
