"""Runs beside proofs: sound flowpipes raise no alarm, one that is a hundredth too narrow does."""

import copy
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest

from haverify.analyses.portfolio import decide_all
from haverify.elaborate.elaborate import elaborate
from haverify.evidence.evidence import Evidence
from haverify.evidence.verdict import Proved, Trust, Unknown
from haverify.model.spec import Spec
from haverify.run import beside as side
from haverify.run.executors import Solved
from haverify.run.load import load
from haverify.run.pipeline import Options, check
from haverify.simulate.crosscheck import Beside
from haverify.text.record import replace

BALL = """spec "Ball" version "1.0" unitless
automaton Ball {
  var h
  var v
  init Down where 1 <= h <= 1.1 and -0.1 <= v <= 0
  mode Down { domain h >= 0 and v <= 0; flow { h' = v; v' = -1 + v^2 / 9 }
    urgent edge bounce: -> Up when h == 0 and v < 0 do v := -0.5 * v }
  mode Up { domain h >= 0 and v >= 0; flow { h' = v; v' = -1 - v^2 / 9 }
    urgent edge turn: -> Down when v == 0 }
}
property low on Ball { within 2.5, 5 jumps; always h <= 1.2 }
"""
SWING = """spec "Swing" version "1.0" unitless
param k in [1, 1.1]
automaton Swing {
  var x; var y
  init M where 0.9 <= x <= 1 and 0 <= y <= 0.1
  mode M { flow { x' = y; y' = -k * sin(x) } }
}
property bound on Swing { within 4; always x <= 1.2 }
"""
ASSUMING = SWING.replace("within 4; always x <= 1.2", "assume k <= 1.05 and x <= 1.1; within 4; always x <= 1.05")


def proved(text: str, tmp_path: Path) -> tuple[Spec, Evidence]:
    path = tmp_path / "model.ha"
    path.write_text(text)
    read, _ = load(str(path))
    assert read is not None
    spec, _ = elaborate(read.tree, read.files)
    assert spec is not None
    evidence = decide_all(spec)[spec.claims[0].name]
    assert isinstance(evidence.verdict, Proved) and evidence.flowpipe is not None
    return spec, evidence


def narrowed(flowpipe: Any, share: float) -> Any:
    """The same with every box narrower about its middle by a share."""
    made = copy.deepcopy(flowpipe)
    for piece in made["pieces"]:
        for step in piece["steps"]:
            for k in range(2, len(step), 2):
                middle, half = (step[k] + step[k + 1]) / 2, (step[k + 1] - step[k]) / 2 * (1 - share)
                step[k], step[k + 1] = middle - half, middle + half
    return made


@pytest.mark.parametrize("text", [BALL, SWING, ASSUMING])
def test_a_sound_flowpipe_raises_no_alarm_and_a_narrow_one_does(text: str, tmp_path: Path) -> None:
    spec, evidence = proved(text, tmp_path)
    sound = Beside(spec, spec.automata[0], spec.claims[0], evidence.flowpipe)
    assert sound.disagreement(60.0, runs=200) is None and sound.checked == 200
    planted = Beside(spec, spec.automata[0], spec.claims[0], narrowed(evidence.flowpipe, 0.01))
    found = planted.disagreement(60.0, runs=400)
    assert found is not None and found.is_certain, found


def test_a_planted_engine_ends_in_a_fault_and_no_proof(tmp_path: Path) -> None:
    spec, evidence = proved(BALL, tmp_path)
    name = spec.claims[0].name
    wrong = replace(evidence, flowpipe=narrowed(evidence.flowpipe, 0.01))
    solved = side.beside(spec, Solved({name: wrong}, {name: (30.0, 30.0)}))
    assert [f for f in solved.faults if "HA705" in f]
    assert isinstance(solved.evidence[name].verdict, Unknown)
    fine = side.beside(spec, Solved({name: evidence}, {name: (10.0, 10.0)}))
    assert not fine.faults and fine.evidence[name] == evidence


def test_a_false_claim_is_contradicted_by_a_certified_run(tmp_path: Path) -> None:
    spec, _ = proved(BALL, tmp_path)
    false = replace(spec.claims[0], goals=(replace(spec.claims[0].goals[0], condition=_below(spec)),))
    found = Beside(spec, spec.automata[0], false).disagreement(60.0, runs=50)
    assert found is not None and found.is_certain


def _below(spec: Spec) -> Any:
    condition = spec.claims[0].goals[0].condition
    left, right = condition.children
    return replace(condition, args=(left, replace(right, args=(right.args[0] / 2,))))


def test_the_report_says_that_no_runs_were_simulated(tmp_path: Path) -> None:
    (tmp_path / "ball.ha").write_text(BALL)
    options = Options(None, Fraction(60), 1, tmp_path / "r", False, None, Trust.ENCLOSED, crosscheck=False)
    assert check(str(tmp_path / "ball.ha"), options).report.options["crosscheck"] == "off"
    assert "crosscheck" not in check(str(tmp_path / "ball.ha"), replace(options, crosscheck=True)).report.options
