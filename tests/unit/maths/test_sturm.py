"""Roots, extremes and sign vectors against closed forms and against python-flint."""

from fractions import Fraction as Q

import flint
from hypothesis import given, settings
from hypothesis import strategies as st

from haverify.maths import bernstein, sturm
from haverify.maths.univariate import derivative, integers, product, sign_at, square_free, value

whole = st.lists(st.integers(-9, 9), min_size=1, max_size=7).map(lambda c: integers([Q(x) for x in c])[0])
rational = st.fractions(-3, 3, max_denominator=7)


def linear(root):
    return integers([-root, Q(1)])[0]


def test_square_root_of_two_is_isolated_and_refined():
    (root,) = sturm.isolate((-2, 0, 1), Q(0), Q(2))
    fine = sturm.refine((-2, 0, 1), root)
    assert fine.low**2 < 2 < fine.high**2
    assert fine.high - fine.low < Q(1, 2**40)


def test_roots_at_both_ends_are_found_once():
    assert sturm.isolate((0, -1, 1), Q(0), Q(1)) == [sturm.Root(Q(0), Q(0)), sturm.Root(Q(1), Q(1))]


def test_a_double_root_is_one_root():
    p = product((-1, 3), (-1, 3))
    roots = sturm.isolate(p, Q(0), Q(1))
    assert len(roots) == 1
    assert roots[0].low <= Q(1, 3) <= roots[0].high


def test_extremes_of_a_parabola():
    least, greatest = sturm.extremes((0, 0, 1), Q(-1), Q(2))
    assert (least.low, least.high, least.at, least.exact) == (0, 0, 0, True)
    assert (greatest.low, greatest.at) == (4, 2)


def test_extremes_enclose_an_irrational_value():
    least, _ = sturm.extremes((0, -2, 0, 1), Q(0), Q(2))  # -4/3 sqrt(2/3) at sqrt(2/3)
    assert least.low**2 >= Q(32, 27) >= least.high**2
    assert least.high - least.low < Q(1, 10**20)


@given(st.lists(rational, min_size=1, max_size=4), whole)
@settings(max_examples=100, deadline=None, derandomize=True)
def test_every_chosen_root_is_in_one_isolating_interval(roots, other):
    p = (1,)
    for r in roots:
        p = product(p, linear(r))
    p = product(p, other)
    if not p:
        return
    found = sturm.isolate(p, Q(-3), Q(3))
    for r in set(roots):
        assert sum(f.low == r == f.high or f.low < r < f.high for f in found) == 1


@given(whole, rational, rational)
@settings(max_examples=100, deadline=None, derandomize=True)
def test_isolation_counts_as_sturm_and_flint_do(p, a, b):
    low, high = min(a, b), max(a, b)
    if len(p) <= 1 or low == high:
        return
    found = sturm.isolate(p, low, high)
    assert len(found) == sturm.count(p, low, high) + (sign_at(p, low) == 0)
    balls = [r.real for r, _ in flint.fmpz_poly(list(square_free(p))).complex_roots() if r.imag == 0]
    inside = [x for x in balls if float(low) - 1e-12 <= float(x.mid()) <= float(high) + 1e-12]
    assert len(found) == len(inside)


@given(whole, rational, rational)
@settings(max_examples=100, deadline=None, derandomize=True)
def test_samples_lie_between_the_extremes(p, a, b):
    if not p:
        return
    low, high = min(a, b), max(a, b)
    least, greatest = sturm.extremes(p, low, high)
    for i in range(21):
        v = value(p, low + (high - low) * Q(i, 20))
        assert least.low <= v <= greatest.high
    assert least.high >= value(p, least.at) - (least.high - least.low) * 2
    assert low <= least.at <= high


@given(st.lists(whole, min_size=1, max_size=3), rational, rational)
@settings(max_examples=100, deadline=None, derandomize=True)
def test_sign_vectors_are_complete(polynomials, a, b):
    polynomials = [p for p in polynomials if p]
    low, high = min(a, b), max(a, b)
    listed = {p.signs for p in sturm.sign_vectors(polynomials, low, high)}
    for i in range(41):
        x = low + (high - low) * Q(i, 40)
        assert tuple(sign_at(p, x) for p in polynomials) in listed


def test_sign_vectors_see_a_common_root():
    vectors = {p.signs for p in sturm.sign_vectors([(-2, 0, 1), (0, -2, 0, 1)], Q(1), Q(2))}
    assert vectors == {(-1, -1), (0, 0), (1, 1)}


def test_bernstein_encloses_and_is_exact_at_the_ends():
    p = (3, -5, 0, 2)
    b, d = bernstein.coefficients(p, Q(1, 3), Q(5, 2))
    assert Q(b[0], d) == value(p, Q(1, 3))
    assert Q(b[-1], d) == value(p, Q(5, 2))
    assert min(b) <= min(value(p, Q(1, 3) + Q(13, 6) * Q(i, 50)) for i in range(51)) * d


def test_derivative_is_zero_at_an_inner_extreme():
    p = (0, 3, -4, 1)
    _, greatest = sturm.extremes(p, Q(0), Q(3))
    fine = [r for r in sturm.isolate(derivative(p), Q(0), Q(3)) if r.low <= greatest.at <= r.high]
    assert len(fine) == 1


def test_roots_of_linear_polynomials_are_exact_among_sign_vectors():
    pieces = sturm.sign_vectors([(-1, 10), (-2, 0, 1)], Q(0), Q(1000))
    assert [p.place.low for p in pieces if p.is_root and p.place.low == p.place.high] == [Q(1, 10)]
