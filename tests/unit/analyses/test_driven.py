"""Claims about flows with inputs and inclusions, under assumptions and with invariants."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

import pytest

from haverify.analyses.portfolio import decide_all
from haverify.evidence.evidence import Evidence
from haverify.evidence.verdict import Proved, Refuted, Unknown
from haverify.run.examine import read

Decide = Callable[[str, str], Evidence]

SPRING = """
input wind in [-0.1, 0.1]
param k in [1, 1.2]
automaton A {
  var x
  var v
  init R where 0.9 <= x <= 1 and v == 0
  mode R { flow { x' = v; v' = -k * x - 0.5 * v + wind } }
}
"""
FALL = "automaton A { var x; init R where 1 <= x <= 2; mode R { flow { x' in [-1, -0.5] } } }"
SHRINKING = "automaton A { var x; init R where 1 <= x <= 2; mode R { flow { x' in [-x, -x / 2] } } }"
RUNNING = """
input u in [-0.5, 0.5]
automaton A {
  var x
  var t
  init P where 0 <= x <= 0.1 and t == 0
  mode P { domain x <= 1; flow { x' = 1 + u; t' = 1 }; urgent edge go: -> Q when x >= 1 do x := 0.5 }
  mode Q { domain t <= 5; flow { x' = -x + u * x; t' = 1 } }
}
"""
SLOPED = """
input u in [0, 1] rate [0.1, 0.2]
automaton A { var x; init R where x == 1; mode R { flow { x' = u * x } } }
"""
DECAY = """
param a in [0, 10]
automaton A { var x; var y; init R where x == 1 and y == 0; mode R { flow { x' = -a * x * x; y' = x } } }
"""


@pytest.fixture
def decided(tmp_path: Path) -> Decide:
    def decide(text: str, claim: str) -> Evidence:
        path = tmp_path / "driven.ha"
        path.write_text(f'spec "S" version "1.0" unitless\n{text}\n{claim}\n', encoding="utf-8")
        spec = read(str(path))[0]
        assert spec is not None
        return decide_all(spec, ["p"])["p"]

    return decide


@pytest.mark.parametrize(
    ("text", "claim", "verdict"),
    [
        (SPRING, "within 5; always abs(x) <= 1.1", Proved),
        (SPRING, "within 10; always x >= -0.6", Refuted),
        (SPRING, "can reach x <= -0.45 within 5", Proved),
        (SPRING, "can reach x <= -0.7 within 5", Refuted),
        (SPRING.replace("[-0.1, 0.1]", "[0, 0]"), "within 5; always x >= -0.6", Proved),
        (FALL, "within 1; always x >= -0.01", Proved),
        (FALL, "within 1; always x >= 0.01", Refuted),
        (FALL, "reach x <= 1.5 within 1.01", Proved),
        (FALL, "reach x <= 1.5 within 0.9", Refuted),
        (SHRINKING, "within 1; always x <= 2", Proved),
        (SHRINKING, "within 1; always x >= 0.2", Proved),
        (SHRINKING, "within 1; always x >= 0.5", Refuted),
        (RUNNING, "within 3; always x <= 1.01", Proved),
        (RUNNING, "reach at(Q) within 2.1", Proved),
        (RUNNING, "reach at(Q) within 1.9", Refuted),
        (RUNNING, "within 3; always at(Q) implies t >= 0.59", Proved),
        (RUNNING, "within 3; always at(Q) implies t >= 0.61", Refuted),
        (RUNNING, "always x <= 1.01", Proved),
        (SLOPED, "within 1; always x <= 2.8", Proved),
        (SLOPED, "within 1; always x <= 2", Unknown),
        (DECAY, "assume a >= 9; within 1; always y <= 0.3", Proved),
        (DECAY, "assume a >= 9; within 1; always y <= 0.2", Refuted),
        (DECAY, "within 1; always y <= 0.3", Refuted),
        (DECAY, "assume x >= 0.5; within 1; always y <= 1.01", Proved),
        (DECAY, "assume x >= 0.5 or a <= 1; within 1; always a <= 1 or y <= 0.9", Proved),
        (DECAY, "assume x >= 2; within 1; always y <= 1", Unknown),
    ],
)
def test_verdicts(decided: Decide, text: str, claim: str, verdict: type) -> None:
    found = decided(text, f"property p on A {{ {claim} }}").verdict
    assert isinstance(found, verdict), found


def test_the_run_that_refutes_names_the_inputs(decided: Decide) -> None:
    run = decided(SPRING, "property p on A { within 10; always x >= -0.6 }").run
    assert run is not None
    assert dict(run.params)["wind"] == Fraction(-1, 10)


@pytest.mark.parametrize(
    ("text", "claim", "words"),
    [
        (SPRING, "within 1; never wind > 0.05", "input `wind`"),
        (SPRING.replace(" in [-0.1, 0.1]", " in [1, -1]"), "within 1; always x <= 2", "there is none"),
        (FALL.replace("[-1, -0.5]", "[1, -1]"), "within 1; always x <= 3", "there is none"),
        (DECAY, "assume x >= 2; within 1; always y <= 1", "no start"),
    ],
)
def test_what_is_left_open_says_why(decided: Decide, text: str, claim: str, words: str) -> None:
    found = decided(text, f"property p on A {{ {claim} }}").verdict
    assert isinstance(found, Unknown)
    assert words in found.reason


def test_an_invariant_that_is_used_cuts_the_sets(decided: Decide) -> None:
    text = """
automaton A {
  var x
  var y
  init R where 0 <= x <= 1 and y == 1 - x
  mode R { flow { x' = sin(x + y) - sin(x + y); y' = -sin(x + y) + sin(x + y) } }
}
invariant N on A: abs(x + y - 1) <= 1 inductive
property p on A { within 1; using N; always x + y <= 2 }
"""
    assert isinstance(decided(text, "").verdict, Proved)
