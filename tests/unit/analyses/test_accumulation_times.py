"""When jumps accumulate, from both sides: closed forms and simulated runs lie between, and claims that need it."""

from __future__ import annotations

import math
import random
from fractions import Fraction as Q

import pytest
from tests.unit.analyses.test_accumulation import BLOCK, TANKS, ball
from tests.unit.elaborate.texts import read

from hacheck.core import Core
from hacheck.obligations import Setting, established
from hacheck.rational import Beyond, Meter
from haverify.analyses.induction.refute import Effort
from haverify.analyses.portfolio import decide_all
from haverify.analyses.zeno.closings import closings, shown_by
from haverify.analyses.zeno.followed import TRUE, Landing, followed, from_landings
from haverify.analyses.zeno.following import decide_following
from haverify.analyses.zeno.tail import Bracket, bracket
from haverify.evidence.evidence import Evidence
from haverify.evidence.verdict import Proved
from haverify.model.claim import Goal
from haverify.model.core import to_core
from haverify.obligations.induction import Induction
from haverify.simulate.draws import Drawing
from haverify.simulate.model import SimulatedAutomaton
from haverify.simulate.run import Settings
from haverify.simulate.run import followed as simulated
from haverify.text.record import replace

PUSHED = """
spec "Pushed" version "1.0" unitless
automaton A {
  var x
  var v
  var y
  var w
  init Apart where x == 0 and v == 0 and y == 1 / 2 and w == 0
  mode Apart {
    domain x <= y
    flow { x' = v; v' = 20 / 3; y' = w; w' = 0 }
    urgent edge hit: -> Apart when x >= y and v > w do {
      v := (3 * v + w) / 4 - 3 / 20 * (v - w)
      w := (3 * v + w) / 4 + 9 / 20 * (v - w)
    }
  }
}
property p on A { always time <= 9 }
"""
FULL = ("1 <= x <= 2 and 1 <= y <= 3", "x == 2 and y == 2")


def around(text: str) -> tuple[Bracket, Q]:
    """The bracket of a spec's first automaton, and the end shown without following jumps."""
    spec, _, _ = read(text.strip())
    claim, goal = spec.claims[0], Goal("always", TRUE)
    induction = Induction(spec, spec.automata[0], replace(claim, goals=(goal,)), goal)
    end = next(c.end for c in closings(induction) if shown_by(induction, c, Effort()).is_proved())
    found = bracket(spec, spec.automata[0], claim, end)
    assert found is not None and 0 <= found.low <= found.high <= end
    return found, end


@pytest.mark.parametrize(
    ("text", "exact"),
    [
        (ball(), 3.0),
        (ball("h == 2 and v == 7", "-v / 5"), (7 + math.sqrt(89)) / 10 + math.sqrt(89) / 20),
        (ball("h == 1 and v == -4", "-3 / 4 * v"), (-4 + 6) / 10 + 6 * 6 / 10),
        (
            TANKS.format(w="2, 2", claim="always time <= 9").replace(
                "1 <= x <= 2 and 1 <= y <= 3", "x == 2 and y == 2"
            ),
            2,
        ),
        (PUSHED, 4 * math.sqrt(0.15)),
    ],
)
def test_closed_forms_lie_between(text: str, exact: float) -> None:
    found, _ = around(text)
    assert float(found.low) <= exact * (1 + 1e-12) and exact <= float(found.high) * (1 + 1e-12)
    assert found.high - found.low <= Q(1, 5) * found.high and found.jumps >= 2


def sampled(text: str, count: int) -> list[float]:
    """When jumps accumulate in simulated runs from starts and params drawn at random."""
    spec, _, _ = read(text.strip())
    model, chance = SimulatedAutomaton(spec, spec.automata[0]), random.Random(11)
    runs = [simulated(model, Drawing(model, 1000.0).random(chance.random), Settings(1000.0)) for _ in range(count)]
    assert all(r.end == "zeno" for r in runs)
    return [r.limit for r in runs]


def test_a_block_ends_little_after_its_last_simulated_run() -> None:
    text = BLOCK.format(r="0.7", claim="always time <= 30")
    found, end = around(text)
    times = sampled(text, 12)
    assert all(found.low <= t <= found.high for t in times)
    assert float(found.high) <= 1.08 * max(times) < 1.4 * max(times) < end


def test_balls_with_drag_and_params_end_in_between() -> None:
    text = ball("4 <= h <= 5 and v == 0", "-v / 2", "always time <= 4", "param k in [0, 0.02]", "- k * v")
    found, _ = around(text)
    assert all(float(found.low) <= t <= float(found.high) for t in sampled(text, 12))


