"""Laws of flowpipes: runs stay inside at all times, a part of the starts stays inside the whole, time may be scaled."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import sin

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from haverify.maths.interval import Interval
from haverify.model.expression import Expr
from haverify.solvers.kernel import Pipe, Settings, Tape, flowpipe

SETTINGS = Settings(order=8, degree=3, tolerance=1e-8, first=0.01, longest=0.25, least=1e-7, steps=100, depth=0)
HORIZON = Fraction(1)

Field = Sequence[Sequence[Fraction]]
Box = tuple[tuple[Fraction, Fraction], ...]

coefficients = st.integers(-8, 8).map(lambda n: Fraction(n, 4))
fields = st.lists(st.lists(coefficients, min_size=6, max_size=6), min_size=2, max_size=2)
ends = st.tuples(st.integers(-8, 8), st.integers(0, 4)).map(lambda p: (Fraction(p[0], 8), Fraction(p[0] + p[1], 8)))
boxes = st.tuples(ends, ends)
shares = st.tuples(st.floats(0, 1), st.floats(0, 1))


def number(q: Fraction) -> Expr:
    return Expr("num", (q,))


def rate(c: Sequence[Fraction]) -> Expr:
    """`c0 + c1 x + c2 y + c3 x y + c4 x^2 + c5 sin(y)`."""
    x, y = Expr("var", ("x",)), Expr("var", ("y",))
    terms = [number(Fraction(1)), x, y, Expr("*", (x, y)), Expr("^", (x, number(Fraction(2)))), Expr("sin", (y,))]
    return Expr("+", tuple(Expr("*", (number(q), t)) for q, t in zip(c, terms, strict=True)))


def enclosed(field: Field, box: Box, scale: int = 1) -> Pipe:
    tape = Tape({"x": 0, "y": 1}, {})
    outputs = [tape.add(Expr("*", (number(Fraction(scale)), rate(c)))) for c in field]
    pairs = [(i.low, i.high) for i in (Interval.between(*e) for e in box)]
    horizon = Interval.at(HORIZON / scale)
    return flowpipe(tape.listing(outputs), pairs, horizon, Tape({}, {}).listing([]), [], SETTINGS)


def derivative(field: Field, state: Sequence[float]) -> list[float]:
    x, y = state
    terms = (1.0, x, y, x * y, x * x, sin(y))
    return [sum(float(q) * t for q, t in zip(c, terms, strict=True)) for c in field]


def stepped(field: Field, state: list[float], h: float) -> list[float]:
    """One step of the classical Runge-Kutta method: independent of everything in the kernel."""

    def at(slope: Sequence[float], h: float) -> list[float]:
        return [s + h * k for s, k in zip(state, slope, strict=True)]

    k1 = derivative(field, state)
    k2 = derivative(field, at(k1, h / 2))
    k3 = derivative(field, at(k2, h / 2))
    k4 = derivative(field, at(k3, h))
    slopes = [a + 2 * b + 2 * c + d for a, b, c, d in zip(k1, k2, k3, k4, strict=True)]
    return at(slopes, h / 6)


def assert_inside(state: Sequence[float], box: Sequence[tuple[float, float]]) -> None:
    for value, (low, high) in zip(state, box, strict=True):
        slack = 1e-6 * (1 + abs(value))  # the error of the sampled run, not of the enclosure
        assert low - slack <= value <= high + slack


@given(fields, boxes, shares)
@settings(max_examples=60, deadline=None, derandomize=True)
def test_runs_stay_inside(field: Field, box: Box, share: tuple[float, float]) -> None:
    pipe = enclosed(field, box)
    state = [float(low) + s * float(high - low) for (low, high), s in zip(box, share, strict=True)]
    for segment in pipe.segments:
        pieces = 2 + int(segment.length / 0.005)
        assert_inside(state, segment.states)
        for _ in range(pieces):
            state = stepped(field, state, segment.length / pieces)
            assert_inside(state, segment.states)
    if pipe.last:
        assert_inside(state, pipe.last)


@given(fields, boxes)
@settings(max_examples=25, deadline=None, derandomize=True)
def test_a_point_of_the_starts_ends_inside_the_whole(field: Field, box: Box) -> None:
    whole, point = enclosed(field, box), enclosed(field, tuple((low, low) for low, _ in box))
    for (low, high), (first, last) in zip(whole.last, point.last, strict=False):
        assert low <= last
        assert first <= high  # both enclose the end of the same run


@given(fields, boxes)
@settings(max_examples=25, deadline=None, derandomize=True)
def test_a_faster_field_arrives_at_the_same_place_sooner(field: Field, box: Box) -> None:
    slow, fast = enclosed(field, box), enclosed(field, box, scale=4)
    for (low, high), (first, last) in zip(slow.last, fast.last, strict=False):
        assert max(low, first) <= min(high, last)


def test_a_wrong_field_is_told_apart() -> None:
    """The check of runs above can fail: runs of another field leave the flowpipe."""
    zero = Fraction(0)
    grows = [[zero, Fraction(1), zero, zero, zero, zero], [zero] * 6]
    faster = [[zero, Fraction(1001, 1000), zero, zero, zero, zero], [zero] * 6]
    pipe = enclosed(grows, ((Fraction(1), Fraction(1)), (zero, zero)))
    assert pipe.last[0][0] == pytest.approx(2.718281828, abs=1e-6)
    right, wrong = [1.0, 0.0], [1.0, 0.0]
    for _ in range(100):
        right, wrong = stepped(grows, right, 0.01), stepped(faster, wrong, 0.01)
    assert_inside(right, pipe.last)
    with pytest.raises(AssertionError):
        assert_inside(wrong, pipe.last)
