"""Laws of the kernel's intervals, against exact rationals and python-flint's balls at 200 bits."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

import pytest
from flint import arb, ctx, fmpq
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from haverify.maths.interval import Fault, Interval, enclose

ctx.prec = 200
LAW = settings(max_examples=100, deadline=None, derandomize=True)

FLOATS = st.one_of(
    st.floats(allow_nan=False, allow_infinity=False),
    st.floats(-10, 10),
    st.integers(-20, 20).map(float),
    st.sampled_from([math.pi / 2, math.pi, 3 * math.pi / 2, 1.0, -1.0, 5e-324, -5e-324, 1e16, 1e22, -1e300]),
)
SHARES = st.fractions(0, 1, max_denominator=64)


@st.composite
def intervals(draw: st.DrawFn, low: float = -math.inf, high: float = math.inf) -> Interval:
    """Points, hair's breadths and wide intervals between two bounds."""
    ends = FLOATS.filter(lambda x: low <= x <= high)
    one = draw(ends)
    other = draw(st.one_of(st.just(one), st.just(math.nextafter(one, math.inf)), ends))
    assume(low <= other <= high and math.isfinite(other))
    return Interval(min(one, other), max(one, other))


def point(x: Interval, share: Fraction) -> Fraction:
    """A rational point of the interval: its ends for the shares 0 and 1."""
    low, high = x.exactly()
    return low + share * (high - low)


def ball(q: Fraction) -> arb:
    return arb(fmpq(q.numerator, q.denominator))


def ulp_steps(x: Interval) -> float:
    """How many neighbouring floats the interval spans, measured at its larger end."""
    return x.width / math.ulp(max(abs(x.low), abs(x.high)))


@dataclass(frozen=True)
class Function:
    """A function of the kernel, the same of balls, and a range of arguments without faults."""

    name: str
    of_ball: Callable[[arb], arb]
    low: float = -math.inf
    high: float = math.inf


FUNCTIONS = [
    Function("sqr", lambda x: x * x, -1e154, 1e154),
    Function("sqrt", arb.sqrt, 0.0),
    Function("exp", arb.exp, high=709.0),
    Function("log", arb.log, 5e-324),
    Function("sin", arb.sin),
    Function("cos", arb.cos),
    Function("asin", arb.asin, -1.0, 1.0),
    Function("acos", arb.acos, -1.0, 1.0),
    Function("atan", arb.atan),
    Function("sinh", arb.sinh, -710.0, 710.0),
    Function("cosh", arb.cosh, -710.0, 710.0),
    Function("tanh", arb.tanh),
]


def bits_for(q: Fraction) -> int:
    """Precision that leaves 200 bits of an argument after its reduction modulo pi, and of tiny results near 1."""
    return 200 + max(q.numerator.bit_length(), q.denominator.bit_length())


def certainly_outside(x: Interval, value: arb) -> bool:
    """True if the ball, all of it, is beyond an end: then the enclosure is wrong whatever the ball's radius."""
    return bool(value < arb(x.low)) or bool(value > arb(x.high))


@pytest.mark.parametrize("function", FUNCTIONS, ids=lambda function: function.name)
def test_a_function_encloses_its_value_at_every_point(function: Function) -> None:
    @LAW
    @given(intervals(function.low, function.high), SHARES)
    def law(x: Interval, share: Fraction) -> None:
        result, q = getattr(x, function.name)(), point(x, share)
        with ctx.workprec(bits_for(q)):
            value = function.of_ball(ball(q))
            assert value.is_finite()
            assert not certainly_outside(result, value)

    law()


@pytest.mark.parametrize("function", FUNCTIONS, ids=lambda function: function.name)
def test_a_function_of_a_float_spans_a_few_floats(function: Function) -> None:
    """Two steps at most, also where the value is a float; beyond 2^50 quadrants a wave gives up, so not there."""

    @LAW
    @given(FLOATS.filter(lambda x: function.low <= x <= function.high and abs(x) < 1e15))
    def law(x: float) -> None:
        result = getattr(Interval(x, x), function.name)()
        assert ulp_steps(result) <= 2 or result.width <= 2 * math.ulp(0.0)

    law()


@pytest.mark.parametrize("name", ["sin", "cos"])
def test_the_range_of_a_wave_is_no_wider_than_its_samples_say(name: str) -> None:
    """Wide by at most the largest change between neighbouring samples, as the slope is at most 1."""

    @LAW
    @given(st.floats(-100, 100), st.floats(0.0, 7))
    def law(low: float, length: float) -> None:
        x = Interval(low, low + length)
        result = getattr(x, name)()
        samples = [getattr(math, name)(x.low + k / 200 * (x.high - x.low)) for k in range(201)]
        slack = (x.high - x.low) / 200 + 1e-12
        assert result.low >= min(samples) - slack and result.high <= max(samples) + slack

    law()


