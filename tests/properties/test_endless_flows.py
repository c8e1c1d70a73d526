"""Claims without a horizon, and claims that use others: nothing is shown by a flow that was not followed."""

from __future__ import annotations

from pathlib import Path

import pytest

from haverify.analyses.hybrid.endless import proved_for_ever
from haverify.analyses.hybrid.model import hybrid_model
from haverify.analyses.hybrid.question import question_of
from haverify.analyses.portfolio import decide_all
from haverify.evidence.verdict import Unknown
from haverify.run.examine import read

STEP_LATER = [f"1.02 {sign} 0.{'0' * zeros}1" for sign in "+-" for zeros in (8, 10, 11, 12, 13, 14, 15)]


@pytest.mark.parametrize("guard", STEP_LATER)
def test_a_set_has_not_returned_before_it_moved(guard: str, tmp_path: Path) -> None:
    """A start that is one point, and a jump just about at the end of the first step, whose pace is adapted."""
    text = f"""spec "Later" version "1.0" unitless
automaton A {{
  var x
  var y
  init P where x == 1 and y == 0
  mode P {{ domain x <= 2; flow {{ x' = 1; y' = 0 }} }}
  mode B {{ flow {{ x' = 1; y' = 1 }} }}
  urgent edge go: P -> B when x >= {guard}
}}
property low on A {{ always y <= 3 }}
"""
    path = tmp_path / "later.ha"
    path.write_text(text)
    spec, _, found = read(str(path))
    assert spec is not None, [d.message for d in found]
    claim = spec.claims[0]
    model = hybrid_model(spec, spec.automata[0], [g.condition for g in claim.goals])
    assert proved_for_ever(question_of(model, claim, claim.goals[0])) is None


@pytest.mark.parametrize("goal", ["reach x >= 0.05 within 1", "stl eventually[0, 1] x >= 0.05"])
def test_what_is_not_proved_shows_nothing(goal: str, tmp_path: Path) -> None:
    """The run from x = y = 0 stays there: only an invariant that does not hold says otherwise."""
    text = f"""spec "Wrong" version "1.0" unitless
automaton A {{
  var x
  var y
  init P where 0 <= x <= 0.1 and 0 <= y <= 0.1
  mode P {{ flow {{ x' = y; y' = -sin(x) }} }}
}}
invariant wrong on A: x >= 0.05
property comes on A {{ {goal}; using wrong }}
"""
    path = tmp_path / "wrong.ha"
    path.write_text(text)
    spec, _, found = read(str(path))
    assert spec is not None, [d.message for d in found]
    verdict = decide_all(spec)["comes"].verdict
    assert isinstance(verdict, Unknown)
    assert verdict.kind == "dependency"
