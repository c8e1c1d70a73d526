"""Exact rationals: reading and printing of decimals, limits on their size, rationals scaled by powers of pi."""

from __future__ import annotations

import re
from fractions import Fraction
from functools import lru_cache

from haverify.text.record import record

MAX_BITS = 14_000
"""No numerator or denominator is longer: such a number has fewer than 4,300 decimal digits and always prints."""

_DECIMAL = re.compile(r"\s*([+-]?)(\d*)(?:\.(\d*))?(?:[eE]([+-]?\d+))?\s*", re.ASCII)
_POWERS = tuple(10**k for k in range(40))


def fits(q: Fraction) -> bool:
    """Whether numerator and denominator are within `MAX_BITS`."""
    return q.numerator.bit_length() <= MAX_BITS and q.denominator.bit_length() <= MAX_BITS


def parse_decimal(text: str) -> Fraction | None:
    """The rational that `text` (`-.2`, `+2.8`, `1.14e+04`) stands for; None when it is no number or too long."""
    m = _DECIMAL.fullmatch(text)
    if m is None or not (m[2] or m[3]):
        return None
    whole, part = m[2], m[3] or ""
    if len(whole) + len(part) > 4200 or len(m[4] or "") > 6:
        return None
    digits, exponent = int(whole + part), int(m[4] or 0) - len(part)
    if abs(exponent) > 4200:
        return Fraction(0) if digits == 0 else None
    q = _shift(-digits if m[1] == "-" else digits, exponent)
    return q if fits(q) else None


def is_decimal(text: str) -> bool:
    """Whether `text` is written as a number, of whatever size."""
    m = _DECIMAL.fullmatch(text)
    return m is not None and bool(m[2] or m[3])


def _shift(digits: int, exponent: int) -> Fraction:
    if exponent >= 0:
        return Fraction(digits * _power_of_ten(exponent))
    return Fraction(digits, _power_of_ten(-exponent))


def _power_of_ten(k: int) -> int:
    return _POWERS[k] if k < len(_POWERS) else int(10**k)


def decimal_text(q: Fraction) -> str | None:
    """The finite decimal that equals `q`, or None; no exponent, no superfluous zeros."""
    d = q.denominator
    twos = (d & -d).bit_length() - 1
    d >>= twos
    fives = 0
    while d % 5 == 0:
        d //= 5
        fives += 1
    if d != 1:
        return None
    places = max(twos, fives)
    digits = str(abs(q.numerator) * 10**places // q.denominator).rjust(places + 1, "0")
    sign = "-" if q < 0 else ""
    return sign + (digits if places == 0 else f"{digits[:-places]}.{digits[-places:]}")


def people_text(q: Fraction, digits: int = 12) -> str:
    """`q` for reading: exact where a decimal of at most `digits` digits says it, else rounded and marked by `~`."""
    exact = decimal_text(q) if q.denominator.bit_length() < 4 * digits + 8 else None
    if exact is not None and len(exact.lstrip("-0.").replace(".", "")) <= digits and len(exact) <= digits + 4:
        return exact
    return "~" + _rounded(q, min(digits, 6))


def _rounded(q: Fraction, digits: int) -> str:
    if q == 0:
        return "0"
    e = leading_exponent(q)
    mantissa = str(_nearest(abs(q.numerator), q.denominator, digits - 1 - e))
    if len(mantissa) > digits:
        mantissa, e = mantissa[:-1], e + 1
    sign = "-" if q < 0 else ""
    if -5 <= e < digits:
        whole, part = (mantissa[: e + 1], mantissa[e + 1 :]) if e >= 0 else ("0", "0" * (-e - 1) + mantissa)
        part = part.rstrip("0")
        return f"{sign}{whole}.{part}" if part else sign + whole
    return f"{sign}{mantissa[0]}.{mantissa[1:].rstrip('0') or '0'}e{e}"


def _nearest(n: int, d: int, k: int) -> int:
    """The integer nearest to `n / d * 10^k`, the even one of two."""
    if k >= 0:
        n *= _power_of_ten(k)
    else:
        d *= _power_of_ten(-k)
    below, rest = divmod(n, d)
    return below + (2 * rest > d or (2 * rest == d and below & 1))


def significant(q: Fraction) -> str:
    """`q` to six significant digits, for reading; a number too large or small for a float as well."""
    try:
        near = float(q)
    except OverflowError:
        near = 0.0
    return f"{near:.6g}" if near or q == 0 else _rounded(q, 6)


def leading_exponent(q: Fraction) -> int:
    """The exponent of ten of the first significant digit of `q`, which is not 0."""
    n, d = abs(q.numerator), q.denominator
    e = (n.bit_length() - d.bit_length()) * 30103 // 100000
    while _at_least(n, d, e + 1):
        e += 1
    while not _at_least(n, d, e):
        e -= 1
    return e


def _at_least(n: int, d: int, e: int) -> bool:
    return bool(n >= d * 10**e) if e >= 0 else bool(n * 10**-e >= d)


def rounding_half(q: Fraction, digits: int) -> Fraction | None:
    """Half a unit of the `digits`-th significant digit of `q`; None for 0, which has no significant digit."""
    if q == 0:
        return None
    return _half_unit(leading_exponent(q) - digits + 1)


@lru_cache(maxsize=256)
def _half_unit(exponent: int) -> Fraction:
    return Fraction(10) ** exponent / 2


@record
class PiRational:
    """`rational * pi^power`."""

    rational: Fraction
    power: int = 0

    def __mul__(self, other: PiRational) -> PiRational:
        return PiRational(self.rational * other.rational, self.power + other.power)

    def __truediv__(self, other: PiRational) -> PiRational:
        return PiRational(self.rational / other.rational, self.power - other.power)
