"""Exact numbers: reading, printing, rounding half-widths."""

from fractions import Fraction

import pytest

from haverify.maths.exact import PiRational, decimal_text, parse_decimal, people_text, rounding_half, significant


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("0.1", Fraction(1, 10)), ("+2.8", Fraction(14, 5)), ("-.2", Fraction(-1, 5)), ("1.14e+04", Fraction(11400)),
        ("5.", Fraction(5)), (" 7 ", Fraction(7)), ("1e-3", Fraction(1, 1000)), ("0e99999", Fraction(0)),
    ],
)  # fmt: skip
def test_decimals_are_read(text: str, value: Fraction) -> None:
    assert parse_decimal(text) == value


@pytest.mark.parametrize("text", ["", ".", "x", "1,5", "1e999999999", "1e5000", "9" * 5000, "0x10", "nan", "٣", "1e"])
def test_what_is_no_number_or_too_long(text: str) -> None:
    assert parse_decimal(text) is None


def test_decimals_are_printed() -> None:
    assert decimal_text(Fraction(-40610)) == "-40610"
    assert decimal_text(Fraction(-1, 80)) == "-0.0125"
    assert decimal_text(Fraction(1, 3)) is None


def test_numbers_for_people_say_when_they_are_rounded() -> None:
    assert people_text(Fraction(2006656, 100000)) == "20.06656"
    assert people_text(Fraction(1, 3)) == "~0.333333"
    assert people_text(Fraction(-2, 3) * 10**9) == "~-6.66667e8"
    assert people_text(Fraction(29999999, 30000001)) == "~1"


def test_half_a_unit_of_the_last_digit() -> None:
    assert rounding_half(Fraction(-40610), 4) == 5
    assert rounding_half(Fraction("642.3"), 4) == Fraction(1, 20)
    assert rounding_half(Fraction("0.0999"), 2) == Fraction(1, 2000)
    assert rounding_half(Fraction(0), 4) is None


def test_pi_rationals_multiply() -> None:
    assert PiRational(Fraction(1, 180), 1) * PiRational(Fraction(180), -1) == PiRational(Fraction(1), 0)
    assert PiRational(Fraction(2), 1) / PiRational(Fraction(4), 1) == PiRational(Fraction(1, 2), 0)


def test_numbers_beyond_floats_are_shown_as_well() -> None:
    shown = [
        significant(q) for q in (Fraction(10) ** 400, -(Fraction(10) ** 400) / 3, Fraction(1, 10**400), Fraction(0))
    ]
    assert shown == ["1.0e400", "-3.33333e399", "1.0e-400", "0"]
