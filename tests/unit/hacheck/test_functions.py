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


PARTIAL = {"log": math.log, "sqrt": math.sqrt, "inv": lambda x: 1 / x}


@pytest.mark.parametrize("op", PARTIAL)
def test_roots_logarithms_and_inverses_lie_in_their_enclosures(op: str) -> None:
    random = Random(op)
    for _ in range(60):
        a, b = sorted(Q(random.randint(1, 10**6), random.choice([1, 7, 1000, 10**6])) for _ in range(2))
        low, high = image(op, (a, b))
        values = [PARTIAL[op](float(q)) for q in (a, (a + b) / 2, b)]
        assert low is not None and high is not None
        room = 1e-12 * (1 + max(map(abs, values)))
        assert float(low) <= min(values) + room and max(values) <= float(high) + room
        assert float(high - low) <= (max(values) - min(values)) * (1 + 1e-9) + 1e-9
        one_sided = image(op, (a, None))
        assert (one_sided[1] if op != "inv" else one_sided[0]) == (None if op != "inv" else 0)


@pytest.mark.parametrize("op", PARTIAL)
def test_nothing_is_known_where_a_function_is_not_defined(op: str) -> None:
    for low, high in ((Q(-1), Q(1)), (Q(-2), Q(3)), (None, Q(1)), (None, None)):
        assert image(op, (low, high)) == (None, None)
    assert (image("sqrt", (Q(0), Q(4)))[0], image("inv", (Q(-2), Q(-1)))) == (0, (-1, Q(-1, 2)))
    assert image("log", (Q(0), Q(1))) == image("inv", (Q(0), Q(1))) == (None, None)


def test_values_that_are_rational_are_numbers() -> None:
    f = Functions()
    numbers = [f.apply("sqrt", const(Q(9, 4))), f.apply("log", ONE), f.apply("inv", const(4)), f.apply("sqrt", ZERO)]
    assert numbers == [const(Q(3, 2)), ZERO, const(Q(1, 4)), ZERO]
    assert f.apply("sqrt", const(2)) == var("sqrt(2)") and f.apply("log", ZERO) == var("log()")
    assert f.apply("sqrt", const(-4)) == var("sqrt(-4)") and f.apply("inv", const(-4)) == var("inv(-4)")


def test_slopes_of_roots_logarithms_and_inverses() -> None:
    f = Functions()
    names = {op: f.apply(op, add(X, ONE)) for op in PARTIAL}
    inverse, root = names["inv"], f.apply("inv", names["sqrt"])
    rates = {"x": Y}
    assert f.derivative(names["log"], rates) == mul(inverse, Y)
    assert f.derivative(inverse, rates) == scale(mul(mul(inverse, inverse), Y), -1)
    assert f.derivative(names["sqrt"], rates) == mul(scale(root, Q(1, 2)), Y)
    assert [op for op, _ in f.partial(add(root, f.apply("cos", names["log"])))] == ["log", "sqrt", "inv"]


def test_what_is_said_of_a_function_is_true_where_it_is_defined() -> None:
    f = Functions()
    for op, real in PARTIAL.items():
        name = f"{op}(1*x)"
        f.apply(op, X)
        (relation, a), literals = f.meaning(name)
        assert relation == {"inv": "==", "log": "<=", "sqrt": "<"}[op] and a == X
        for q in (Q(k, 8) for k in range(1, 60)):
            for sign, p in literals:
                value = float(constant(substitute(p, Env({"x": const(q), name: const(Q(real(q)))}))) or 0)
                assert abs(value) < 1e-9 if sign == "==" else value >= -1e-9 if sign == ">=" else value <= 1e-9
