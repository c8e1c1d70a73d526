"""Proofs that premises have no common point: hacheck accepts them, and there are none where there is a point."""

from fractions import Fraction
from time import process_time

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hacheck.functions import Functions as CheckedFunctions
from hacheck.positivity import Premises as Checked
from hacheck.positivity import formula
from hacheck.positivity import refute as check
from haverify.maths.polynomial import Polynomial, constant, variable
from haverify.obligations.formula import Formula, compare, disjunction
from haverify.obligations.functions import Functions
from haverify.obligations.premises import Premises, formula_json
from haverify.solvers.positivity.levels import MONOMIALS, NUMBERS, PAIRS, SQUARES
from haverify.solvers.positivity.refute import Effort, Proof, refute

X, Y = variable("x"), variable("y")


def n(value: int | str) -> Polynomial:
    return constant(Fraction(value))


def shown(*entries: Formula) -> Proof | None:
    """A proof, which hacheck accepts."""
    premises = Premises(Functions()).with_(*entries)
    proof = refute(premises, Effort((NUMBERS, MONOMIALS, SQUARES, PAIRS), process_time() + 10))
    if proof is not None:
        check(proof, Checked(CheckedFunctions(), [formula(formula_json(e)) for e in premises.entries]))
    return proof


DISC = compare("<=", X * X + Y * Y - n(1))
APART = [
    pytest.param([compare(">=", X - n(1)), compare("<=", X + Y), compare(">", Y + n(1))], id="Farkas"),
    pytest.param([DISC, compare(">=", X + Y - n(2))], id="a disc and a line"),
    pytest.param([compare("<", X * X - (X * Y).scaled(Fraction(2)) + Y * Y)], id="a square below 0"),
    pytest.param([compare("==", X * Y - n(1)), compare("==", X)], id="equations"),
    pytest.param([compare("==", X - Y), compare(">", X * X - Y * Y)], id="an equation to put in"),
    pytest.param([DISC, disjunction([compare(">", X - n(2)), compare("<", Y + n(3))])], id="cases"),
    pytest.param([compare("!=", X), compare("<=", X * X)], id="not 0"),
    pytest.param([compare("<=", (X - n(100)) ** 2 - n("1/100")), compare(">", X - n(101))], id="far from 0"),
]


@pytest.mark.parametrize("entries", APART)
def test_no_common_point(entries: list[Formula]) -> None:
    assert shown(*entries) is not None


POINT = st.integers(min_value=-3, max_value=3)


@settings(max_examples=20, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow])
@given(POINT, POINT, st.lists(st.tuples(POINT, POINT, POINT, st.sampled_from(["<=", "<", "=="])), max_size=4))
def test_nothing_is_shown_where_there_is_a_point(x: int, y: int, found: list[tuple[int, int, int, str]]) -> None:
    """Premises that hold at (x, y) have a common point."""
    entries = []
    for a, b, c, op in found:
        p = n(a) * X * X + n(b) * X * Y + n(c) * Y
        value = p.value({"x": Fraction(x), "y": Fraction(y)})
        entries.append(compare(op, p - constant(value) - (n(1) if op == "<" else n(0))))
    assert shown(*entries) is None
