"""Claims about automata with flows and jumps: margins over several modes, runs that are stuck, no jumps at all."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

from haverify.analyses.portfolio import decide_all
from haverify.evidence.evidence import Evidence
from haverify.evidence.verdict import Proved, Unknown
from haverify.run.examine import read

# x is 0 to 1 m in First and 0 to 2 m in Second, whose domain watches more.
TWO_MODES = """
automaton A {
  var x: m
  var y: m
  init First where x == 0 m and y == 1 m
  mode First { flow { x' = 1 m/s; y' = -y / 1 s }; urgent edge go: -> Second when x >= 1 m do x := 0 m }
  mode Second { domain x <= 10 m and x >= -1 m; flow { x' = 1 m/s; y' = -y / 1 s } }
}
"""
STUCK = """
automaton A {
  var x: s
  var y
  init Run where x == 0 s and y == 1
  mode Run { domain x <= 1 s; flow { x' = 1; y' = -y * 1 Hz }; edge never: -> Run when y > 3 }
}
"""


def decided(folder: Path, automaton: str, claim: str) -> Evidence:
    path = folder / "a.ha"
    path.write_text(f'spec "a" version "1.0"\n{automaton}\nproperty p on A {{ {claim} }}\n', encoding="utf-8")
    spec, _, found = read(str(path))
    assert spec is not None, found
    return decide_all(spec)["p"]


def test_a_margin_is_that_of_the_same_bound_in_all_modes(tmp_path: Path) -> None:
    verdict = decided(tmp_path, TWO_MODES, "within 3 s; always x <= 2.5 m").verdict
    assert isinstance(verdict, Proved)
    assert verdict.margin is not None
    assert Fraction(499, 1000) < verdict.margin.low <= Fraction(1, 2)


def test_a_landing_that_nothing_follows_leaves_the_margin_open(tmp_path: Path) -> None:
    verdict = decided(tmp_path, TWO_MODES, "within 1 jumps; always x <= 2.5 m").verdict
    assert isinstance(verdict, Proved)
    assert verdict.margin is None


def test_a_run_that_is_stuck_keeps_a_signal_from_being_proved(tmp_path: Path) -> None:
    verdict = decided(tmp_path, STUCK, "stl globally[0 s, 5 s] y >= 0").verdict
    assert isinstance(verdict, Unknown)
    assert isinstance(decided(tmp_path, STUCK, "stl globally[0 s, 0.9 s] y >= 0").verdict, Proved)
    assert isinstance(decided(tmp_path, STUCK, "within 5 s; always y >= 0").verdict, Proved)


def test_a_horizon_of_no_jumps_is_told(tmp_path: Path) -> None:
    verdict = decided(tmp_path, STUCK, "within 0 jumps; always y >= 0").verdict
    assert isinstance(verdict, (Proved, Unknown))
