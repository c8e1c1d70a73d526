"""Declared bounds: kept exactly, and told where the recording says otherwise."""

from fractions import Fraction as Q

import pytest
from tests.walks import codes, walk_of

from haverify.diagnostics.codes import is_error
from haverify.fitting.bounded import Interval
from haverify.fitting.exact_ranges import ranges, steepest
from haverify.fitting.walk import Options, walk

THESIS = "subject01_walk1_ik.mot"


def test_a_bound_that_samples_leave_is_told_and_kept_exactly() -> None:
    bounds = Interval(Q(-69), Q(1, 2))
    w, found = walk([walk_of(THESIS)], (), Options(bounds={"k": bounds}))
    assert w is not None
    assert codes(found) == ["HA228", "HA228"]
    assert "12 of 73 samples of the left knee lie outside, as far as 3.21 deg" in found[0].message
    for c in w.curves[2:4]:
        assert all(bounds.low <= a <= b <= bounds.high for a, b in ranges(c))


@pytest.mark.parametrize(("low", "high", "advice"), [(100, 120, None), (1, 80, "--bound knee=-80..-1"), (5, 6, None)])
def test_a_bound_against_most_samples_is_an_error(low: int, high: int, advice: str | None) -> None:
    w, found = walk([walk_of(THESIS)], (), Options(bounds={"k": Interval(Q(low), Q(high))}))
    assert w is None
    assert set(codes(found)) == {"HA228"}
    assert all(map(is_error, found))
    assert {d.help for d in found} == {advice}


def test_ranges_and_speeds_are_those_of_dense_samples() -> None:
    import numpy as np

    w, _ = walk([walk_of(THESIS)], (), Options())
    assert w is not None
    for c in w.curves:
        t = np.linspace(0, float(c.knots.period), 8001)[:-1]
        y, speed = c.at(t), np.abs(c.at(t, 1))
        low, high = (f(x) for f, x in ((min, [a for a, _ in ranges(c)]), (max, [b for _, b in ranges(c)])))
        assert float(y.min()) == pytest.approx(float(low), abs=1e-4)
        assert float(y.max()) == pytest.approx(float(high), abs=1e-4)
        assert float(speed.max()) <= float(steepest(c)) + 1e-9
        assert float(speed.max()) == pytest.approx(float(steepest(c)), rel=1e-3)
