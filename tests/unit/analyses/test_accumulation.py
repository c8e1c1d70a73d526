"""Ends of runs whose jumps accumulate: closed forms, what does not accumulate, claims beyond, simulated runs."""

from __future__ import annotations

import math
from fractions import Fraction as Q

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.unit.elaborate.texts import read

from haverify.analyses.induction.refute import Effort
from haverify.analyses.portfolio import decide_all
from haverify.analyses.zeno.closing import Closing
from haverify.analyses.zeno.closings import closings, shown_by
from haverify.analyses.zeno.decide import decide_closing
from haverify.analyses.zeno.weights import weights_of
from haverify.evidence.verdict import Proved, Refuted
from haverify.model.core import to_core
from haverify.model.expression import Expr
from haverify.model.hybrid import Edge
from haverify.obligations.induction import Induction
from haverify.simulate.draws import Drawing
from haverify.simulate.model import SimulatedAutomaton
from haverify.simulate.run import Settings, followed

BALL = """
spec "Ball" version "1.0" unitless
{params}
automaton A {{
  var h
  var v
  init Fly where {start}
  mode Fly {{
    domain h >= 0
    flow {{ h' = v; v' = -10 {more} }}
    urgent edge bounce: -> Fly when h <= 0 and v < 0 do v := {reset}
  }}
}}
property p on A {{ {claim} }}
"""
TANKS = """
spec "Tanks" version "1.0" unitless
param w in [{w}]
automaton A {{
  var x
  var y
  init First where 1 <= x <= 2 and 1 <= y <= 3
  mode First {{ domain y >= 1; flow {{ x' = w - 2; y' = -1 }} }}
  mode Second {{ domain x >= 1; flow {{ x' = -2; y' = w - 1 }} }}
  urgent edge over: First -> Second when y <= 1
  urgent edge back: Second -> First when x <= 1
}}
property p on A {{ {claim} }}
"""
BLOCK = """
spec "Block" version "1.0" unitless
const r = {r}
automaton A {{
  var x
  var v
  let left = cos((1 + x) / 5) + (v / 5)^2 / 2
  let right = cos((1 - x) / 5) + (v / 5)^2 / 2
  init Left where -0.5 <= x <= -0.4 and v == 0
  mode Left {{
    domain x <= 0; flow {{ x' = v; v' = 5 * sin((1 + x) / 5) }}
    edge a: -> Right when x == 0 and v >= 0 do v := r * v
  }}
  mode Right {{
    domain x >= 0; flow {{ x' = v; v' = -5 * sin((1 - x) / 5) }}
    edge b: -> Left when x == 0 and v <= 0 do v := r * v
  }}
}}
property p on A {{ {claim} }}
"""
GAINS = """
spec "Gains" version "1.0" unitless
automaton A {{
  var h
  var v
  init Low where h == 1 and v == 0
  mode Low {{
    domain h >= 0; flow {{ h' = v; v' = -10 }}
    urgent edge a: -> High when h <= 0 and v < 0 do v := -{gain} * v
  }}
  mode High {{
    domain h >= 0; flow {{ h' = v; v' = -20 }}
    urgent edge b: -> Low when h <= 0 and v < 0 do v := -v / 2
  }}
}}
property p on A {{ {claim} }}
"""


def ball(
    start: str = "h == 5 and v == 0",
    reset: str = "-v / 2",
    claim: str = "always time <= 9",
    params: str = "",
    more: str = "",
) -> str:
    return BALL.format(start=start, reset=reset, claim=claim, params=params, more=more)


def closed(text: str) -> Closing | None:
    """The first closing all of whose parts are shown."""
    spec, _, _ = read(text.strip())
    induction = Induction(spec, spec.automata[0], spec.claims[0], spec.claims[0].goals[0])
    found = next(closings(induction), None)
    assert found is None or shown_by(induction, found, Effort()).is_proved()
    return found


def verdict(text: str) -> type:
    """What an end of all runs shows of the first claim, None's type where it shows nothing."""
    spec, _, _ = read(text.strip())
    found = decide_closing(spec, spec.automata[0], spec.claims[0], to_core(spec), Effort())
    return type(None if found is None else found.verdict)


def simulated(text: str) -> float:
    spec, _, _ = read(text.strip())
    model = SimulatedAutomaton(spec, spec.automata[0])
    run = followed(model, Drawing(model, 1000.0).nominal(), Settings(1000.0))
    assert run.end == "zeno"
    return run.limit


@pytest.mark.parametrize(
    ("height", "speed", "c"), [(5, 0, Q(1, 2)), (2, 7, Q(9, 10)), (0, 3, Q(1, 5)), (1, -4, Q(99, 100))]
)
def test_a_ball_ends_at_the_closed_form(height: int, speed: int, c: Q) -> None:
    impact = math.sqrt(speed**2 + 20 * height)
    exact = (speed + impact) / 10 + 2 * float(c) * impact / (10 * (1 - float(c)))
    found = closed(ball(f"h == {height} and v == {speed}", f"-{c} * v", "always time <= 1000"))
    assert found is not None and exact * (1 - 1e-15) <= found.end <= exact * (1 + 3e-9)
    assert found.share == c


