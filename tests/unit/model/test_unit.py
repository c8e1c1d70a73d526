"""Units: texts, conversions, and the policy on angles."""

from fractions import Fraction

import pytest

from haverify.model.unit import ONE, RADIAN, NamedUnit, Unit, coherent, conversion, is_compatible, parse_unit, power


def unit(text: str) -> Unit:
    found = parse_unit(text)
    assert found is not None
    return found


@pytest.mark.parametrize(
    ("source", "target", "factor"),
    [
        ("deg", "rad", (Fraction(1, 180), 1)), ("rad", "deg", (Fraction(180), -1)), ("rad", "1", (Fraction(1), 0)),
        ("km/h", "m/s", (Fraction(5, 18), 0)), ("N", "kg.m/s^2", (Fraction(1), 0)), ("Hz", "1/s", (Fraction(1), 0)),
        ("%", "1", (Fraction(1, 100), 0)), ("deg/s^2", "rad/s^2", (Fraction(1, 180), 1)),
        ("min", "ms", (Fraction(60000), 0)),
    ],
)  # fmt: skip
def test_conversion(source: str, target: str, factor: tuple[Fraction, int]) -> None:
    assert conversion(unit(source), unit(target)) == factor


@pytest.mark.parametrize(("a", "b"), [("deg", "1"), ("m", "s"), ("deg/s", "Hz"), ("deg^2", "rad"), ("m.deg", "m")])
def test_what_does_not_convert(a: str, b: str) -> None:
    assert conversion(unit(a), unit(b)) is None
    assert not is_compatible(unit(b), unit(a))


def test_degrees_divided_by_an_angle_are_plain() -> None:
    assert conversion(unit("deg") / RADIAN, ONE) == (Fraction(1, 180), 1)
    assert unit("deg") / unit("deg") is ONE


@pytest.mark.parametrize("text", ["deg/s^4", "kg.m^2/s", "s^-1", "N.s/m", "Pa", "1", "m^3/s^2", "deg/s^9/s^3", "Nm"])
def test_text_is_read_as_the_same_unit(text: str) -> None:
    assert unit(text).text == text


def test_the_same_product_has_one_text() -> None:
    assert unit("m.kg/s^2").text == unit("kg.m/s/s").text == "kg.m/s^2"
    assert unit("1/s") is unit("s^-1")


def test_units_of_the_file() -> None:
    rpm = NamedUnit("rpm", Fraction(1, 30), 1, (("rad", 1), ("s", -1)), False)
    found = parse_unit("rpm", (rpm,))
    assert found is not None
    assert conversion(found, unit("deg/s")) == (Fraction(6), 0)
    assert conversion(found, unit("Hz")) is None
    assert found.is_writable and not (found / unit("s")).is_writable


@pytest.mark.parametrize("text", ["", "m/", "/m", "m..s", "furlong", "m-s"])
def test_no_units(text: str) -> None:
    assert parse_unit(text) is None


def test_roots() -> None:
    assert power(unit("m^2/s^2"), Fraction(1, 2)) == unit("m/s")
    assert power(coherent(unit("km")), Fraction(1, 2)).dimensions == (("m", Fraction(1, 2)),)
