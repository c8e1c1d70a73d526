"""Laws of units: a group of products, conversions that compose, texts that read back."""

from fractions import Fraction

from hypothesis import given, settings
from hypothesis import strategies as st

from haverify.model.unit import BUILTIN, ONE, RADIAN, Unit, conversion, is_compatible, named, parse_unit, power

LAW = settings(max_examples=150, deadline=None, derandomize=True)
NAMED = st.sampled_from(sorted(BUILTIN)).map(lambda n: named(BUILTIN[n]))


@st.composite
def units(draw: st.DrawFn) -> Unit:
    made = ONE
    for u in draw(st.lists(NAMED, max_size=4)):
        made = made * power(u, draw(st.integers(-3, 3)))
    return made


@LAW
@given(units(), units(), units())
def test_products(a: Unit, b: Unit, c: Unit) -> None:
    assert a * b is b * a
    assert (a * b) * c is a * (b * c)
    assert a / a is ONE and a * ONE is a
    assert power(a * b, 2) is power(a, 2) * power(b, 2)


@LAW
@given(units())
def test_text_reads_back(a: Unit) -> None:
    assert parse_unit(a.text) is a


@LAW
@given(units(), units(), units())
def test_conversions_compose(a: Unit, b: Unit, c: Unit) -> None:
    b, c = a * (b / b), a * (c / c) * named(BUILTIN["km"]) / named(BUILTIN["m"])
    there, back = conversion(a, c), conversion(c, a)
    assert there is not None and back is not None
    assert there[0] * back[0] == 1 and there[1] + back[1] == 0
    assert conversion(a, b) == (Fraction(1), 0)


@LAW
@given(units(), units())
def test_compatibility_is_symmetric_and_kept_by_products(a: Unit, b: Unit) -> None:
    assert is_compatible(a, b) == is_compatible(b, a)
    if is_compatible(a, b):
        assert is_compatible(a * a, b * b)


@LAW
@given(units())
def test_radians_change_nothing_and_degrees_do(a: Unit) -> None:
    assert is_compatible(a, a * RADIAN) == (not a.has_scaled_angle)
    assert not is_compatible(a, a * named(BUILTIN["deg"])) or a.has_scaled_angle
