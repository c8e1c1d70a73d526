"""Slips in one written number."""

from __future__ import annotations

import pytest

from haverify.maths.exact import parse_decimal
from haverify.repair.slips import slips


def spelled(text: str, kind: str) -> list[str]:
    return [s.text for s in slips(text) if s.kind == kind]


@pytest.mark.parametrize(
    ("text", "signs"),
    [("258.8", ["-258.8"]), ("-8138", ["8138"]), ("+2.8", ["-2.8"]), ("1.09e+04", ["-1.09e+04", "1.09e-04"])],
)
def test_signs(text: str, signs: list[str]) -> None:
    assert spelled(text, "sign") == signs


@pytest.mark.parametrize(
    ("text", "points"),
    [
        ("-.3", ["-3", "-.03"]),
        ("8138", ["81380", "813.8"]),
        ("0.1269", ["1.269", "0.01269"]),
        ("1.09e+04", ["1.09e+05", "1.09e+03"]),
        ("40.61e+04", ["406.1e+04", "4.061e+04"]),
        ("1e0", ["1e1", "1e-1"]),
    ],
)
def test_decimal_places_keep_the_spelling(text: str, points: list[str]) -> None:
    assert spelled(text, "point") == points


def test_digits_are_exchanged_over_the_point_too() -> None:
    assert spelled("1.23", "digits") == ["2.13", "1.32"]
    assert spelled("11", "digits") == []


def test_every_value_comes_once_and_is_another() -> None:
    for text in ("-4.061e+04", "1.01", "100", "+.07"):
        values = [s.value for s in slips(text)]
        assert len(values) == len(set(values))
        assert parse_decimal(text) not in values
        assert all(parse_decimal(s.text) == s.value for s in slips(text))


@pytest.mark.parametrize("text", ["", "p1", "0", "0.00", "1e", "9" * 60, "1e999999999"])
def test_what_is_no_number_or_none_typed_by_hand_has_no_slips(text: str) -> None:
    assert slips(text) == []
