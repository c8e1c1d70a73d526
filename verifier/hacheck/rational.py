"""Exact numbers; a meter bounds all work done with them."""

from __future__ import annotations

import re
from fractions import Fraction

Interval = tuple[Fraction | None, Fraction | None]  # closed; None is infinite

# pi = 16 atan(1/5) - 4 atan(1/239); both arctangent series alternate, so partial sums enclose it.
PI: tuple[Fraction, Fraction] = (
    Fraction(31415926535897932384626433832795028841971, 10**40),
    Fraction(31415926535897932384626433832795028841972, 10**40),
)
MAX_DIGITS, MAX_BITS, MAX_DEGREE = 4000, 60_000, 64


class Unreadable(Exception):
    """The folder is not a report folder: malformed, hostile or missing."""


class Refused(Exception):
    """What should be shown is not shown."""


class Beyond(Refused):
    """Neither shown nor shown wrong: outside the fragment or the work budget of this checker."""


class Meter:
    """Work left, in steps of roughly a microsecond; shared by everything in one call."""

    left = 60_000_000


def spend(steps: int) -> None:
    """Count work, so that no input can keep the checker busy for ever."""
    Meter.left -= steps
    if Meter.left < 0:
        raise Beyond("it needs more work than the checker allows")


_RATIONAL = re.compile(r"-?[0-9]+(/[0-9]+)?", re.ASCII)
_numbers: dict[str, Fraction] = {}


def number(text: object) -> Fraction:
    """The rational a string such as `-106594/5` stands for."""
    if not isinstance(text, str):
        raise Refused("a number is not a rational string")
    if text in _numbers:
        return _numbers[text]
    if len(text) > MAX_DIGITS or not _RATIONAL.fullmatch(text):
        raise Refused(f"{text[:20]!a} is no rational, or too long")
    top, _, bottom = text.partition("/")
    if bottom and not int(bottom):
        raise Refused("a denominator is 0")
    return _numbers.setdefault(text, Fraction(int(top), int(bottom or 1)))
