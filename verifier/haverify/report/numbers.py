"""Exact numbers as strings, and the decimals that people read beside them."""

from __future__ import annotations

from fractions import Fraction

from haverify.evidence import verdict
from haverify.maths.digits import rational_text
from haverify.maths.exact import people_text
from haverify.report.report import Margin

_DIGITS = 10  # up to so many significant digits are written as they are; longer decimals are rounded


def decimal(q: Fraction) -> str:
    """`q` as a decimal for people, rounded where it is long.

    >>> decimal(Fraction(-106594, 5)), decimal(Fraction(1, 3)), decimal(Fraction(2))
    ('-21318.8', '0.333333', '2')
    """
    return people_text(q, _DIGITS).lstrip("~")


def margin(m: verdict.Margin | None) -> Margin | None:
    """A margin as the report holds it: a rational, or the two ends of an enclosure."""
    if m is None:
        return None
    value = rational_text(m.low) if m.low == m.high else [rational_text(m.low), rational_text(m.high)]
    return Margin(value, decimal((m.low + m.high) / 2), m.unit, m.at)
