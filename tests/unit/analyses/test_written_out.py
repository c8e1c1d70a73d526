"""Discrete variables and functions with corners beside flows: verdicts, and what is shown of runs."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import pytest

from haverify.analyses.hybrid.decide import decide_flow
from haverify.analyses.hybrid.model import hybrid_model
from haverify.analyses.portfolio import contexts_of
from haverify.evidence.evidence import Evidence
from haverify.evidence.verdict import Proved, Refuted
from haverify.model.spec import Spec
from haverify.obligations.translate import OutsideFragmentError
from haverify.run.examine import read

Q = Fraction

KICKS = """
enum Count = 0..2
enum Colour { red, green }
automaton A {
  var x
  var n: Count
  var on: bool
  var c: Colour
  let speed = if on then 1 else 0.5
  init P where 0 <= x <= 0.1 with { n := 0; on := true; c := red }
  mode P { flow { x' = speed } }
  urgent edge kick: P -> P when x >= 1 and n < 2 do {
    x := 0; n := n + 1; on := not on; c := if n == 0 then green else red
  }
}
"""
CHOICE = """
automaton A {
  var x
  var high: bool
  init P where 0 <= x <= 1 with { high := false }
  mode P { domain x <= 2; flow { x' = 1 } }
  mode B { flow { x' = if high then -1 else 1 } }
  urgent edge go: P -> B when x >= 2 do { high := x >= 1; x := 0 }
}
"""
DRAG = """
automaton A {
  var h
  var v
  init Fly where h == 0 and 4 <= v <= 5
  mode Fly { flow { h' = v; v' = -9.81 - 0.1 * v * abs(v) } }
}
"""
ANKLE = """
automaton A {
  var th
  var w
  let torque = clamp(4 * th + 2 * w, -1, 1)
  init Stand where 0.2 <= th <= 0.25 and -0.1 <= w <= 0
  mode Stand { flow { th' = w; w' = 2 * th - 3 * torque } }
}
"""
SWITCH = """
automaton A {
  var x
  init P where 1 <= x <= 1.1
  mode P { flow { x' = if x <= 0.5 then -x else BRANCH } }
  edge hop: P -> P when x <= 0.9 do x := max(min(2 * x, 1.2), abs(x - 1))
}
"""


def specified(folder: Path, text: str, claim: str) -> Spec:
    path = folder / "s.ha"
    path.write_text(f'spec "s" version "1.0" unitless\n{text}\nproperty p on A {{ {claim} }}\n')
    spec, _, found = read(str(path))
    assert spec is not None, [d.message for d in found]
    return spec


def decided(folder: Path, text: str, claim: str) -> Evidence:
    spec = specified(folder, text, claim)
    context = contexts_of(spec).get("A")
    assert context is not None
    return decide_flow(spec, context.automaton, spec.claims[0], None)


@pytest.mark.parametrize(
    ("text", "claim", "verdict"),
    [
        (KICKS, "within 4; always x <= 1 or n == 2", Proved),
        (KICKS, "within 4; always (on implies c is red or n == 2) and (n == 1 implies c is green)", Proved),
        (KICKS, "within 4; always jumped implies n == pre(n) + 1 and on != pre(on)", Proved),
        (KICKS, "within 4; always n <= 1", Refuted),
        (KICKS, "within 4; always speed >= 0.6", Refuted),
        (KICKS, "can reach n == 2 and not on within 4", Refuted),
        (KICKS, "reach n == 2 within 3.1", Proved),
        (KICKS, "reach n == 2 within 2.8", Refuted),
        (CHOICE, "within 3; always not high implies x >= 0", Proved),
        (CHOICE, "within 3; always at(B) implies x <= 0.01", Proved),
        (DRAG, "within 2; always h <= 1.3", Proved),
        (DRAG, "within 2; always h <= 0.9", Refuted),
        (DRAG, "reach h <= 0 within 2", Proved),
        (DRAG, "within 2; always abs(v) <= 13 and h + abs(h) <= 2.6 and max(h, v, 0) <= 5", Proved),
        (DRAG, "within 2; always min(h, v) >= -4", Refuted),
        (ANKLE, "within 3; always abs(th) + abs(w) <= 0.6 and torque <= 1", Proved),
        (ANKLE, "within 3; always th <= 0.22", Refuted),
        (SWITCH.replace("BRANCH", "x - 1"), "within 1; always jumped implies x >= pre(x)", Proved),
    ],
)  # fmt: skip
def test_verdicts(tmp_path: Path, text: str, claim: str, verdict: type) -> None:
    assert isinstance(decided(tmp_path, text, claim).verdict, verdict)


def test_a_run_is_told_with_modes_edges_and_discrete_values_as_written(tmp_path: Path) -> None:
    run = decided(tmp_path, KICKS, "within 4; always n <= 1").run
    assert run is not None
    assert run.mode == "P"
    assert [n for n, _ in run.values] == ["x", "n", "on", "c"]
    assert dict(run.values)["on"] == 1
    assert [s.edge for s in run.steps] == [0, 0]
    assert [{n: low for n, low, _ in p.values}["n"] for p in run.path] == [0, 1, 2, 2]
    assert {p.mode for p in run.path} == {"P"}


def test_a_change_of_side_is_no_jump(tmp_path: Path) -> None:
    evidence = decided(tmp_path, DRAG, "within 2; always v >= -3")
    assert evidence.run is not None
    assert evidence.run.steps == ()
    assert evidence.run.last > Q(1, 2)
    assert isinstance(decided(tmp_path, DRAG, "within 2; always not jumped").verdict, Proved)
    assert evidence.flowpipe is not None
    assert {p["jumps"] for p in evidence.flowpipe["pieces"]} == {0}


@pytest.mark.parametrize(
    ("text", "claim", "words"),
    [
        (SWITCH.replace("BRANCH", "x"), "within 1; always x <= 3", "agree"),
        (KICKS.replace("n < 2", "n < 3"), "within 4; always x <= 9", "its type does not have"),
        (KICKS.replace("n: Count", "n: Count in [0, 1]"), "within 4; always n <= 1", "declared range"),
        (DRAG, "within 2 jumps; always v <= 9", "jumps alone"),
        (DRAG.replace("abs(v)", "+".join(f"abs(v - {k})" for k in range(9))), "within 1; always v <= 9", "sides"),
    ],
)
def test_what_is_outside_says_so(tmp_path: Path, text: str, claim: str, words: str) -> None:
    with pytest.raises(OutsideFragmentError, match=words):
        decided(tmp_path, text, claim)


def test_starts_are_cut_to_their_side(tmp_path: Path) -> None:
    spec = specified(tmp_path, ANKLE, "within 1; always th <= 1")
    model = hybrid_model(spec, spec.automata[0], [])
    boxes = {model.modes[s.mode].name: s.box[:2] for s in model.starts}
    assert sorted(boxes.values()) == [((Q(1, 5), Q(1, 4)), (Q(-1, 10), Q(0))), ((Q(1, 4), Q(1, 4)), (Q(0), Q(0)))]
