"""Slips of the pen in one written number: a sign, a decimal point, two digits in the wrong order."""

from __future__ import annotations

import re
from collections.abc import Iterator
from fractions import Fraction
from itertools import pairwise

from haverify.maths.exact import parse_decimal
from haverify.text.record import record

_NUMBER = re.compile(r"([+-]?)(\d*)(\.?)(\d*)(?:([eE])([+-]?)(\d+))?", re.ASCII)
_LONGEST = 40  # digits; what is longer was not typed by hand


@record
class Slip:
    """Another spelling of a number, and its value."""

    kind: str
    text: str
    value: Fraction


@record
class _Numeral:
    sign: str
    whole: str
    part: str
    e: str
    e_sign: str
    e_digits: str

    @property
    def exponent(self) -> str:
        return f"{self.e}{self.e_sign}{self.e_digits}"


def slips(text: str) -> list[Slip]:
    """The numbers that differ from `text` by one slip, each value once, likelier kinds first.

    Example
    -------
    >>> [s.text for s in slips("-.3")]
    ['.3', '-3', '-.03']
    >>> [s.text for s in slips("1.09e+04") if s.kind == "digits"]
    ['0.19e+04', '1.90e+04']
    """
    numeral, own = _read(text), parse_decimal(text)
    if numeral is None or own is None or own == 0:
        return []
    found: dict[Fraction, Slip] = {}
    for kind, spelled in (*_signs(numeral), *_points(numeral), *_digits(numeral)):
        value = parse_decimal(spelled)
        if value is not None and value != own and value not in found:
            found[value] = Slip(kind, spelled, value)
    return list(found.values())


def _read(text: str) -> _Numeral | None:
    m = _NUMBER.fullmatch(text)
    if m is None or not (m[2] or m[4]) or len(m[2]) + len(m[4]) > _LONGEST:
        return None
    return _Numeral(m[1], m[2], m[4], m[5] or "", m[6] or "", m[7] or "")


def _signs(n: _Numeral) -> Iterator[tuple[str, str]]:
    yield "sign", ("" if n.sign == "-" else "-") + _spelled(n.whole, n.part) + n.exponent
    if n.e:
        other = "+" if n.e_sign == "-" else "-"
        yield "sign", f"{n.sign}{_spelled(n.whole, n.part)}{n.e}{other}{n.e_digits}"


def _points(n: _Numeral) -> Iterator[tuple[str, str]]:
    """Ten times as much, then a tenth; in the exponent where the mantissa has its usual form."""
    if n.e and len(n.whole.lstrip("0")) == 1:
        power = int(n.e_sign + n.e_digits) if len(n.e_digits) < 5 else 0
        for shifted in (power + 1, power - 1):
            sign = "-" if shifted < 0 else "+" if n.e_sign else ""
            digits = str(abs(shifted)).rjust(len(n.e_digits), "0")
            yield "point", f"{n.sign}{_spelled(n.whole, n.part)}{n.e}{sign}{digits}"
        return
    yield "point", n.sign + _spelled(*_up(n.whole, n.part)) + n.exponent
    yield "point", n.sign + _spelled(*_down(n.whole, n.part)) + n.exponent


def _up(whole: str, part: str) -> tuple[str, str]:
    moved = (whole + (part[:1] or "0")).lstrip("0")
    return moved or "0", part[1:]


def _down(whole: str, part: str) -> tuple[str, str]:
    return whole[:-1] or ("0" if whole else ""), (whole[-1:] or "0") + part


def _spelled(whole: str, part: str) -> str:
    """A mantissa; zeros that a moved point leaves behind the last digit are dropped where nothing else is there."""
    if not part.strip("0") and whole:
        part = ""
    return f"{whole}.{part}" if part else whole


def _digits(n: _Numeral) -> Iterator[tuple[str, str]]:
    """Neighbouring digits exchanged, over the point too."""
    row, point = n.whole + n.part, len(n.whole)
    for k, (a, b) in enumerate(pairwise(row)):
        if a != b:
            turned = row[:k] + b + a + row[k + 2 :]
            part = turned[point:]
            mantissa = f"{turned[:point]}.{part}" if part else turned
            yield "digits", n.sign + mantissa + n.exponent
