"""Invariants of several modes that are found: a ball, a thermostat, tanks, a block; nothing for what is false."""

from fractions import Fraction
from pathlib import Path

import pytest

from haverify.analyses.induction.decide import decide_invariant
from haverify.analyses.induction.invented import hybrid_of, invent
from haverify.analyses.synthesis.joint import SHAPES, joint_barrier
from haverify.analyses.synthesis.reached import frame_of, reached
from haverify.elaborate.elaborate import elaborate
from haverify.evidence.verdict import Proved
from haverify.model.core import to_core
from haverify.model.spec import Spec
from haverify.obligations.induction import Induction
from haverify.run.load import load

BALL = """
param r in [0, 1]
automaton Ball {
  var x
  var v
  init Fly where 1 <= x <= 2 and v == 0
  mode Fly {
    domain x >= 0
    flow { x' = v; v' = -9.81 }
    edge hit: -> Fly when x == 0 and v <= 0 do v := -r * v
  }
}
"""
HEATER = """
automaton Heater {
  var T
  init On where 19 <= T <= 20
  mode On { domain T <= 22; flow { T' = 5 - T / 10 }; edge off: -> Off when T >= 21 }
  mode Off { domain T >= 18; flow { T' = -T / 10 }; edge on: -> On when T <= 19 }
}
"""
TANKS = """
automaton Tanks {
  var x
  var y
  init Fill where 0 <= x <= 1 and 0 <= y <= 1
  mode Fill { domain x <= 4; flow { x' = 2 - x / 4; y' = x / 4 - y / 2 }; edge stop: -> Drain when x >= 3 }
  mode Drain { domain x >= 1; flow { x' = -x / 4; y' = x / 4 - y / 2 }; edge go: -> Fill when x <= 2 }
}
"""
BLOCK = """
param r in [0, 1]
automaton Block {
  var x
  var v
  init Left where -1 <= x <= 0 and v^2 - (1 + x)^2 <= -1/2
  mode Left { domain x <= 0; flow { x' = v; v' = 1 + x }; edge over: -> Right when x == 0 and v >= 0 do v := r * v }
  mode Right { domain x >= 0; flow { x' = v; v' = x - 1 }; edge back: -> Left when x == 0 and v <= 0 do v := r * v }
}
"""


def spec_of(automaton: str, name: str, claim: str, folder: Path) -> Spec:
    path = folder / "spec.ha"
    path.write_text(f'spec "Modes" version "1.0" unitless\n{automaton}\nproperty p on {name} {{ always {claim} }}\n')
    loaded, _ = load(path)
    assert loaded is not None
    spec, _ = elaborate(loaded.tree, loaded.files)
    assert spec is not None
    return spec


def induction_of(spec: Spec) -> Induction:
    found = Induction(spec, spec.automata[0], spec.claims[0], spec.claims[0].goals[0])
    found.check()
    return found


TRUE = [
    (BALL, "Ball", "x <= 2"),
    (HEATER, "Heater", "18 <= T <= 22"),
]


@pytest.mark.parametrize(("automaton", "name", "claim"), TRUE)
def test_an_invariant_of_all_modes_is_found(automaton: str, name: str, claim: str, tmp_path: Path) -> None:
    spec = spec_of(automaton, name, claim, tmp_path)
    found = decide_invariant(spec, spec.automata[0], spec.claims[0], to_core(spec))
    assert isinstance(found.verdict, Proved)
    (entry,) = found.certificate["goals"] if found.certificate else ()
    assert set(entry["modes"]) == {m.name for m in spec.automata[0].modes}


@pytest.mark.parametrize(
    ("automaton", "name", "claim"),
    [
        (BALL, "Ball", "x <= 19/10"),
        (HEATER, "Heater", "T <= 20"),
        (TANKS, "Tanks", "y <= 1"),
        (BLOCK, "Block", "x <= 0"),
    ],
)
def test_nothing_is_found_for_what_is_false(automaton: str, name: str, claim: str, tmp_path: Path) -> None:
    spec = spec_of(automaton, name, claim, tmp_path)
    assert invent(induction_of(spec), 5.0) is None
    found = decide_invariant(spec, spec.automata[0], spec.claims[0], to_core(spec), Fraction(1, 10))
    assert not isinstance(found.verdict, Proved)


def test_sampled_runs_go_through_all_modes(tmp_path: Path) -> None:
    """Starts are in On alone."""
    hybrid = hybrid_of(induction_of(spec_of(HEATER, "Heater", "T <= 22", tmp_path)))
    drawn = reached(hybrid)
    assert all(len(samples.states) for samples in drawn.values())
    assert drawn["Off"].states[:, 0].min() < 18.5


def test_a_joint_barrier(tmp_path: Path) -> None:
    """What comes out is only a guess; here it is a good one: above 0 where the claim fails, below at the starts."""
    hybrid = hybrid_of(induction_of(spec_of(HEATER, "Heater", "T <= 30", tmp_path)))
    frame = frame_of(reached(hybrid))
    found = next(p for shape in SHAPES if (p := joint_barrier(hybrid, {"On": [], "Off": []}, frame, shape, 5.0)))
    assert found["Off"].value({"T": Fraction(31)}) > 0
    assert found["On"].value({"T": Fraction(39, 2)}) < 0
