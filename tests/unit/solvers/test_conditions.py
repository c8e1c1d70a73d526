"""Conditions decided exactly: linear ones, one unknown, several, and the digits of pi."""

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from haverify.elaborate.elaborate import elaborate
from haverify.elaborate.files import Files
from haverify.maths.polynomial import Polynomial, constant, variable
from haverify.model.spec import Spec
from haverify.solvers import univariate, z3
from haverify.solvers.answer import Answer, Contradiction, Holds, Undecided
from haverify.solvers.conditions import Condition, decide
from haverify.solvers.frame import Frame, Scope
from haverify.solvers.linear import Infeasible, Row, solve
from haverify.solvers.literals import Literal
from haverify.syntax.parse import parse
from haverify.text.source import Source

X, Y = variable("x"), variable("y")


def rows(*conditions: tuple[Polynomial, str]) -> list[Row]:
    return [Row(p, relation, frozenset([k])) for k, (p, relation) in enumerate(conditions)]


def number(q: int | Fraction) -> Polynomial:
    return constant(Fraction(q))


def test_strictness_decides_at_a_shared_bound():
    assert solve(rows((X - number(1), "<="), (number(1) - X, "<="))) == {"x": Fraction(1)}
    assert isinstance(solve(rows((X - number(1), "<"), (number(1) - X, "<="))), Infeasible)


def test_the_core_leaves_out_what_is_not_needed():
    answer = solve(rows((Y, "<="), (X - number(1), "<="), (number(2) - X, "<=")))
    assert answer == Infeasible(frozenset([1, 2]))


def test_equations_are_eliminated():
    answer = solve(rows((X + Y - number(3), "=="), (X - Y - number(1), "==")))
    assert answer == {"x": Fraction(2), "y": Fraction(1)}


def test_one_unknown_between_irrational_roots():
    square = X * X
    assert isinstance(
        univariate.solve(rows((square - number(2), "<="), (number(Fraction(14143, 10000)) - X, "<=")), "x"), Infeasible
    )
    found = univariate.solve(rows((square - number(2), "<="), (number(Fraction(14142, 10000)) - X, "<=")), "x")
    assert isinstance(found, dict)


def test_a_root_that_is_no_rational_is_not_shown_as_one():
    assert isinstance(univariate.solve(rows((X * X - number(2), "==")), "x"), Undecided)
    assert isinstance(univariate.solve(rows((X * X + number(1), "==")), "x"), Infeasible)


def test_a_double_root_satisfies_a_closed_condition_only():
    square = (X - number(1)) * (X - number(1))
    assert univariate.solve(rows((square, "<=")), "x") == {"x": Fraction(1)}
    assert isinstance(univariate.solve(rows((square, "<")), "x"), Infeasible)


def test_the_solver_decides_what_is_left_and_says_which_rows_clash():
    circle = X * X + Y * Y - number(1)
    assert z3.solve(rows((Y - number(5), "<="), (circle, "<="), (number(2) - X - Y, "<="))) == Infeasible(
        frozenset([1, 2])
    )


def test_the_solver_stops_at_its_budget():
    hard = X * X * X * Y + Y * Y * Y - X * Y + number(7)
    assert isinstance(z3.solve(rows((hard, "=="), (X * X - Y * Y * Y + number(3), "==")), rlimit=1), Undecided)


coefficient = st.integers(-4, 4)


@settings(max_examples=150, derandomize=True, deadline=None)
@given(
    st.lists(
        st.tuples(coefficient, coefficient, coefficient, st.sampled_from(["<", "<=", "=="])), min_size=1, max_size=6
    )
)
def test_a_point_found_satisfies_the_rows_and_a_core_stays_contradictory(data):
    system = rows(*((X.scaled(Fraction(a)) + Y.scaled(Fraction(b)) + number(c), r) for a, b, c, r in data))
    answer = solve(system)
    if isinstance(answer, dict):
        point = {"x": Fraction(0), "y": Fraction(0), **answer}
        for row in system:
            value = row.poly.value(point)
            assert {"<": value < 0, "<=": value <= 0, "==": value == 0}[row.relation]
    else:
        assert isinstance(answer, Infeasible)
        assert isinstance(solve([system[k] for k in sorted(answer.core)]), Infeasible)


@settings(max_examples=100, derandomize=True, deadline=None)
@given(st.lists(st.tuples(coefficient, coefficient, coefficient, st.sampled_from(["<", "<="])), min_size=1, max_size=3))
def test_one_unknown_agrees_with_a_grid(data):
    system = rows(*((X * X.scaled(Fraction(a)) + X.scaled(Fraction(b)) + number(c), r) for a, b, c, r in data))
    answer = univariate.solve(system, "x")
    grid = [Fraction(k, 8) for k in range(-80, 81)]
    met = [x for x in grid if all((v := r.poly.value({"x": x})) < 0 or (v == 0 and r.relation == "<=") for r in system)]
    if isinstance(answer, Infeasible):
        assert met == []
    if isinstance(answer, dict):
        values = [(r.poly.value(answer), r.relation) for r in system]
        assert all(v < 0 or (v == 0 and relation == "<=") for v, relation in values)


def decided(declaration: str, condition: str, *extra: Literal) -> Answer:
    """The answer for a condition on a param, beside literals."""
    source = Source.of_text("t.ha", f'spec "t" version "1.0"\n{declaration}\nproperty p {{ holds {condition} }}')
    spec: Spec | None = elaborate(parse(source)[0], Files({source.path: source}))[0]
    assert spec is not None
    return decide([Condition(spec.claims[0].goals[0].condition, Frame(Scope(spec, None)))], extra)


@pytest.mark.parametrize(("bound", "is_possible"), [("3.14159", False), ("3.1416", True)])
def test_pi_is_used_through_rationals_around_it(bound, is_possible):
    answer = decided(f"param a: rad in [0 rad, {bound} rad]", "a >= 180 deg")
    assert isinstance(answer, Holds if is_possible else Contradiction)


@pytest.mark.parametrize("relation", ["<", "<=", "==", "!="])
@pytest.mark.parametrize("value", [-1, 0, 1])
def test_a_comparison_of_numbers_decides_beside_any_condition(relation, value):
    holds = {"<": value < 0, "<=": value <= 0, "==": value == 0, "!=": value != 0}[relation]
    answer = decided("param a: 1 in [0, 1]", "a >= 0", Literal(number(value), relation, None))
    assert isinstance(answer, Holds if holds else Contradiction)
