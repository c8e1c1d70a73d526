"""Claims about automata with flows and jumps: verdicts, runs, margins, options, and what is left open and why."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

import pytest

from haverify.analyses.hybrid.decide import decide_flow
from haverify.evidence.evidence import Evidence
from haverify.evidence.verdict import Proved, Refuted, Unknown
from haverify.model.core import to_core
from haverify.obligations.translate import OutsideFragmentError
from haverify.run.examine import read

Decide = Callable[[str, str], Evidence]

BALL = """
const g = 9.75
automaton A {
  var h
  var v
  init Fall where 1 <= h <= 1.2 and v == 0
  mode Fall {
    domain h >= 0
    flow { h' = v; v' = -g }
    urgent edge bounce: -> Fall when h <= 0 and v < 0 do v := -0.8 * v
  }
}
"""
BLOCK = """
param r in [0.78, 0.8]
automaton A {
  var x1 in [-2, 2]
  var x2 in [-10, 10]
  init Left where -0.52 <= x1 <= -0.48 and -0.01 <= x2 <= 0.01
  mode Left {
    domain x1 <= 0
    flow { x1' = x2; x2' = sin(0.2 * (1 + x1)) / 0.2 }
    edge right: -> Right when x1 == 0 and x2 >= 0 do x2 := r * x2
  }
  mode Right {
    domain x1 >= 0
    flow { x1' = x2; x2' = -sin(0.2 * (1 - x1)) / 0.2 }
    edge left: -> Left when x1 == 0 and x2 <= 0 do x2 := r * x2
  }
}
"""
HEATER = """
automaton A {
  var x
  init On where 19.5 <= x <= 20
  mode On { domain x <= 22; flow { x' = 4 - 0.1 * x }; edge off: -> Off when x >= 21 }
  mode Off { domain x >= 18; flow { x' = -0.1 * x }; edge on: -> On when x <= 19 }
}
"""
THROWN = """
automaton A {
  var h
  var v
  init Up where h == 0 and 3.9 <= v <= 4.1
  mode Up {
    domain h >= 0
    flow { h' = v; v' = -8 }
    urgent edge hit: -> Up when h >= 1 and v >= 0 do v := -v / 2
  }
}
"""
STOPPED = """
automaton A {
  var x
  init Go where 0.5 <= x <= 0.6
  mode Go {
    flow { x' = x }
    urgent edge stop: -> Rest when x >= 1
  }
  mode Rest { terminal; flow { x' = 0 } }
}
"""

CROWDED = """
automaton A {
  var x
  init On where x == 0
  mode On { domain x <= 1; flow { x' = 1 + x } }
  mode Off { flow { x' = 0 } }
  mode Lost { flow { x' = 0 } }
EDGES
  edge last: On -> Lost when x >= 1
}
"""


@pytest.fixture
def decided(tmp_path: Path) -> Decide:
    def decide(text: str, claim: str) -> Evidence:
        path = tmp_path / "s.ha"
        head = 'spec "S" version "1.0"' + ("" if " m/s" in text else " unitless")
        path.write_text(f"{head}\n{text}\n{claim}\n", encoding="utf-8")
        spec = read(str(path))[0]
        assert spec is not None
        automaton = next(a for a in spec.automata if a.name == "A")
        return decide_flow(spec, automaton, spec.claims[0], to_core(spec))

    return decide


@pytest.mark.parametrize(
    ("text", "claim", "verdict"),
    [
        (BALL, "within 1.5; always h <= 1.2", Proved),
        (BALL, "within 1.5; always h < 1.2", Unknown),
        (BALL, "within 1.5; always abs(v) <= 4.9", Proved),
        (BALL, "within 1.5; always v <= 3.8", Refuted),
        (BALL, "within 1.5; always jumped implies v <= 3.88", Proved),
        (BALL, "within 1.5; always jumped implies v <= -0.7 * pre(v)", Refuted),
        (BALL, "within 2 jumps; always jumped implies v == -0.8 * pre(v) or h > 1", Unknown),
        (BALL, "within 2 jumps; always jump(bounce) implies v <= 3.88", Proved),
        (BALL, "reach jumped within 0.5", Proved),
        (BALL, "reach jumped within 0.45", Refuted),
        (BALL, "can reach h >= 0.5 and v > 0 within 1", Proved),
        (BALL, "can reach h >= 0.8 and v > 0 within 1.3", Refuted),
        (BLOCK, "within 4; always abs(x1) <= 0.53", Proved),
        (BLOCK, "within 4; always x1 <= 0.2", Refuted),
        (BLOCK, "reach at(Right) within 1.5", Proved),
        (BLOCK, "stl eventually[1, 2] x1 >= 0.1", Proved),
        (BLOCK, "stl globally[1.5, 2] at(Right)", Proved),
        (HEATER, "within 2; always 17.9 <= x <= 22.1", Proved),
        (HEATER, "within 2; always x <= 20.8", Refuted),
        (HEATER, "can reach at(Off) and x < 18.5 within 1", Refuted),
        # A start on the border of the domain is one; thrown up at 3.9 to 4.1 it comes 0.95 to 1.05 high.
        (THROWN, "within 0.9; never jump(hit)", Refuted),
        (THROWN, "can reach jump(hit) within 0.9", Proved),
        (THROWN, "reach jump(hit) within 0.9", Refuted),
        # A run that ends in a terminal mode has met what holds there.
        (STOPPED, "reach at(Rest) within 0.7", Proved),
        (STOPPED, "reach at(Rest) within 0.5", Refuted),
        (BALL.replace("domain h >= 0", "domain h >= 0 or v > 0"), "within 1; always h <= 1.2", Proved),
        (BALL.replace("domain h >= 0", "domain h >= 0 or v > 0"), "within 1; always v <= 3.8", Refuted),
        (BALL.replace("domain h >= 0", "domain h >= 0 and (h >= 0.5 or v < -9)"), "within 1; always v <= 2", Proved),
        (BALL.replace("domain h >= 0", "domain h >= 0 and (h >= 0.5 or v < -9)"), "reach jumped within 1", Unknown),
    ],
)  # fmt: skip
def test_verdicts(decided: Decide, text: str, claim: str, verdict: type) -> None:
    found = decided(text, f"property p on A {{ {claim} }}").verdict
    assert isinstance(found, verdict), found


def test_the_run_that_refutes_names_its_jumps(decided: Decide) -> None:
    run = decided(BLOCK, "property p on A { within 4; always x1 <= 0.2 }").run
    assert run is not None
    assert run.mode == "Left" and [s.edge for s in run.steps] == [0]
    start, landing, end = run.path
    assert (start.mode, landing.mode, landing.edge, end.mode) == ("Left", "Right", "right", "Right")
    assert landing.time[0] <= float(run.steps[0].dwell) <= landing.time[1]
    values = {n: (low, high) for n, low, high in end.values}
    assert values["x1"][1] >= 0.2 and landing.time[1] <= end.time[1]


FALL = """
automaton A {
  var h: m
  var v: m/s
  init Fall where 1 m <= h <= 1.2 m and v == 0 m/s
  mode Fall {
    domain h >= 0 m
    flow { h' = v; v' = -9.75 m/s^2 }
    urgent edge bounce: -> Fall when h <= 0 m and v < 0 m/s do v := -0.8 * v
  }
}
"""


def test_a_margin_is_at_most_the_true_one(decided: Decide) -> None:
    found = decided(FALL, "property p on A { within 0.9 s; always v >= -5 m/s }").verdict
    assert isinstance(found, Proved) and found.margin is not None
    true = Fraction(5 - (2 * 9.75 * 1.2) ** 0.5)
    assert true - Fraction("0.01") <= found.margin.low <= true


@pytest.mark.parametrize(
    ("text", "claim", "words"),
    [
        (BALL, "within 1; always h <= 2; method taylor(order = 1)", "order = 1"),
        (BALL, "within 1; always h <= 2; method taylor(cuts = 99)", "cuts = 99"),
        (BALL.replace("v := -0.8 * v", "v in [3, 2]"), "can reach v > 1 within 1", "there is none"),
        (BALL, "within 1; always h <= 2; method taylor(digits = 3)", "no option `digits`"),
    ],
)  # fmt: skip
def test_what_is_outside_says_so(decided: Decide, text: str, claim: str, words: str) -> None:
    with pytest.raises(OutsideFragmentError, match=words):
        decided(text, f"property p on A {{ {claim} }}")


@pytest.mark.parametrize(
    ("text", "claim", "words"),
    [
        (BALL, "within 1.2, 1 jumps; always h <= 1.3", "more than 1 times"),
        (BALL.replace("var v", "var v in [-4, 4]"), "within 1; always h <= 1.3", "declared ranges"),
        (BALL.replace("v == 0", "v == 0 and h * h < 0"), "within 1; always h <= 1.3", "admissible"),
    ],
)  # fmt: skip
def test_what_is_left_open_says_why(decided: Decide, text: str, claim: str, words: str) -> None:
    found = decided(text, f"property p on A {{ {claim} }}").verdict
    assert isinstance(found, Unknown)
    assert words in found.reason


def test_a_run_that_is_stuck_is_no_proof_that_something_is_reached(decided: Decide) -> None:
    stuck = BALL.replace("h <= 0 and v < 0", "h <= 0 and v < -10")
    found = decided(stuck, "property p on A { reach jumped or h > 5 within 2 }").verdict
    assert not isinstance(found, Proved)


def test_an_assumed_bound_of_a_param_is_kept_by_its_starts_alone(decided: Decide) -> None:
    """0.3 is no float: enclosures of a pace that starts there come a little below it."""
    head = 'spec "t" version "1.0" unitless\nparam p in [0, 1]\n@allow(HA401, reason = "one way")\nautomaton A {\n'
    modes = (
        "  mode M { domain h <= 1; flow { h' = p }; urgent edge go: -> N when h == 1 }\n  mode N { flow { h' = 0 } }\n"
    )
    text = head + "  var h\n  init M where h == 0\n" + modes + "}\n"
    claim = "property q on A {{ assume p >= 0.3; within {}; reach at(N) within {} }}"
    assert isinstance(decided(text, claim.format(4, 4)).verdict, Proved)
    assert isinstance(decided(text, claim.format(3, 3)).verdict, Refuted)


@pytest.mark.parametrize("edges", [1, 20])
def test_jumps_that_nobody_follows_any_more_may_miss_the_goal(decided: Decide, edges: int) -> None:
    """All early jumps meet it, and fill the tree; the last one, which a run may wait for, does not."""
    text = CROWDED.replace("EDGES", "\n".join(f"  edge off{k}: On -> Off" for k in range(edges)))
    assert isinstance(decided(text, "property p on A { reach at(Off) within 0.8 }").verdict, (Unknown, Refuted))
    assert isinstance(
        decided(text, "property p on A { reach x >= 0.9 or at(Off) within 0.8 }").verdict, (Unknown, Proved)
    )
