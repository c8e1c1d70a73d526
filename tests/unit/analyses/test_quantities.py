"""The facts beside a violated part speak of what the claim compares."""

from tests.unit.analyses.models import X, Y, always, claim, n, op, schedule, spec

from haverify.analyses.portfolio import decide_all
from haverify.model.expression import Expr


def facts(condition):
    found = decide_all(spec(schedule([[0, 0, 1], [3, 2]]), claim("c", always(condition))))["c"]
    return [fact for p in found.parts for fact in p.facts]


def test_the_range_of_an_output_with_both_instants():
    assert facts(op("<=", Y, n("0.5"))) == [
        "y runs from 0 (at x = 0) to 1 (at x = 1)",
        "y runs from 5 (at x = 1) to 7 (at x = 2)",
    ]


def test_a_derivative_is_not_its_output():
    assert facts(op("<=", op("abs", op("der", Y)), n(1))) == [
        "der(y) runs from 0 (at x = 0) to 2 (at x = 1)",
        "der(y) is 2",
    ]


def test_a_jump_is_described_by_its_step():
    condition = op("implies", Expr("jumped"), op("<=", op("abs", op("-", Y, op("pre", Y))), n(1)))
    assert facts(condition) == ["y - pre(y) is 4 at x = 1", "y - pre(y) is -7 at x = 2"]


def test_only_the_sides_that_move_are_described():
    assert facts(op("<=", n(0), op("-", n("1.5"), X))) == ["1.5 - x runs from -0.5 (at x = 2) to 0.5 (at x = 1)"]
