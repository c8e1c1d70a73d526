"""Jumps that change nothing but the mode: touching a border, certain crossings, and what is not of that kind."""

from __future__ import annotations

from pathlib import Path

import pytest

from haverify.analyses.hybrid.counted import counted_of, proved_by_counting
from haverify.analyses.hybrid.model import hybrid_model
from haverify.analyses.hybrid.question import Question, question_of
from haverify.analyses.portfolio import decide_all
from haverify.evidence.verdict import Proved
from haverify.model.spec import Spec
from haverify.run.examine import read

# A circle around 0, and a line at y = 1: from (-r, 0) a run turns upwards and is at (0, r) after a quarter of a turn.
TURNING = """
spec "turning" version "1.0" unitless
enum Count = 0..5
automaton A {
  var x
  var y
  var n: Count
  init Below where %s <= x <= %s and y == 0 with { n := 0 }
  mode Below {
    domain y <= 1
    flow { x' = y; y' = -x }
    urgent edge up: -> Above when y > 1 do n := if n < 5 then n + 1 else 5
  }
  mode Above {
    domain y >= 1
    flow { x' = y; y' = -x }
    urgent edge down: -> Below when y < 1 do n := if n < 5 then n + 1 else 5
  }
}
property p on A {
  within 8
  always during [%s, %s] %s
}
"""


def spec_of(tmp_path: Path, text: str) -> Spec:
    (tmp_path / "a.ha").write_text(text, encoding="utf-8")
    spec, found, _ = read(str(tmp_path / "a.ha"))
    assert spec is not None, found
    return spec


def question(tmp_path: Path, text: str) -> Question:
    spec = spec_of(tmp_path, text)
    (claim,) = spec.claims
    model = hybrid_model(spec, spec.automata[0], [g.condition for g in claim.goals])
    return question_of(model, claim, claim.goals[0])


@pytest.mark.parametrize(
    ("low", "high", "instant", "claim"),
    [
        ("-1.1", "-0.9", "3", "n == 0 or n == 2"),  # the middle start touches the line and makes no jump
        ("-1", "-1", "3", "n == 0 or n == 2"),
        ("-0.9", "-0.8", "3", "n == 0"),
        ("-1.2", "-1.1", "3", "n == 2"),
        ("-1.2", "-1.1", "1.57", "n == 1 and y >= 1"),
        ("-1.1", "-0.9", "8", "n == 0 or n == 2 or n == 4 or n == 3"),
        ("-1.1", "-0.9", "7", "n <= 2"),
    ],
)
def test_what_is_counted(tmp_path: Path, low: str, high: str, instant: str, claim: str) -> None:
    assert proved_by_counting(question(tmp_path, TURNING % (low, high, instant, instant, claim))) is True


@pytest.mark.parametrize(
    ("low", "high", "instant", "claim"),
    [
        ("-1.1", "-0.9", "3", "n == 2"),
        ("-1.1", "-0.9", "3", "n == 0"),
        ("-0.9", "-0.8", "3", "n == 2"),
        ("-1.2", "-1.1", "1.57", "n != 1"),
        ("-1.2", "-1.1", "3", "n <= 1"),
    ],
)
def test_what_is_false_is_not_shown(tmp_path: Path, low: str, high: str, instant: str, claim: str) -> None:
    assert proved_by_counting(question(tmp_path, TURNING % (low, high, instant, instant, claim))) is False


GOOD = TURNING % ("-1.1", "-0.9", "3", "3", "n == 0 or n == 2")


@pytest.mark.parametrize(
    "change",
    [
        ("y > 1 do", "y >= 1 do"),  # a guard that holds at a touch: jumps without end at one instant
        ("do n := if n < 5 then n + 1 else 5", "do { n := 1; y := y + 0.1 }"),
        ("domain y >= 1\n    flow { x' = y; y' = -x }", "domain y >= 1\n    flow { x' = y; y' = -x - 0.1 }"),
        ("domain y >= 1", "domain y >= 1 and x <= 5"),
        ("domain y <= 1", "domain y <= 1.5"),
        ("urgent edge up", "edge up"),
        ("n == 0 or n == 2", "jumped or n == 0 or n == 2"),
    ],
)
def test_what_is_not_of_that_kind_is_left_to_others(tmp_path: Path, change: tuple[str, str]) -> None:
    def is_counted(text: str) -> bool:
        return counted_of(question(tmp_path, text)) is not None

    assert is_counted(GOOD)
    assert change[0] in GOOD
    assert not is_counted(GOOD.replace(change[0], change[1], 1))


def test_a_goal_that_is_shown_is_proved(tmp_path: Path) -> None:
    assert isinstance(decide_all(spec_of(tmp_path, GOOD))["p"].verdict, Proved)