def verdict(claim: str, text: str = BLOCK) -> Evidence | None:
    spec, _, _ = read(text.format(r="0.7", claim=claim).strip())
    return decide_following(spec, spec.automata[0], spec.claims[0], to_core(spec), Effort())


def test_claims_that_jumps_one_by_one_decide_are_proved_through_them() -> None:
    for claim in ("always time <= 5.8", "always time >= 5 implies abs(x) <= 0.1", "within 99; always abs(x) <= 0.51"):
        found = verdict(claim)
        assert found is not None and isinstance(found.verdict, Proved) and found.notes


@pytest.mark.parametrize(
    "claim",
    [
        "always time <= 5.36",  # a simulated run is longer
        "always time >= 4 implies abs(x) <= 0.001",  # false in the tail
        "always abs(x) <= 0.49",  # false at a start
        "always time >= 2 implies abs(v) <= 0.1",  # false on the way
        "reach time >= 5 within 6",
        "always during [1, 2] abs(x) <= 1",
        "assume x <= 0; always time <= 9",
    ],
)
def test_what_is_false_or_of_another_kind_is_not_proved_so(claim: str) -> None:
    assert verdict(claim) is None


def test_what_keeps_its_speed_has_no_bracket() -> None:
    spec, _, _ = read(BLOCK.format(r="1", claim="always time <= 1000").strip())
    assert decide_following(spec, spec.automata[0], spec.claims[0], to_core(spec), Effort()) is None


def test_the_second_checker_leaves_it_to_the_kernel() -> None:
    found = verdict("always time <= 5.8")
    spec, _, _ = read(BLOCK.format(r="0.7", claim="always time <= 5.8").strip())
    core = Core(to_core(spec))
    Meter.left = 10_000_000
    assert found is not None and found.certificate is not None
    with pytest.raises(Beyond):
        established(
            core,
            core.claims["p"],
            found.certificate,
            lambda automaton, rounding: Setting(core, automaton, rounding, lambda _: None),
        )


def test_landings_are_starts_at_time_zero_and_say_when_they_are() -> None:
    spec, _, _ = read(ball().strip())
    claim, goal = spec.claims[0], Goal("always", TRUE)
    found = followed(spec, spec.automata[0], replace(claim, goals=(goal,)), goal, Q(4), 3)
    assert found is not None and found.holds and found.jumps == 3
    (x,) = found.landings
    assert isinstance(x, Landing) and x.time[0] <= Q(5, 2) <= x.time[1] and found.low <= Q(5, 2)
    assert [n for n, _, _ in x.states] == ["h", "v"]
    assert all(low <= v <= high for (_, low, high), v in zip(x.states, (0, Q(5, 4)), strict=True))
    _, own = from_landings(spec, spec.automata[0], found, "begun")
    assert [p.name for p in own.params] == ["begun"] and len(own.init) == 1
    assert followed(spec, spec.automata[0], replace(claim, goals=(goal,)), goal, Q(2), 3) is None  # not in 2 s


def test_the_report_says_when_from_both_sides() -> None:
    spec, _, _ = read(ball(claim="always time <= 3").strip())
    (note,) = decide_all(spec)["p"].notes
    assert "accumulate do so between 2.99" in note and "and 3" in note and "(enclosed)" in note
    spec, _, _ = read(ball(claim="always h <= 5").strip())
    assert all("between" not in n for n in decide_all(spec)["p"].notes)


MANY = """spec "c" version "1.0" unitless
automaton Ball {
  var h
  var v
  init Fly where h == 10 and v == 0
  mode Fly {
    domain h >= 0
    flow { h' = v; v' = -9.81 }
EDGES
  }
}
property early on Ball { always time <= 3 }
property high on Ball { always time >= 2.9 implies h >= 5 }
property ended on Ball { always time <= 4.5 }
"""


def test_of_more_landings_than_are_followed_none_is_forgotten() -> None:
    """By the last edge alone the ball bounces until 3 sqrt(20 / 9.81), by the others it hardly does."""
    shares = [*["0.1"] * 6, "0.5"]
    edges = [f"    urgent edge e{k}: -> Fly when h <= 0 and v < 0 do v := -{q} * v" for k, q in enumerate(shares)]
    spec, _, _ = read(MANY.replace("EDGES", "\n".join(edges)))
    found = decide_all(spec)
    assert not any(isinstance(found[name].verdict, Proved) for name in ("early", "high"))
    assert isinstance(found["ended"].verdict, Proved)
