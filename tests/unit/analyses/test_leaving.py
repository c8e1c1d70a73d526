"""States from which an invariant fails: where, what would exclude them, what a figure shows of them."""

from __future__ import annotations

import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from haverify.analyses.portfolio import decide_all
from haverify.evidence.evidence import Evidence
from haverify.evidence.verdict import Proved, Unknown
from haverify.report.figures.of_claims import drawn
from haverify.report.figures.portraits import of_leaving
from haverify.run.examine import read

CLAIM: Any = SimpleNamespace(name="i")
TURN = """
spec "Turn" version "1.0" unitless
automaton A {
  var x
  var y
  init Go where x^2 + y^2 <= 1/2
  mode Go { domain y <= 2; flow { x' = -y; y' = x } }
}
invariant i on A: x <= 3/4 and y <= 3/4 inductive
"""
BLOCK = """
spec "Block" version "1.0"
param r in [0, 1]
const alpha: rad = 0.2 rad
automaton A {
  var x: m
  var v: m/s
  let left = cos(alpha * (1 + x / 1 m)) + (alpha * v * 1 s/m)^2 / 2
  let right = cos(alpha * (1 - x/ 1 m)) + (alpha * v * 1 s/m)^2 / 2
  init Left where -1 m <= x <= 0 m and left <= 1
  mode Left {
    domain x <= 0 m
    flow { x' = v; v' = sin(alpha * (1 + x / 1 m)) / alpha * 1 rad * 1 m/s^2 }
    edge over: -> Right when x == 0 m and v >= 0 m/s do v := r * v
  }
  mode Right {
    domain x >= 0 m
    flow { x' = v; v' = -sin(alpha * (1 - x / 1 m)) / alpha * 1 rad * 1 m/s^2 }
    edge back: -> Left when x == 0 m and v <= 0 m/s do v := r * v
  }
}
invariant i on A: (at(Left) implies -1 m <= x <= 0 m) and (at(Right) implies right <= 1 and 0 m <= x <= 1 m) inductive
"""
SIGN = """
spec "Sign" version "1.0"
param k: m in [1 m, 2 m]
automaton A {
  var x: m
  var y: m
  init Go where x == k and 1 m <= y <= 2 m
  mode Go { flow { x' = y / 1 s; y' = x * y * y / (1 m^2 * 1 s) } }
}
invariant i on A: x >= k inductive
"""


def decided(folder: Path, text: str) -> Evidence:
    path = folder / "a.ha"
    path.write_text(text.lstrip(), encoding="utf-8")
    spec, _, found = read(str(path))
    assert spec is not None, found
    return decide_all(spec)["i"]


@pytest.mark.parametrize(
    ("text", "state"),
    [(TURN, "x = 0.75, y = -0.25"), (BLOCK, "r = 0.5, v = 2 m/s, x = 0 m"), (SIGN, "k = 1.5 m, x = 1.5 m, y = -")],
)
def test_what_is_said_to_exclude_the_state_makes_the_claim_inductive(tmp_path: Path, text: str, state: str) -> None:
    verdict = decided(tmp_path, text).verdict
    assert isinstance(verdict, Unknown) and verdict.kind == "inductive", verdict
    assert state in verdict.reason and verdict.reached.startswith("spurious so far: of ")
    added = re.fullmatch(r"add `(and .*)`: it excludes this state, .*", verdict.next_step)
    assert added is not None, verdict.next_step
    assert isinstance(decided(tmp_path, text.replace(" inductive", f" {added[1]} inductive")).verdict, Proved)


def test_slopes_are_told(tmp_path: Path) -> None:
    verdict = decided(tmp_path, TURN).verdict
    assert isinstance(verdict, Unknown)
    assert "`-3 + 4*x <= 0` is at its bound" in verdict.nearest and "first derivative 1" in verdict.nearest


def test_the_figure_shows_the_state_the_border_and_the_flow(tmp_path: Path) -> None:
    data: Any = decided(tmp_path, TURN).flowpipe
    assert data["state"] == [0.75, -0.25] and data["arrow"] == [0.25, 0.75]
    assert "1" in data["broken"] and "1" in data["starts"] and "1" not in data["outside"]
    (figure,) = drawn(of_leaving, data, CLAIM)
    assert "mark bad" in figure.svg and "bound" in figure.svg and "begins" in figure.svg
    (a, b), (c, d) = data["ranges"]
    assert a < 0.75 < b and c < -0.25 < d


@pytest.mark.parametrize("key", ["ranges", "broken", "borders", "field", "state", "names"])
def test_data_of_another_shape_are_not_drawn(tmp_path: Path, key: str) -> None:
    data: Any = decided(tmp_path, TURN.replace("y <= 3/4 ind", "x >= -9 ind")).flowpipe
    assert drawn(of_leaving, data, CLAIM)
    for wrong in (None, "x", [[1]], 1):
        assert drawn(of_leaving, {**data, key: wrong}, CLAIM) == []


def test_one_variable_has_no_figure(tmp_path: Path) -> None:
    text = (
        'spec "a" version "1.0" unitless\nautomaton A { var x; init G where x == 0; mode G { flow { x\' = x + 1 } } }\n'
    )
    found = decided(tmp_path, text + "invariant i on A: x <= 3 inductive\n")
    assert found.flowpipe is None
