"""Inputs with bounded rates as variables: verdicts by hand, runs of admissible signals, what is none."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from haverify.analyses.hybrid.rated import with_rates
from haverify.analyses.portfolio import decide_all
from haverify.evidence.verdict import Proved, Refuted, Unknown
from haverify.run.examine import read

TANK = """spec "Tank" version "1.0" unitless
input q in [0, 2] rate [-0.1, 0.1]
automaton Tank {
  var h
  init where 1 <= h <= 1.1
  mode fill {
    domain h <= 9
    flow { h' = q - 0.5 * h }
  }
}
"""
VALVE = """spec "Valve" version "1.0" unitless
input q in [0, 2] rate [-0.1, 0.1]
automaton Valve {
  var h
  var seen
  init Shut where 1 <= h <= 1.1 and seen == 0
  mode Shut {
    flow { h' = -0.5 * h; seen' = 0 }
    urgent edge opens: -> Open when h <= 0.8 do seen := q
  }
  mode Open { flow { h' = q - 0.5 * h; seen' = 0 } }
}
"""


@pytest.fixture
def verdict(tmp_path: Path) -> Callable[[str, str], object]:
    """The verdict on a claim about a model."""

    def of(model: str, body: str) -> object:
        path = tmp_path / "model.ha"
        path.write_text(f"{model}property p on {model.split('automaton ')[1].split()[0]} {{\n{body}\n}}\n")
        spec, _, found = read(str(path))
        assert spec is not None
        assert not [d for d in found if d.code < "HA200"]
        return decide_all(spec, ["p"])["p"].verdict

    return of


@pytest.mark.parametrize(
    ("model", "body", "kind"),
    [
        # Where the inflow is 0.5 now it was at least 0.3 all the time: the level is above 1.0 e^-1 + 0.6 (1 - e^-1).
        (TANK, "within 2\nalways q >= 0.5 implies h >= 0.35", Proved),
        (TANK, "within 2\nalways time >= 1.9 implies not (q >= 1.5 and h <= 1.6)", Proved),
        (TANK, "within 2\nalways q >= 0.5 implies h >= 1.3", Refuted),
        (TANK, "can reach q <= 0.1 and h >= 1.8 within 1", Refuted),
        # Boxes around what jumps lose too much to show less than the range; a run shows that it moves on from there.
        (VALVE, "within 2\nalways at(Open) implies abs(q - seen) <= 0.05", Refuted),
    ],
)
def test_verdicts(verdict: Callable[[str, str], object], model: str, body: str, kind: type) -> None:
    found = verdict(model, body)
    assert isinstance(found, kind), found


def test_without_a_rate_the_input_may_be_anything_at_any_time(verdict: Callable[[str, str], object]) -> None:
    found = verdict(TANK.replace(" rate [-0.1, 0.1]", ""), "within 2\nalways q >= 0.5 implies h >= 0.35")
    assert not isinstance(found, Proved), "an inflow of 0 that is 0.5 at the end lets the level fall to 0.37 e^-1"
    assert isinstance(found, (Refuted, Unknown))


def test_nothing_is_changed_where_no_input_has_a_rate(tmp_path: Path) -> None:
    path = tmp_path / "model.ha"
    path.write_text(TANK.replace(" rate [-0.1, 0.1]", "") + "property p on Tank { within 1; always h <= 4 }\n")
    spec, _, _ = read(str(path))
    assert spec is not None
    assert with_rates(spec, spec.automata[0], spec.claims[0]) is None


def level(start: float, inflow: Callable[[float], float], until: float, steps: int = 400) -> float:
    """The level of the tank by Euler's method of second order; the inflow is a polygon."""
    h, d = start, until / steps
    for k in range(steps):
        slope = inflow(k * d) - 0.5 * h
        h += d / 2 * (slope + inflow((k + 1) * d) - 0.5 * (h + d * slope))
    return h


@settings(max_examples=10, deadline=None)
@given(
    start=st.floats(1, 1.1),
    first=st.floats(0, 2),
    slopes=st.lists(st.floats(-0.1, 0.1), min_size=4, max_size=4),
    seen=st.sampled_from([Fraction(k, 10) for k in range(21)]),
    least=st.sampled_from([Fraction(k, 20) for k in range(41)]),
)
def test_what_is_proved_holds_for_admissible_signals(
    tmp_path_factory: pytest.TempPathFactory,
    start: float,
    first: float,
    slopes: list[float],
    seen: Fraction,
    least: Fraction,
) -> None:
    ends = [first]
    for slope in slopes:
        ends.append(min(2.0, max(0.0, ends[-1] + 0.25 * slope)))

    def inflow(t: float) -> float:
        k = min(3, math.floor(4 * t))
        return ends[k] + (ends[k + 1] - ends[k]) * (4 * t - k)

    path = tmp_path_factory.mktemp("rated") / "model.ha"
    claim = f"always time >= 1 implies not (q >= {float(seen)} and h <= {float(least)})"
    path.write_text(f"{TANK}property p on Tank {{\nwithin 1\n{claim}\n}}\n")
    spec, _, _ = read(str(path))
    assert spec is not None
    found = decide_all(spec, ["p"])["p"].verdict
    violates = inflow(1.0) >= float(seen) and level(start, inflow, 1.0) <= float(least) - 1e-4
    assert not (violates and isinstance(found, Proved))
