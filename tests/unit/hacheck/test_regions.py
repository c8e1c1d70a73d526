"""Region trees and what the checker sees on a region by itself, on small numbers written by hand."""

from fractions import Fraction

import pytest

from hacheck.lines import at_most, choice, denied, difference, join, line, pick, plus
from hacheck.rational import Refused
from hacheck.region_trees import holds_at, shown

X, Y = line(Fraction(0), {"x": Fraction(1)}), line(Fraction(0), {"y": Fraction(1)})
UNIT = {"x": (Fraction(0), Fraction(1)), "y": (Fraction(0), Fraction(1))}
DIAGONAL = [["x", "1"], ["y", "-1"]]


def number(text: str):
    return line(Fraction(text))


def accepts(tree, truth, ranges=UNIT) -> bool:
    try:
        shown(tree, truth, ranges)
    except Refused:
        return False
    return True


def test_an_end_belongs_to_one_side_of_a_split():
    for relation, strict in (("<=", True), ("<", False)):
        beyond = join("or", [at_most(X, number("1/3"), not strict), at_most(number("1/3"), X, strict)])
        assert accepts([relation, [["x", "1"]], "1/3", "t", "t"], beyond)
        gap = join("or", [at_most(X, number("1/3"), True), at_most(number("1/3"), X, True)])
        assert not accepts([relation, [["x", "1"]], "1/3", "t", "t"], gap)


def test_what_is_only_just_true_is_shown_and_what_is_only_just_false_is_not():
    tiny = number("1/1000000000000000000000000000000")
    assert accepts("t", at_most(X, number("1")))
    assert not accepts("t", at_most(X, number("1"), strict=True))
    assert not accepts("t", at_most(plus((1, X), (1, tiny)), number("1")))


def test_many_open_ends_do_not_add_up():
    names = [f"v{k:02}" for k in range(40)]
    lines = [line(Fraction(0), {v: Fraction(10**6)}) for v in names]
    ranges = {v: (Fraction(0), Fraction(1)) for v in names}
    tree = "t"
    for v in reversed(names):
        tree = ["<", [[v, "1"]], "1/2", tree, "t"]
    low = [denied(at_most(n, number("500000"), True)) for n in lines]
    total = plus(*((1, n) for n in lines))
    assert accepts(tree, join("or", [at_most(total, number("20000000"), strict=True), *low]), ranges)
    assert not accepts(tree, join("or", [at_most(total, number("19999999999/1000")), *low]), ranges)


def test_members_of_a_maximum_are_all_needed_and_of_a_minimum_one():
    assert accepts("t", at_most(pick("max", [X, Y]), number("1")))
    assert not accepts("t", at_most(pick("max", [X, plus((2, Y))]), number("1")))
    assert accepts("t", at_most(pick("min", [X, plus((2, Y))]), number("1")))
    assert accepts("t", at_most(pick("min", [X, Y]), pick("max", [Y, X])))
    assert not accepts("t", at_most(pick("max", [X, Y]), pick("min", [X, Y])))


def test_equal_numbers_cancel_with_their_factors():
    m = pick("max", [X, Y])
    assert accepts("t", at_most(plus((Fraction(1, 3), m), (Fraction(-1, 2), m)), number("0")))
    assert not accepts("t", at_most(plus((Fraction(1, 2), m), (Fraction(-1, 3), m)), number("0")))


def test_a_choice_is_one_of_its_numbers_unless_its_condition_is_known():
    picked = choice(at_most(X, number("2")), Y, number("5"))
    assert accepts("t", at_most(picked, number("1")))
    assert not accepts("t", at_most(choice(at_most(X, number("1/2")), Y, number("5")), number("1")))


def test_a_direction_bounds_a_line_with_the_axes():
    assert accepts(["<=", DIAGONAL, "0", "t", "t"], join("or", [at_most(X, Y), at_most(Y, X, True)]))
    steep = at_most(plus((2, X), (-1, Y)), number("1"))  # x <= y and x <= 1 add up to it
    other = at_most(Y, X, True)
    assert accepts(["<=", DIAGONAL, "0", "t", "t"], join("or", [steep, other]))
    assert not accepts(
        ["<=", DIAGONAL, "0", "t", "t"], join("or", [at_most(plus((2, X), (-1, Y)), number("9/10")), other])
    )


def test_an_empty_region_needs_the_right_multipliers():
    tree = ["<=", DIAGONAL, "-2", ["f", [[5, "1"], [0, "1"], [3, "1"]]], "t"]
    truth = at_most(plus((-1, X), (1, Y)), number("2"), strict=True)
    assert accepts(tree, truth)
    assert not accepts([*tree[:3], ["f", [[5, "1"], [0, "1"], [2, "1"]]], "t"], truth)
    assert not accepts(["<=", DIAGONAL, "-1", *tree[3:]], truth)


def test_points_are_valued_exactly():
    n = difference(pick("min", [X, Y]), choice(at_most(X, Y, True), Y, number("1/7")))
    assert holds_at(at_most(n, number("-1/3")), {"x": Fraction(1, 3), "y": Fraction(2, 3)})
    assert not holds_at(at_most(n, number("-1/3"), True), {"x": Fraction(1, 3), "y": Fraction(2, 3)})
    assert holds_at(at_most(n, number("4/21")), {"x": Fraction(1, 3), "y": Fraction(1, 3)})


@pytest.mark.parametrize("terms", [[], [["z", "1"]], [["x", "2"]], [["y", "1"], ["x", "1"]], [["x", "1"], ["y", "0"]]])
def test_a_direction_is_normal(terms):
    assert not accepts(["<=", terms, "0", "t", "t"], at_most(X, number("1")))
