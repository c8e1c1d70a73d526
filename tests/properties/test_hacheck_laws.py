"""Laws of the checker's arithmetic: decisions agree with python-flint's roots and with dense sampling."""

from fractions import Fraction
from math import prod

import flint
from hypothesis import given, settings
from hypothesis import strategies as st

from hacheck import bernstein, sturm
from hacheck.formula import conj, disj, literal, sign_fits, true
from hacheck.polynomial import add, const, mul, power, scale, total, var
from hacheck.rational import PI

numbers = st.fractions(min_value=-4, max_value=4, max_denominator=6)
coefficients = st.lists(numbers, min_size=1, max_size=5)
comparisons = st.sampled_from(["<", "<=", "==", "!="])
law = settings(max_examples=100, deadline=None, derandomize=True)


def poly(cs, v="s"):
    return total((1, scale(power(var(v), k), c)) for k, c in enumerate(cs))


def value(p, point):
    return sum((Fraction(c, p.unit) * prod(point[v] for v in m) for m, c in p.terms.items()), Fraction(0))


@law
@given(st.lists(st.tuples(comparisons, coefficients), min_size=1, max_size=3), st.booleans())
def test_sturm_agrees_with_dense_sampling(parts, both):
    f = (conj if both else disj)(literal(op, poly(cs)) for op, cs in parts)
    decided = sturm.always(f, Fraction(-2), Fraction(2))
    samples = [Fraction(k, 60) for k in range(-120, 121)]
    seen = all(true(f, lambda op, p, x=x: sign_fits(op, value(p, {"s": x}))) for x in samples)
    assert not decided or seen
    halves = sturm.always(f, Fraction(-2), Fraction(0)) and sturm.always(f, Fraction(0), Fraction(2))
    assert halves == decided


@law
@given(coefficients.filter(lambda cs: any(cs[1:])))
def test_roots_are_those_of_flint(cs):
    p = sturm.square_free(sturm.dense(poly(cs)))
    found = sturm.roots(p, Fraction(-100), Fraction(100))
    real = [r for r, _ in flint.fmpz_poly(p).complex_roots() if r.imag == 0 and abs(r.real) < 100]
    assert len(found) == len(real)


@law
@given(numbers, numbers, st.integers(1, 3))
def test_touching_is_not_crossing(a, b, k):
    square = power(add(var("s"), const(a), -1), 2 * k)
    assert sturm.always(literal(">=", square), None, None)
    inside = abs(b) <= 2 and a == b
    assert sturm.always(literal(">", square), b, b) is (a != b)
    assert not inside or not sturm.always(literal("!=", square), Fraction(-2), Fraction(2))


@law
@given(st.lists(st.tuples(numbers, st.integers(0, 2), st.integers(0, 2)), min_size=1, max_size=5), st.data())
def test_bernstein_coefficients_enclose_the_values(terms, data):
    p = total((1, mul(scale(power(var("x"), i), c), power(var("y"), j))) for c, i, j in terms)
    box = {}
    for v in "xy":
        low, width = data.draw(numbers), abs(data.draw(numbers))
        box[v] = (low, low + width)
    low, high = bernstein.bounds(p, box)
    for i in range(5):
        for j in range(5):
            at = {v: box[v][0] + (box[v][1] - box[v][0]) * Fraction(k, 4) for v, k in (("x", i), ("y", j))}
            assert low <= value(p, at) <= high
    corner = value(p, {v: box[v][0] for v in "xy"})
    assert bernstein.certain("<=", add(p, const(high), -1), box) and low <= corner <= high


@law
@given(st.lists(numbers, min_size=2, max_size=4), numbers)
def test_elimination_is_sound(cs, bound):
    p = add(total((1, scale(var(f"k{i}"), c)) for i, c in enumerate(cs)), const(bound), -1)
    box = {f"k{i}": (Fraction(-1), Fraction(2)) for i in range(len(cs))}
    f = literal("<=", p)
    for v in sorted(box):
        f = bernstein.eliminate(f, v, box)
    assert (f is True) == (sum(max(-c, 2 * c) for c in cs) <= bound)


def test_pi_is_enclosed():
    def arctan(n, terms):
        return sum(Fraction((-1) ** k, (2 * k + 1) * n ** (2 * k + 1)) for k in range(terms))

    low = 16 * arctan(5, 40) - 4 * arctan(239, 41)
    high = 16 * arctan(5, 41) - 4 * arctan(239, 40)
    assert PI[0] < low < high < PI[1]
