"""Intervals by example: ends, faults, and the floating-point unit."""

import ctypes
import math
import platform
import struct
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from fractions import Fraction

import pytest

from haverify.maths.interval import Fault, Interval, enclose

UNIT = Interval(-1.0, 1.0)
HUGE = 10**400


def test_ends_are_floats() -> None:
    with pytest.raises(TypeError, match="between"):
        Interval(1, 2)
    with pytest.raises(TypeError, match="between"):
        Interval(0.0, Fraction(1, 3))  # type: ignore[arg-type]


def test_exact_ends_are_enclosed() -> None:
    third = Interval.between(Fraction(1, 3), 2**53 + 1)
    assert third.contains(Fraction(1, 3)) and third.contains(2**53 + 1)
    assert third.low == math.nextafter(1 / 3, 0) or Fraction(third.low) < Fraction(1, 3)


def test_a_float_is_its_own_enclosure() -> None:
    assert Interval.at(0.1) == Interval(0.1, 0.1)
    assert not Interval.at(0.1).contains(Fraction(1, 10))


def test_a_rational_lies_between_neighbours() -> None:
    tenth = enclose(Fraction(1, 10))
    assert tenth.contains(Fraction(1, 10))
    assert math.nextafter(tenth.low, 1) == tenth.high


def test_integers_past_the_digit_limit_of_python_are_enclosed() -> None:
    assert enclose(Fraction(10**9000 + 1, 10**9000)).exactly()[0] == 1
    with pytest.raises(Fault, match="largest float"):
        enclose(Fraction(HUGE))
    assert enclose(Fraction(1, HUGE)).low == 0.0 < enclose(Fraction(1, HUGE)).high


def test_operators_take_exact_numbers_and_enclose_them() -> None:
    assert (1 - Interval(0.25, 0.5)) == Interval(0.5, 0.75)
    assert (Fraction(1, 3) * Interval.at(3)).contains(1)
    assert (1 / Interval(2.0, 4.0)) == Interval(0.25, 0.5)
    assert 2 + Interval(1.0, 1.0) + 0.5 == Interval(3.5, 3.5)


def test_set_operations() -> None:
    a, b = Interval(0.0, 2.0), Interval(1.0, 3.0)
    assert a.hull(b) == Interval(0.0, 3.0)
    assert a.intersection(b) == Interval(1.0, 2.0)
    assert a.minimum(b) == a and a.maximum(b) == b
    assert a.hull(b).encloses(a) and not a.encloses(b)
    assert (a.width, a.midpoint) == (2.0, 1.0)


@pytest.mark.parametrize(
    "operation",
    [
        lambda: Interval(2.0, 1.0),
        lambda: Interval.between(Fraction(2), Fraction(1)),
        lambda: Interval(math.nan, 1.0),
        lambda: Interval(0.0, math.inf),
        lambda: Interval.at(math.nan),
        lambda: Interval(0.0, 1.0).intersection(Interval(2.0, 3.0)),
        lambda: 1 / UNIT,
        lambda: UNIT / Interval(0.0, 0.0),
        lambda: UNIT**-1,
        lambda: Interval(1.0, 2.0) ** (2**70),
        lambda: Interval(1e308, 1e308) * 10,
        lambda: Interval(-1e308, 1e308).width,
        lambda: Interval(0.0, 710.0).exp(),
        lambda: Interval(0.0, 711.0).cosh(),
        lambda: Interval(0.0, 1.0).log(),
        lambda: UNIT.sqrt(),
        lambda: Interval(0.0, 1.0000000000000002).asin(),
        lambda: Interval(-1.0000000000000002, 0.0).acos(),
        lambda: Interval(1.5, 1.6).tan(),
        lambda: UNIT + HUGE,
    ],
)
def test_what_has_no_enclosure_is_a_fault(operation: Callable[[], object]) -> None:
    with pytest.raises(Fault):
        operation()


def test_sines_of_huge_arguments_are_anything() -> None:
    assert Interval.at(1e300).sin() == UNIT
    assert Interval(-1e300, 1e300).cos() == UNIT


def test_known_values_are_exact() -> None:
    zero = Interval(0.0, 0.0)
    assert zero.sin() == zero.tan() == zero.asin() == zero.atan() == zero.sinh() == zero.tanh() == zero
    assert zero.exp() == zero.cos() == zero.cosh() == zero**0 == Interval(1.0, 1.0)
    assert Interval(1.0, 1.0).log() == Interval(1.0, 1.0).acos() == zero


@contextmanager
def environment_word(change: Callable[[bytearray], None]) -> Iterator[None]:
    """The floating-point environment with its stored form changed, restored afterwards."""
    libm = ctypes.CDLL("libm.so.6")
    saved = ctypes.create_string_buffer(64)
    libm.fegetenv(saved)
    changed = bytearray(saved.raw)
    change(changed)
    libm.fesetenv(ctypes.create_string_buffer(bytes(changed), 64))
    try:
        yield
    finally:
        libm.fesetenv(saved)


def set_bits(offset: int, bits: int) -> Callable[[bytearray], None]:
    def change(stored: bytearray) -> None:
        (word,) = struct.unpack_from("<I", stored, offset)
        struct.pack_into("<I", stored, offset, word | bits)

    return change


# Where glibc's fenv_t keeps the control word, and its bits: upward, downward, towards zero, flush to zero.
CONTROL = {
    "x86_64": (28, (0x4000, 0x2000, 0x6000, 0x8000, 0x0040)),
    "aarch64": (0, (1 << 22, 2 << 22, 3 << 22, 1 << 24)),
}
OFFSET, SETTINGS = CONTROL[platform.machine()]


@pytest.mark.parametrize("bits", SETTINGS)
def test_a_foreign_floating_point_setting_is_refused(bits: int) -> None:
    one = Interval(1.0, 1.0)
    found: BaseException | None = None
    with environment_word(set_bits(OFFSET, bits)):
        try:
            one.exp()
        except Fault as fault:
            found = fault
    assert "round to nearest" in str(found)
    assert one.exp().contains(Fraction(2718281828459045, 10**15))