def test_an_end_that_is_rational_is_exact() -> None:
    assert verdict(ball(claim="always time <= 3")) is Proved
    assert verdict(ball(claim="always time < 3")) is type(None)
    assert verdict(TANKS.format(w="2, 2", claim="always time <= 3")) is Proved
    assert verdict(TANKS.format(w="2, 2", claim="always time <= 2.999")) is type(None)


def test_the_end_is_that_of_the_worst_start_and_the_worst_params() -> None:
    ranged = ball("0 <= h <= 5 and -1 <= v <= 0", "-c * v", "always time <= 100", "param c in [0.1, 0.6]")
    found = closed(ranged)
    assert found is not None and found.share == Q(3, 5) and math.isclose(found.end, 4)
    heavy = closed(ball(claim="always time <= 100", params="param g in [9, 10]", more="+ (10 - g)"))
    assert heavy is not None and heavy.end >= 3 * math.sqrt(10 / 9)


def test_drag_and_reach_of_a_block_leave_room_and_runs_lie_inside() -> None:
    slowed = ball("h == 5 and v == 0", "-v / 2", "always time <= 4", "param k in [0, 0.02]", "- k * v")
    found = closed(slowed)
    assert found is not None and simulated(slowed) <= found.end <= 3.2
    block = BLOCK.format(r="0.7", claim="always time <= 30")
    rocking = closed(block)
    assert rocking is not None and simulated(block) <= rocking.end <= 3 * simulated(block)
    assert rocking.share == Q(49, 100)


@pytest.mark.parametrize(
    "text",
    [
        ball(reset="-v", claim="always time <= 1000000"),
        ball(reset="-1.01 * v", claim="always time <= 1000000"),
        ball(reset="-c * v", claim="always time <= 1000000", params="param c in [0.5, 1]"),
        ball(reset="1", claim="always time <= 1000000"),
        ball(reset="-v / 2 + 1", claim="always time <= 1000000"),
        BLOCK.format(r="1", claim="always time <= 1000000"),
        GAINS.format(gain="2", claim="always time <= 1000000"),
        GAINS.format(gain="3", claim="always time <= 1000000"),
        TANKS.format(w="3, 3", claim="always time <= 1000000"),
        TANKS.format(w="2, 3", claim="always time <= 1000000"),
    ],
)
def test_what_does_not_accumulate_has_no_end(text: str) -> None:
    assert closed(text) is None


def test_jumps_may_gain_where_others_lose_more() -> None:
    text = GAINS.format(gain="1.5", claim="always time <= 10")
    found = closed(text)
    assert found is not None and found.share == Q(3, 4)
    assert math.isclose(float(found.end), simulated(text), rel_tol=1e-8)


@given(st.integers(1, 9), st.integers(-9, 9), st.integers(20, 90))
@settings(max_examples=6, derandomize=True, deadline=None)
def test_simulated_balls_end_where_it_is_proved(height: int, speed: int, percent: int) -> None:
    text = ball(f"h == {height} and v == {speed}", f"-{percent} / 100 * v", "always time <= 100000")
    found = closed(text)
    assert found is not None and simulated(text) <= float(found.end) * (1 + 1e-9)


@given(st.lists(st.tuples(st.integers(0, 2), st.integers(0, 2), st.integers(1, 20)), min_size=1, max_size=5))
@settings(max_examples=200, derandomize=True, deadline=None)
def test_weights_are_enough_for_every_edge(told: list[tuple[int, int, int]]) -> None:
    edges = tuple(Edge(f"e{k}", str(a), str(b), True, Expr("true"), ()) for k, (a, b, _) in enumerate(told))
    bends = {str(m): Q(m + 1) for m in range(3)}
    shares = {k: Q(q, 10) for k, (_, _, q) in enumerate(told)}
    weights = weights_of(edges, bends, shares)
    if weights is None:
        assert any(q >= 10 for _, _, q in told)
        return
    for k, (a, b, _) in enumerate(told):
        assert weights[str(a)] >= 1 / bends[str(a)] + shares[k] * (1 / bends[str(b)] + weights[str(b)])


def test_claims_beyond_the_end() -> None:
    assert verdict(ball(claim="within 1000, 3 jumps; always h <= 5")) is Proved
    assert verdict(ball(claim="within 1000; always h <= 4.99")) is type(None)
    assert verdict(ball(claim="can reach h >= 5.01")) is Refuted
    assert verdict(ball(claim="reach h >= 6 within 100")) is Refuted
    assert verdict(ball(claim="reach time >= 4 within 4")) is Refuted
    assert verdict(ball(claim="reach h <= 1 within 100")) is type(None)
    assert verdict(ball(claim="assume h >= 1; reach h >= 6 within 100")) is type(None)


def test_what_is_met_before_is_not_refuted() -> None:
    spec, _, _ = read(ball(claim="reach time >= 2 within 2.5").strip())
    assert isinstance(decide_all(spec)["p"].verdict, Proved)
