"""Periodic orbits that are proved: known periods and multipliers, what is refused, refuted and left open."""

from __future__ import annotations

import math
import re
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from haverify.analyses.orbits.decide import decide_cycle
from haverify.analyses.orbits.linear import discs
from haverify.evidence.evidence import Evidence
from haverify.evidence.verdict import Proved, Refuted, Unknown
from haverify.maths.interval import Interval
from haverify.model.core import to_core
from haverify.obligations.translate import OutsideFragmentError
from haverify.run.examine import read

Q = Fraction
ROOT = Path(__file__).parents[3]
VAN_DER_POL = "automaton A { var x; var y; init M where x == 2 and y == 0; mode M { flow { x' = y; y' = F } } }"
VAN_DER_POL = VAN_DER_POL.replace("F", "(1 - x^2) * y - x")
# The unit circle, with r' = K r (r^2 - 1) and one turn in 2 pi: its multiplier is exp(4 pi K).
CIRCLE = """automaton A {
  var x; var y
  init M where x == 1 and y == 0
  mode M { flow { x' = -y + K * x * (x^2 + y^2 - 1); y' = x + K * y * (x^2 + y^2 - 1) } }
}"""
# A circle cut in two: the same, and on the way over y == 0 upwards x is moved from 2 to 1 times as far from it.
KICKED = """automaton A {
  var x; var y
  init Up where x == 1 and y == 0
  mode Up { domain y >= 0; flow { x' = -y; y' = x }; edge down: -> Down when y == 0 and x < 0 }
  mode Down { domain y <= 0; flow { x' = -y; y' = x }; edge up: -> Up when y == 0 and x > 0 do x := 1 + K * (x - 1) }
}"""
TICK = """automaton A {
  var c; var x
  init M with { c := 0; x := 0 }
  mode M { domain c <= 1; flow { c' = 1; x' = -x }; urgent edge tick: -> M when c == 1 do { c := 0; x := x / 2 + 1 } }
}"""


