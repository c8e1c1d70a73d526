"""Claims about flows decided by flowpipes: verdicts, runs, margins, and what is left open and why."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

import pytest

from haverify.analyses.portfolio import decide_all
from haverify.diagnostics.codes import severity
from haverify.diagnostics.diagnostic import Severity
from haverify.evidence.evidence import Evidence
from haverify.evidence.verdict import Proved, Refuted, Unknown
from haverify.model.spec import Spec
from haverify.run.examine import read

Decide = Callable[[str, str], Evidence]

VAN_DER_POL = """
automaton A {
  var x
  var y
  init Run where 1.25 <= x <= 1.55 and 2.35 <= y <= 2.45
  mode Run { flow { x' = y; y' = (1 - x^2) * y - x } }
}
"""
ONE = "automaton A {{ var x; init R where x == 1; mode R {{ {} }} }}"
ESCAPE = ONE.format("flow { x' = x^2 }")
PENDULUM = """
param damping in [0.1, 0.3]
automaton A {
  var angle
  var rate
  init Swing where angle in [0.9, 1] and rate == 0
  mode Swing { flow { angle' = rate; rate' = -sin(angle) - damping * rate } }
}
"""


@pytest.fixture
def spec_of(tmp_path: Path) -> Callable[[str], Spec]:
    def make(text: str) -> Spec:
        path = tmp_path / "flow.ha"
        path.write_text(text, encoding="utf-8")
        spec, _, found = read(str(path))
        assert spec is not None
        assert not any(severity(d) is Severity.ERROR for d in found), found
        return spec

    return make


@pytest.fixture
def decided(spec_of: Callable[[str], Spec]) -> Callable[[str, str], Evidence]:
    def decide(text: str, claim: str) -> Evidence:
        return decide_all(spec_of(f'spec "S" version "1.0" unitless\n{text}\n{claim}\n'))["p"]

    return decide


@pytest.mark.parametrize(
    ("claim", "verdict"),
    [
        ("within 7; always y <= 2.75", Proved),
        ("within 7; always y <= 2.6", Refuted),
        ("can reach x <= -2 within 7", Proved),
        ("can reach x >= 3 within 7", Refuted),
        ("always during [5, 7] abs(y) <= 2.9", Proved),
        ("within 7; always x <= 1 implies y <= 1", Refuted),
        ("within 1; always y < 2.46 or x < 1.6", Proved),
        ("within 0; always y <= 2.46", Proved),
    ],
)
def test_van_der_pol(decided: Decide, claim: str, verdict: type) -> None:
    found = decided(VAN_DER_POL, f"property p on A {{ {claim} }}").verdict
    assert isinstance(found, verdict), found


def test_a_pendulum_with_an_uncertain_damping(decided: Decide) -> None:
    assert isinstance(decided(PENDULUM, "property p on A { within 5; always abs(angle) <= 1.001 }").verdict, Proved)
    found = decided(PENDULUM, "property p on A { within 5; always angle >= -0.5 }")
    assert isinstance(found.verdict, Refuted)
    assert found.run is not None
    params = dict(found.run.params)
    assert Fraction("0.1") <= params["damping"] <= Fraction("0.3")


def test_the_run_that_refutes_names_an_instant_after_the_violation(decided: Decide) -> None:
    run = decided("automaton A { var x; init R where x == 1; mode R { flow { x' = x } } }",
                  "property p on A { within 2; always x <= 2 }").run  # fmt: skip
    assert run is not None
    assert Fraction("0.6931") < run.last < 1  # log 2


def test_a_margin_is_bounded_from_both_sides(spec_of: Callable[[str], Spec]) -> None:
    text = (
        'spec "S" version "1.0"\nautomaton A { var x: m; init R where x == 1 m; mode R { flow { x\' = -x * 1 Hz } } }\n'
    )
    found = decide_all(spec_of(text + "property p on A { within 1 s; always x >= 0.3 m }"))["p"].verdict
    assert isinstance(found, Proved)
    assert found.margin is not None
    exact = Fraction("0.367879441171442321") - Fraction("0.3")  # exp(-1)
    assert found.margin.low <= exact <= found.margin.high
    assert found.margin.high - found.margin.low < Fraction("0.01")


@pytest.mark.parametrize(
    ("text", "claim", "words"),
    [
        (VAN_DER_POL.replace("x' = y", "x' = y + 0 * time"), "always y <= 2.75", "within"),
        (ONE.format("terminal; flow { x' = x }"), "always during [1, 2] x >= 2.7", "terminal"),
        (
            "automaton A { var x; init R where x in [0, 1] and x * x < 0; mode R { flow { x' = x } } }",
            "within 1; always x <= 9",
            "admissible",
        ),
        (ONE.format("flow { x' = x }").replace("var x", "var x in [0, 2]"), "within 2; always x <= 9", ""),
    ],
)  # fmt: skip
def test_what_is_left_open(decided: Decide, text: str, claim: str, words: str) -> None:
    found = decided(text, f"property p on A {{ {claim} }}").verdict
    assert isinstance(found, Unknown), found
    assert words in found.reason


def test_a_claim_shown_up_to_some_instant_says_so(decided: Decide) -> None:
    text = (
        ESCAPE.replace("x' = x^2", "x' = x^2; y' = sin(y)")
        .replace("var x", "var x, y")
        .replace("x == 1", "x == 1 and y == 1")
    )
    found = decided(text, "property p on A { within 2; always y <= 3.1 }").verdict
    assert isinstance(found, Unknown)
    assert "0.99" in found.reached


def test_what_happens_before_an_escape_counts(decided: Decide) -> None:
    assert isinstance(decided(ESCAPE, "property p on A { within 2; always x <= 1000000 }").verdict, Refuted)


def test_nothing_is_refuted_by_a_run_that_left_its_domain(decided: Decide) -> None:
    text = "automaton A { var x; init R where x == 1; mode R { domain x <= 1.5; flow { x' = x } } }"
    found = decided(text, "property p on A { within 2; always x <= 2 }").verdict
    assert not isinstance(found, Refuted)


def test_fifty_variables_are_followed(decided: Decide) -> None:
    ring = """
enum Place = 1..50
automaton A {
  var x for i in Place
  init R where 0.9 <= x[1] <= 1 and (forall i in Place: i == 1 or x[i] == 1)
  mode R { flow { x[i]' = sin(x[if i == 50 then 1 else i + 1]) - x[i] for i in Place } }
}
"""
    assert isinstance(decided(ring, "property p on A { within 0.1; always x[1] <= 1.01 }").verdict, Proved)