@LAW
@given(intervals(-1e6, 1e6), SHARES)
@example(Interval(math.pi / 2, math.pi / 2), Fraction(0))
@example(Interval(-1.5, 1.5), Fraction(1))
def test_a_tangent_encloses_its_value_or_meets_a_pole(x: Interval, share: Fraction) -> None:
    q = point(x, share)
    with ctx.workprec(bits_for(q)):
        try:
            assert not certainly_outside(x.tan(), ball(q).tan())
        except Fault:
            poles = ball(x.exactly()[1]) / arb.pi() - arb(fmpq(1, 2))
            last_pole = (poles + arb(2) ** -40).floor() + arb(fmpq(1, 2))
            assert not last_pole * arb.pi() < arb(x.low) - arb(x.low).abs_upper() * arb(2) ** -45


@LAW
@given(intervals(), intervals(), SHARES, SHARES)
def test_arithmetic_encloses_exact_results(x: Interval, y: Interval, at_x: Fraction, at_y: Fraction) -> None:
    p, q = point(x, at_x), point(y, at_y)
    for operate in (
        lambda a, b: a + b,
        lambda a, b: a - b,
        lambda a, b: a * b,
        lambda a, b: a / b,
    ):
        try:
            result = operate(x, y)
        except Fault:
            continue
        assert result.contains(operate(p, q))
    assert x.hull(y).contains(p) and x.minimum(y).contains(min(p, q)) and x.maximum(y).contains(max(p, q))
    assert (-x).contains(-p) and abs(x).contains(abs(p))


@LAW
@given(FLOATS, FLOATS)
def test_arithmetic_on_floats_is_as_tight_as_floats_allow(a: float, b: float) -> None:
    """The exact result is an end itself, or lies between neighbours; small products may lose one float a side."""
    for operate, small in (
        (lambda x, y: x + y, 0.0),
        (lambda x, y: x - y, 0.0),
        (lambda x, y: x * y, 2.0**-960),
        (lambda x, y: x / y, 2.0**-950),
    ):
        try:
            result = operate(Interval(a, a), Interval(b, b))
        except Fault:
            continue
        exact = operate(Fraction(a), Fraction(b))
        if exact and min(abs(exact), abs(Fraction(a))) < Fraction(small):
            assert math.nextafter(math.nextafter(result.low, math.inf), math.inf) >= result.high
        elif result.low == result.high:
            assert exact == Fraction(result.low)
        else:
            assert math.nextafter(result.low, math.inf) == result.high


@LAW
@given(intervals(-1e30, 1e30), st.integers(-12, 12), SHARES)
def test_powers_enclose_exact_powers(x: Interval, exponent: int, share: Fraction) -> None:
    q = point(x, share)
    try:
        result = x**exponent
    except Fault:
        assert x.contains(0) or abs(exponent * math.log2(max(abs(x.low), abs(x.high), 5e-324))) > 900 or exponent < 0
        return
    assert result.contains(q**exponent)
    assert ulp_steps(Interval(x.low, x.low) ** 2) <= 1 or abs(x.low) < 1e-140


@LAW
@given(st.fractions(), st.integers(-1200, 1200))
@example(Fraction(1, 3), -1074)
@example(Fraction(2**53 + 1), 0)
def test_a_rational_is_enclosed_tightly(mantissa: Fraction, exponent: int) -> None:
    q = mantissa * Fraction(2) ** exponent
    try:
        result = enclose(q)
    except Fault:
        assert abs(q) > Fraction(math.nextafter(math.inf, 0))
        return
    assert result.contains(q)
    if abs(q) >= Fraction(2) ** -959:
        assert result.high <= math.nextafter(result.low, math.inf)
        assert (result.low == result.high) == (Fraction(float(q)) == q)


@LAW
@given(intervals(), intervals(), SHARES)
def test_an_intersection_holds_just_the_common_points(x: Interval, y: Interval, share: Fraction) -> None:
    q = point(x, share)
    try:
        common = x.intersection(y)
    except Fault:
        assert not y.contains(q)
        return
    assert common.contains(q) == y.contains(q)
    assert x.encloses(common) and y.encloses(common)


@LAW
@given(intervals(), SHARES)
def test_width_and_midpoint_are_true(x: Interval, share: Fraction) -> None:
    low, high = x.exactly()
    assert x.contains(x.midpoint)
    try:
        assert Fraction(x.width) >= high - low
    except Fault:
        assert high - low > Fraction(math.nextafter(math.inf, 0))
    assert x.contains(point(x, share))