def spec_of(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "a.ha"
    path.write_text('spec "S" version "1.0" unitless\n' + text)
    return path


def decided(path: Path, name: str = "p") -> Evidence:
    spec, _, found = read(str(path))
    assert spec is not None and not [d for d in found if d.severity == "error"], found
    claim = next(c for c in spec.claims if c.name == name)
    automaton = next(a for a in spec.automata if a.name == claim.on)
    return decide_cycle(spec, automaton, claim, to_core(spec))


def claimed(tmp_path: Path, automaton: str, claim: str, k: str = "0") -> Evidence:
    text = re.sub(r"\bK\b", k, automaton)
    return decided(spec_of(tmp_path, f"{text}\nproperty p on A {{ {claim} }}"))


def period_of(e: Evidence) -> tuple[Q, Q]:
    """The period of the text; that of a certificate which can be checked is less exact, and holds it."""
    found = re.search(r"period ([\d.]+) \(\+-(\S+)\)", e.notes[0])
    assert found is not None and e.certificate is not None
    (low, high), (middle, off) = map(Q, e.certificate["goals"][0]["period"]), map(Q, found.groups())
    assert low <= middle + off and middle - off <= high
    return middle - off, middle + off


def multipliers(e: Evidence) -> list[tuple[float, float]]:
    """Real multipliers of the text, and how far each is off at most."""
    found = re.findall(r"(-?[\d.]+) \(\+-(\S+)\)", e.notes[0].split("multipliers")[1].split(", passing")[0])
    return [(float(m), float(r)) for m, r in found]


# The period of van der Pol's oscillator to fifteen digits, as in the tests of the simulator.
def test_van_der_pol(tmp_path: Path) -> None:
    e = claimed(tmp_path, VAN_DER_POL, "cycle through y == 0 and 1.9 <= x <= 2.1 within 7 attracting")
    low, high = period_of(e)
    assert isinstance(e.verdict, Proved) and low < Q("6.66328685932313") < high and high - low < Q(1, 10**10)
    [(m, r)] = multipliers(e)
    assert abs(m - 0.000859695063) < 1e-11 and r < 1e-10


@pytest.mark.parametrize("k", [-0.1, -0.02, 0.1])
def test_the_circle_has_its_period_and_multiplier(tmp_path: Path, k: float) -> None:
    claim = "cycle through y == 0 and 0.9 <= x <= 1.1 within 7"
    e = claimed(tmp_path, CIRCLE, claim, str(k))
    low, high = period_of(e)
    assert isinstance(e.verdict, Proved) and low < 2 * math.pi < high and high - low < 1e-10
    [(m, r)] = multipliers(e)
    assert abs(m - math.exp(4 * math.pi * k)) <= r + 1e-13 and r < 1e-9
    again = claimed(tmp_path, CIRCLE, claim + " attracting", str(k))
    assert isinstance(again.verdict, Proved if k < 0 else Refuted)


@pytest.mark.parametrize(("k", "verdict"), [("0.5", Proved), ("-0.5", Proved), ("0.99", None), ("-2", Refuted)])
def test_a_jump_has_its_part_in_the_multiplier(tmp_path: Path, k: str, verdict: type | None) -> None:
    bounds = "within 7" if verdict is None else "within 7 attracting"
    e = claimed(tmp_path, KICKED, f"cycle through jump(up) and 0.9 <= x <= 1.1 and abs(y) <= 0.1 {bounds}", k)
    assert isinstance(e.verdict, verdict or Proved)
    found = multipliers(e)
    assert any(abs(m - float(k)) <= r + 1e-13 for m, r in found) and len(found) == 1


def test_saltation_of_a_reset_that_depends_on_the_state(tmp_path: Path) -> None:
    """Between ticks x shrinks by e, a tick halves it and adds one: multipliers 1/(2 e), and none of the clock."""
    e = claimed(tmp_path, TICK, "cycle through c == 1/2 and 0 <= x <= 2 within 1.1 attracting")
    assert isinstance(e.verdict, Proved)
    [(m, r)] = multipliers(e)
    assert abs(m - 1 / (2 * math.e)) <= r + 1e-14


@pytest.mark.parametrize(
    ("name", "section", "period", "expected"),
    [
        ("simplest_walker", "jump(strike) and 0.19 <= th <= 0.21", "3.88246375285137", -0.190099841),
        ("compass_gait", "jump(strike)", "0.734346391158", -0.199726127),
    ],
)
def test_gaits_of_the_literature(tmp_path: Path, name: str, section: str, period: str, expected: float) -> None:
    text = (ROOT / "tests" / "peers" / "orbits" / f"{name}.ha").read_text()
    text = text.replace("param slope: rad in [0.5 deg, 5 deg] default 3 deg", "const slope: rad = 3 deg")
    text = text.replace("param gamma in [0.001, 0.019] default 0.009", "const gamma = 0.009")
    text = text.replace("[-60 deg, 60 deg]", "[-1 rad, 1 rad]")
    path = tmp_path / "gait.ha"
    automaton = re.findall(r"^automaton (\w+)", text, re.M)[0]
    unit = "" if "unitless" in text else " s"
    path.write_text(f"{text}\nproperty p on {automaton} {{ cycle through {section} within 4{unit} }}\n")
    e = decided(path)
    low, high = period_of(e)
    assert isinstance(e.verdict, Proved) and abs((low + high) / 2 - Q(period)) < Q(1, 10**10)
    assert high - low < Q(1, 10**9) and abs(multipliers(e)[0][0] - expected) < 1e-8


CENTRE = CIRCLE  # with K = 0 all circles are closed
DAMPED = VAN_DER_POL.replace("(1 - x^2) * y - x", "-x - 0.2 * y")
OPEN = [
    (CENTRE, "cycle through y == 0 and 0.9 <= x <= 1.1 within 7"),  # none is alone
    (DAMPED, "cycle through y == 0 and abs(x) <= 1 within 7"),  # the equilibrium is none, and not told apart
    (VAN_DER_POL, "cycle through y == 0 and 1.9 <= x <= 2.1 within 6.6632"),  # of 6.66329
    (VAN_DER_POL, "cycle through y == 0 and abs(x) <= 2.1 within 7 attracting"),  # (0, 0) stays where it is
    (CIRCLE, "cycle through y == 0 and x <= 2 within 7 attracting"),  # not all runs from there are followed
    (KICKED, "cycle through jump(down) and x >= 0 within 4"),
]


@pytest.mark.parametrize(("automaton", "claim"), OPEN)
def test_what_is_not_shown_is_left_open(tmp_path: Path, automaton: str, claim: str) -> None:
    found = claimed(tmp_path, automaton, claim).verdict
    assert isinstance(found, Unknown) and found.kind == "orbit"


HALTING = KICKED.replace("mode Up {", "mode Up { terminal;")


def test_runs_that_may_end_do_not_all_come_to_the_orbit(tmp_path: Path) -> None:
    claim = "cycle through jump(up) and 0.9 <= x <= 1.1 and abs(y) <= 0.1 within 7 attracting"
    assert isinstance(claimed(tmp_path, HALTING, claim, "0.5").verdict, Unknown)


def test_states_after_jumps_count_beside_those_of_an_equation(tmp_path: Path) -> None:
    """Beside states with y == -1 there are those after any `up`: of them x is not bounded."""
    narrow = "y == -1/2 and 0.8 <= x <= 0.9"
    e = claimed(tmp_path, KICKED, f"cycle through {narrow} within 7 attracting", "0.5")
    assert isinstance(e.verdict, Proved)
    e = claimed(tmp_path, KICKED, f"cycle through {narrow} or jump(up) within 7 attracting", "0.5")
    assert isinstance(e.verdict, Unknown)


# A ball that is thrown up at each impact: v becomes 2 - v / 2, so it lands with -4 and starts with 4.
THROWN = """automaton A {
  var h; var v
  init M where h == 1 and v == 0
  mode M {
    domain h >= 0
    flow { h' = v; v' = -9.81 }
    urgent edge bounce: -> M when h == 0 and v < 0 do v := 2 - 0.5 * v
  }
}"""


def test_a_ball_that_is_thrown_up_has_its_period_and_multiplier(tmp_path: Path) -> None:
    claim = "cycle through jump(bounce) and 3.99 <= v <= 4.01 and abs(h) <= 0.001 within 1 attracting"
    e = claimed(tmp_path, THROWN, claim)
    low, high = period_of(e)
    assert isinstance(e.verdict, Proved) and low < Q(800, 981) < high and high - low < Q(1, 10**11)
    [(m, r)] = multipliers(e)
    assert abs(m - 0.5) <= r < 1e-10
    assert isinstance(claimed(tmp_path, THROWN, claim.replace("within 1", "within 0.8")).verdict, Refuted)


HINDERED = [
    ("mode M {", "mode M { domain x <= 2;"),  # it comes to 2.0086
    ("var x;", "var x in [-2, 2];"),
    ("mode M {", "mode N { flow { x' = 0; y' = 0 } }; mode M { urgent edge out: -> N when x >= 2;"),
]


@pytest.mark.parametrize(("old", "new"), HINDERED)
def test_an_orbit_that_no_run_may_follow_is_none(tmp_path: Path, old: str, new: str) -> None:
    hindered = VAN_DER_POL.replace(old, new).replace("x == 2 and", "x == 1 and")
    found = claimed(tmp_path, hindered, "cycle through y == 0 and -2.1 <= x <= -1.9 within 7")
    assert not isinstance(found.verdict, Proved)


FALSE = [
    (VAN_DER_POL, "cycle through y == 0 and 1.9 <= x <= 2.1 within 3"),
    (VAN_DER_POL, "cycle through y == 0 and 1.5 <= x <= 1.9 within 7"),
    (DAMPED, "cycle through y == 0 and 1 <= x <= 2 within 7"),
    (TICK, "cycle through jump(tick) and 0 <= x <= 3 within 0.9"),
]


@pytest.mark.parametrize(("automaton", "claim"), FALSE)
def test_what_no_run_does_is_refuted(tmp_path: Path, automaton: str, claim: str) -> None:
    assert isinstance(claimed(tmp_path, automaton, claim).verdict, Refuted)


OUTSIDE = [
    "cycle through x >= 1 within 7",
    "cycle through y == 0 within 7; always x <= 3",
    "assume x <= 3; cycle through y == 0 within 7",
    "within 5; cycle through y == 0 within 7",
    "cycle through y == 0 and time >= 1 within 7",
]


@pytest.mark.parametrize("claim", OUTSIDE)
def test_other_claims_are_beyond_the_fragment(tmp_path: Path, claim: str) -> None:
    with pytest.raises(OutsideFragmentError):
        claimed(tmp_path, VAN_DER_POL, claim)


def test_discs_hold_the_eigenvalues() -> None:
    rng = np.random.default_rng(7)
    for n in (1, 2, 3, 5):
        for _ in range(6):
            a = rng.normal(size=(n, n))
            found = discs([[Interval(float(x) - 1e-9, float(x) + 1e-9) for x in row] for row in a])
            values = np.linalg.eigvals(a + rng.uniform(-1e-9, 1e-9, size=(n, n)))
            for v in values:
                assert any(math.hypot(v.real - d.real, v.imag - d.imaginary) <= d.radius + 1e-13 for d in found)
            assert max(float(d.radius) for d in found) < 1e-4
