"""Searches over choices: edges that may wait, resets that choose, and a time limit that is said."""

import json
from pathlib import Path

import pytest

from haverify.cli import main

WAITING = """spec "Waiting" version "1.0" unitless
automaton A {
  var x in [-1, 10]
  var c in [-1, 10]
  init Wait with { x := 0; c := 0 }
  mode Wait { domain x <= 3
    flow { x' = 1; c' = 0 }
    edge go: -> Run when x >= 1 do c in [1, 2] }
  mode Run { domain x <= 6
    flow { x' = 1; c' = 0.5 - 0.1 * c }
    edge back: -> Wait when x >= 4 do x := 0 }
}
"""
POLE = """spec "Pole" version "1.0" unitless
automaton P { var x
  init M with { x := 1 }
  mode M { flow { x' = RATE } } }
"""
CLAIMS = {
    "early": "always not (at(Run) and x <= 2)",
    "late": "always not (at(Wait) and x >= 2.5)",
    "large": "always c <= 1.9",
}


def falsified(
    text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], *options: str
) -> tuple[int, dict[str, object]]:
    path = tmp_path / "model.ha"
    path.write_text(text)
    code = main(["falsify", str(path), "--format", "json", *options])
    (told,) = json.loads(capsys.readouterr().out)
    return code, told


@pytest.mark.parametrize("name", CLAIMS)
def test_what_an_edge_may_do_is_tried_and_certified(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    claim = f"property {name} on A {{ within 5; {CLAIMS[name]}; expect refuted }}\n"
    code, told = falsified(WAITING + claim, tmp_path, capsys, "-n", "100")
    assert code == 0 and told["verdict"] == "refuted", told


def test_what_holds_however_edges_wait_is_not_violated(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    claim = "property fine on A { within 5; always c <= 8 }\n"
    code, told = falsified(WAITING + claim, tmp_path, capsys, "-n", "60")
    assert code == 3 and told["runs"] == 60 and told["reason"] == "no violation was found"


def test_a_search_that_is_stopped_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    claim = "property fine on A { within 5; always c <= 8 }\n"
    code, told = falsified(WAITING + claim, tmp_path, capsys, "-n", "100000", "--seconds", "0.5")
    assert code == 3 and "stopped after 0.5 s" in str(told["reason"])


@pytest.mark.parametrize(("rate", "how"), [("-1 / x", "undefined"), ("x^2", "escape"), ("1 / (2 - x)", "undefined")])
def test_a_pole_is_no_escape_to_infinity(
    rate: str, how: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "pole.ha"
    path.write_text(POLE.replace("RATE", rate))
    assert main(["simulate", str(path), "--format", "json"]) == 0
    assert json.loads(capsys.readouterr().out)[0]["end"]["how"] == how
