"""Which questions a claim comes down to."""

import pytest
from tests.unit.obligations.texts import condition, parts_of

from haverify.obligations.parts import conjuncts, pushed


def places(claim):
    return [(p.kind, p.where, p.output) for p in parts_of(claim)]


@pytest.mark.parametrize(
    ("claim", "number"),
    [
        ("always x <= 1", 1),
        ("always x <= 1 and x >= 0 and y <= 5", 3),
        ("always at(M) implies (x <= 1 and y <= 5)", 2),
        ("always at(M) implies (x >= 0 implies (x <= 1 and y <= 5))", 2),
        ("always x <= 1 or x >= 2", 1),
        ("never x > 1 or y > 5", 2),
        ("never x > 1 and y > 5", 1),
        ("never (x > 1 implies y > 5)", 2),
    ],
)
def test_conjuncts(claim, number):
    found = conjuncts(pushed(condition(claim)))
    assert len(found) == number
    assert not any(c.op == "and" for c in found) or number == 1


def test_a_premise_goes_with_every_conjunct():
    found = conjuncts(condition("always at(M) implies (x <= 1 and y <= 5)"))
    assert [c.op for c in found] == ["implies", "implies"]
    assert {c.children[0].op for c in found} == {"at"}


@pytest.mark.parametrize("comparison", ["<", "<=", ">", ">=", "==", "!="])
def test_a_negated_comparison_is_one_that_is_false_where_it_is_true(comparison):
    negated = {"<": ">=", "<=": ">", ">": "<=", ">=": "<", "==": "!=", "!=": "=="}
    assert pushed(condition(f"always not x {comparison} 1")).op == negated[comparison]


def test_a_bound_is_a_part_in_every_mode():
    assert places("always y <= 5") == [("dwell", "M", "y"), ("dwell", "N", "y")]


def test_outputs_are_parts_of_their_own():
    assert places("always y <= 5 and x <= 2") == [(k, m, o) for k in ["dwell"] for m in "MN" for o in ("y", "x")]


def test_bounds_on_one_output_are_one_part():
    (first, second) = parts_of("always y <= 5 and y >= -5")
    assert len(first.residuals) == len(second.residuals) == 2


def test_what_concerns_one_mode_is_a_part_there_alone():
    assert places("always at(N) implies y <= 5") == [("dwell", "N", "y")]


def test_what_concerns_jumps_is_a_part_at_each_edge():
    assert places("always jumped implies y - pre(y) <= 5") == [("jump", "M -> N", "y"), ("jump", "N -> M", "y")]


def test_what_concerns_one_edge_is_a_part_there_alone():
    (found,) = parts_of("always jump(up) implies y - pre(y) <= 5")
    assert (found.kind, found.where, found.mode, found.edge) == ("jump", "M -> N", "N", 0)


def test_no_lock_is_a_part_of_every_mode():
    assert places("never stuck") == [("stuck", "M", ""), ("stuck", "N", "")]


def test_a_mode_that_may_not_be_entered_is_a_part_that_is_false():
    (found,) = parts_of("always not at(N)")
    assert (found.where, [r.op for r in found.residuals]) == ("N", ["false"])
