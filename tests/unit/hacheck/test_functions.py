"""Functions in the second checker: names, derivatives, series, enclosures."""

from __future__ import annotations

import math
from fractions import Fraction as Q
from random import Random

import pytest

from hacheck.functions import TERMS, Functions, cosine, exponential, image
from hacheck.polynomial import ONE, ZERO, Env, add, const, constant, mul, scale, substitute, var
from hacheck.rational import Refused

X, Y = var("x"), var("y")


def test_even_and_odd_functions_of_minus_a_are_those_of_a() -> None:
    f = Functions()
    a = add(const(Q(1, 5)), scale(X, Q(-1, 5)))
    assert f.apply("cos", a) == f.apply("cos", scale(a, -1)) == var("cos(1/5+-1/5*x)")
    assert f.apply("sin", scale(a, -1)) == scale(f.apply("sin", a), -1)
    assert f.apply("exp", scale(X, -1)) != f.apply("exp", X)


def test_functions_of_nothing_are_numbers() -> None:
    f = Functions()
    assert [f.apply(op, ZERO) for op in ("sin", "cos", "exp")] == [ZERO, ONE, ONE]


def test_a_name_that_is_replaced_is_replaced_inside_of_functions() -> None:
    f = Functions()
    p = mul(Y, f.apply("cos", add(ONE, X)))
    assert f.substitute(p, Env({"x": const(-1)})) == Y
    assert f.substitute(p, Env({"x": Y})) == mul(Y, f.apply("cos", add(ONE, Y)))
    nested = f.apply("sin", add(f.apply("exp", X), Y))
    assert f.substitute(nested, Env({"x": ZERO, "y": const(-1)})) == ZERO


def test_energy_of_a_pendulum_has_no_slope() -> None:
    f = Functions()
    rates = {"x": Y, "y": scale(f.apply("sin", X), -1)}
    energy = add(scale(mul(Y, Y), Q(1, 2)), f.apply("cos", X), -1)
    assert f.derivative(energy, rates) == ZERO
    assert f.derivative(f.apply("exp", X), rates) == mul(f.apply("exp", X), Y)


@pytest.mark.parametrize("op", ["sin", "cos", "exp"])
def test_series_bound_functions_for_all_arguments(op: str) -> None:
    f = Functions()
    f.apply(op, X)
    for n in range(1, TERMS + 1):
        if op == "exp" and n % 2:
            with pytest.raises(Refused):
                f.series(f"{op}(1*x)", n)
            continue
        relation, p = f.series(f"{op}(1*x)", n)
        for q in (Q(k, 4) for k in range(-24, 25)):
            at = substitute(p, Env({"x": const(q), f"{op}(1*x)": const(Q(getattr(math, op)(q)))}))
            value = float(constant(at) or 0)
            assert value >= -1e-9 if relation == ">=" else value <= 1e-9, (n, q)


@pytest.mark.parametrize("n", [0, -2, 13, True, "2"])
def test_a_series_of_no_or_too_many_terms_is_none(n: object) -> None:
    f = Functions()
    f.apply("cos", X)
    with pytest.raises(Refused):
        f.series("cos(1*x)", n)  # type: ignore[arg-type]


def test_enclosures_hold_what_the_functions_are() -> None:
    random = Random(1)
    for _ in range(400):
        q = Q(random.randint(-1500, 1500), 97)
        for is_sine, f in ((True, math.sin), (False, math.cos)):
            low, high = cosine(q, is_sine)
            assert low - Q(1, 10**14) <= Q(f(q)) <= high + Q(1, 10**14)
            assert high - low < Q(1, 10**15)
        low, end = exponential(q)
        assert end is not None
        assert low * (1 - Q(1, 10**12)) <= Q(math.exp(q)) <= end * (1 + Q(1, 10**12))
        assert end - low <= end / 10**15


def test_images_of_intervals_contain_the_functions_inside() -> None:
    random = Random(2)
    for _ in range(300):
        low = Q(random.randint(-1000, 1000), 61)
        high = low + Q(random.randint(0, 300), 53)
        for op in ("sin", "cos", "exp"):
            least, most = image(op, (low, high))
            for k in range(11):
                value = Q(getattr(math, op)(low + (high - low) * k / 10))
                room = Q(1, 10**9) * max(1, abs(value))
                assert least is not None
                assert least - room <= value
                assert most is None or value <= most + room
    assert image("exp", (None, Q(0)))[0] == 0
    assert image("cos", (None, Q(0))) == (-1, 1)
