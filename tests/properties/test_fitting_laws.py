"""Laws of fitted curves: whatever the unknowns, they join; no sample is outside of the interval; numbers stay short."""

from fractions import Fraction as Q

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from haverify.fitting.basis import design, polynomials
from haverify.fitting.curve import Curve, residual
from haverify.fitting.knots import Knots, knots
from haverify.maths.exact import decimal_text
from haverify.recordings.cycles import Cycle
from haverify.recordings.recording import JOINTS

SHARES = st.lists(st.integers(20, 120), min_size=2, max_size=7).map(
    lambda parts: [Q(sum(parts[: k + 1]), sum(parts)) for k in range(len(parts) - 1)]
)
PERIODS = st.integers(400, 3000).map(lambda ms: Q(ms, 1000))
SEEDS = st.integers(0, 2**32 - 1)
ORDERS = st.integers(0, 2)


def unknowns(grid: Knots, order: int, degree: int, seed: int) -> np.ndarray:
    width = order + 1 + degree - 2 * order - 1
    return np.random.default_rng(seed).normal(0, 50, len(grid.lengths) * width)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(SHARES, PERIODS, ORDERS, st.integers(0, 3), SEEDS)
def test_all_unknowns_give_curves_without_a_step(shares: list[Q], period: Q, order: int, more: int, seed: int) -> None:
    grid, degree = knots(shares, period), 2 * order + 1 + more
    made = Curve("lh", grid, order, degree, polynomials(unknowns(grid, order, degree, seed), grid, order, degree))
    assert [made.jump(k) for k in range(order + 1)] == [0] * (order + 1)
    assert all(decimal_text(c) is not None for row in made.rows for c in row)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(SHARES, PERIODS, ORDERS, st.integers(0, 3), SEEDS)
def test_the_matrix_of_least_squares_evaluates_the_written_polynomials(
    shares: list[Q], period: Q, order: int, more: int, seed: int
) -> None:
    grid, degree = knots(shares, period), 2 * order + 1 + more
    x = unknowns(grid, order, degree, seed)
    made = Curve("lh", grid, order, degree, polynomials(x, grid, order, degree))
    t = np.linspace(0, float(grid.period), 50)[:-1]
    assert np.abs(design(t, grid, order, degree) @ x - made.at(t)).max() < 0.02
    assert abs(float(made.value(Q(0))) - made.at(np.zeros(1))[0]) < 1e-9


@settings(max_examples=40, deadline=None, derandomize=True)
@given(PERIODS, SEEDS, st.lists(st.tuples(st.integers(0, 9999), st.integers(-9000, 9000)), min_size=1, max_size=30))
def test_no_sample_is_outside_of_the_interval(period: Q, seed: int, rows: list[tuple[int, int]]) -> None:
    grid = knots([Q(1, 3), Q(1, 2)], period)
    made = Curve("lh", grid, 1, 4, polynomials(unknowns(grid, 1, 4, seed), grid, 1, 4))
    rows = sorted(dict(rows).items())
    at, angles = tuple(Q(a, 10_000) for a, _ in rows), tuple(Q(v, 100) for _, v in rows)
    cycle = Cycle("made", Q(0), period, at, dict.fromkeys(JOINTS, angles), {})
    off = [v - made.value(a * grid.period) for a, v in zip(at, angles, strict=True)]
    found = residual(made, [cycle])
    assert (found.low, found.high) == (min(off), max(off))
