"""What is left of a condition in a mode or at an edge."""

import pytest
from tests.unit.obligations.texts import condition

from haverify.obligations.residual import Situation, residual

M, N = Situation("M"), Situation("N")
UP = Situation("N", "M", "up")


@pytest.mark.parametrize(
    ("claim", "at", "left"),
    [
        ("always at(M)", M, "true"),
        ("always at(M)", N, "false"),
        ("always not at(M)", M, "false"),
        ("always jumped", M, "false"),
        ("always jumped", UP, "true"),
        ("always jump(up)", N, "false"),
        ("always jump(up)", UP, "true"),
        ("always jump(down)", UP, "false"),
        ("always jumped implies pre(at(M))", UP, "true"),
        ("always jumped implies pre(at(N))", UP, "false"),
        ("always at(M) and x <= 1", N, "false"),
        ("always at(M) and x <= 1", M, "<="),
        ("always at(M) or x <= 1", M, "true"),
        ("always at(M) or x <= 1", N, "<="),
        ("always at(M) implies x <= 1", N, "true"),
        ("always at(M) implies x <= 1", M, "<="),
        ("always x <= 1 implies at(M)", M, "true"),
        ("always x <= 1 implies at(M)", N, "not"),
        ("always x <= 1 implies y <= 1", M, "implies"),
        ("always not (at(M) and x <= 1)", M, "not"),
    ],
)
def test_what_is_decided_is_folded(claim, at, left):
    assert residual(condition(claim), at).op == left


def test_of_a_choice_the_branch_of_the_mode_is_left():
    e = condition("always x <= (if at(M) then 1 else 2)")
    assert residual(e, M) == condition("always x <= 1")
    assert residual(e, N) == condition("always x <= 2")


def test_the_value_before_is_the_value_where_there_was_no_jump():
    e = condition("always y - pre(y) <= 1")
    assert residual(e, M) == condition("always y - y <= 1")
    assert residual(e, UP) == e


def test_a_jump_just_before_a_jump_is_not_remembered():
    e = condition("always not (jumped and pre(jumped))")
    assert residual(e, UP).op == "true"


def test_nothing_is_left_to_decide_twice():
    e = condition("always (at(M) implies x <= 1) and (jumped implies y <= 5)")
    for at in (M, N, UP):
        assert residual(residual(e, at), at) == residual(e, at)
