"""The second verdict and the sensitivities, against models whose coefficients are other ones."""

from fractions import Fraction as Q
from itertools import product

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from tests.unit.analyses.models import schedule, spec
from tests.unit.analyses.rounded import HALF, decided, names, value

from haverify.evidence.verdict import Proved, Refuted, Unknown

EMPTY = spec(schedule([[0], [0]]))
tenths = st.integers(-30, 30).map(lambda k: Q(k, 10))
coefficients = st.fixed_dictionaries(dict.fromkeys(names(), tenths))
bounds = st.integers(-60, 200).map(lambda k: Q(k, 10))
CORNERS = list(product((-HALF, Q(0), HALF), repeat=3))


def greatest(values):
    """A value of `y` that is close to its greatest from below."""
    grid = [Q(k, 40) for k in range(41)]
    return max(max(value(values, "a", x), value(values, "b", x + 1)) for x in grid)


def corners(values):
    """The models at corners of the box of values that round to these, each for one mode."""
    for letter, moved in product("ab", CORNERS):
        yield {**values, **{f"{letter}{i}": values[f"{letter}{i}"] + d for i, d in enumerate(moved)}}


@given(coefficients, bounds)
@settings(max_examples=60, deadline=None, derandomize=True, database=None)
def test_the_second_verdict_holds_at_every_corner(values, bound):
    evidence = decided(values, bound, EMPTY)
    second = evidence.rounding.verdict
    for corner in corners(values):
        if isinstance(second, Proved):
            assert greatest(corner) <= bound
    if isinstance(second, Refuted):
        lowest = {name: v - HALF for name, v in values.items()}  # x >= 0, so this is below all others everywhere
        assert isinstance(decided(lowest, bound, EMPTY).verdict, Refuted)
    if isinstance(second, Proved):
        highest = {name: v + HALF for name, v in values.items()}
        assert isinstance(decided(highest, bound, EMPTY).verdict, Proved)


@given(coefficients, bounds)
@settings(max_examples=40, deadline=None, derandomize=True, database=None)
def test_the_second_verdict_is_no_other_than_the_first(values, bound):
    evidence = decided(values, bound, EMPTY)
    assert isinstance(evidence.rounding.verdict, type(evidence.verdict) | Unknown)


@pytest.mark.parametrize(
    ("bound", "first", "second"),
    [("1.5", Proved, Proved), ("1.02", Proved, Unknown), ("0.98", Refuted, Unknown), ("0.5", Refuted, Refuted)],
)
def test_near_the_bound_rounding_decides_nothing(bound, first, second):
    values = dict.fromkeys(names(), Q(0)) | {"a0": Q(1)}
    evidence = decided(values, bound, EMPTY)
    assert (type(evidence.verdict), type(evidence.rounding.verdict)) == (first, second)


STEP = Q(1, 10**6)


def found_slopes(evidence):
    return {s.constant: s for p in evidence.parts for s in p.sensitivities}


@given(coefficients, bounds)
@settings(max_examples=15, deadline=None, derandomize=True, database=None)
def test_a_slope_is_the_change_of_the_margin_by_the_change_of_a_coefficient(values, bound):
    assume(all(values[f"{letter}1"] or values[f"{letter}2"] for letter in "ab"))  # where y is constant none are given
    evidence = decided(values, bound, EMPTY)
    slopes, margin = found_slopes(evidence), evidence.verdict.margin
    assert slopes
    for name, s in slopes.items():
        above = decided({**values, name: values[name] + STEP}, bound, EMPTY).verdict
        below = decided({**values, name: values[name] - STEP}, bound, EMPTY).verdict
        assume(type(above) is type(below) is type(evidence.verdict))
        up, down = (above.margin.low - margin.low) / STEP, (margin.low - below.margin.low) / STEP
        assert min(up, down) - Q(1, 1000) <= s.slope <= max(up, down) + Q(1, 1000), name


def test_slopes_of_a_margin_known_by_hand():
    values = dict.fromkeys(names(), Q(0)) | {"b1": Q(1)}  # y = x in M1, at most 2
    found = found_slopes(decided(values, Q(3), EMPTY))
    assert {k: s.slope for k, s in found.items()} == {"b0": -1, "b1": -2, "b2": -4}
    assert {k: s.to_zero for k, s in found.items()} == {"b0": 1, "b1": Q(1, 2), "b2": Q(1, 4)}
    assert {k: s.rounding for k, s in found.items()} == {"b0": -HALF, "b1": -2 * HALF, "b2": -4 * HALF}


def test_the_change_that_brings_the_margin_to_zero_does():
    values = dict.fromkeys(names(), Q(0)) | {"b1": Q(1)}
    for name, s in found_slopes(decided(values, Q(3), EMPTY)).items():
        assert decided({**values, name: values[name] + s.to_zero}, Q(3), EMPTY).verdict.margin.low == 0
