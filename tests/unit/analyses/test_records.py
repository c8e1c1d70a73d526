"""Records of flows: how finely they are written, and that flows at any speed are followed by the checker."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.unit.analyses.test_texts import decided, words

from haverify.analyses.hybrid.record import COARSEST, PRECISION, precision
from haverify.solvers.kernel import units

FAST = """spec "t" version "1.0" unitless
automaton A {{
  var x
  var y
  init R where 0.9 <= x <= 1 and y == 0
  mode R {{ flow {{ x' = {speed} * (y - x); y' = {speed} * (sin(x) - y) }} }}
}}
property below on A {{ within {time}; always x <= 1.001; expect proved }}
property falls on A {{ within {time}; always x >= 0.8; expect refuted }}
"""


@pytest.mark.parametrize("power", [0, 2, 4, 6])
def test_flows_are_checked_at_any_speed(tmp_path, power):
    """The same runs, faster: `decided` has each certificate accepted."""
    found = decided(tmp_path, FAST.format(speed=10**power, time=f"{10**-power:.6f}"))
    assert words(found) == {"below": "proved", "falls": "refuted"}
    assert all("flow" in e.certificate["goals"][0] for e in found.values())


SIZE = st.floats(-1e9, 1e9)


@given(st.floats(1e-6, 10), st.lists(st.lists(SIZE, min_size=1, max_size=3), min_size=1, max_size=6))
def test_coefficients_are_no_longer_than_a_certificate_may_have_them(h, scaled):
    """Coefficients of given sizes in the record, before they are scaled by powers of the step."""
    series = [[[c / h**k for c in row] for k, row in enumerate(scaled)]]
    bits = precision([(h, series)])
    assert COARSEST <= bits <= PRECISION
    assert all(abs(q) < 10**18 for x in units(series, h, bits) for row in x for q in row)


def test_what_is_too_large_is_not_recorded():
    assert precision([(1.0, [[[2.0**60]]])]) is None
    assert precision([(2.0**-30, [[[1.0], [2.0**60]]])]) == 58 - 31
