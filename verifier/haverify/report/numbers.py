"""Exact numbers as strings, and the decimals that people read beside them."""

from __future__ import annotations

from fractions import Fraction

from haverify.evidence import verdict
from haverify.maths.digits import rational_text
from haverify.maths.exact import people_text
from haverify.report.report import Margin

_LONG = 8000  # characters of a rational that is still read back
_CLOSE = Fraction(1, 1000)  # relative width up to which an enclosure is told as one number
_DIGITS = 10  # up to so many significant digits are written as they are; longer decimals are rounded


def decimal(q: Fraction) -> str:
    """`q` as a decimal for people, rounded where it is long.

    >>> decimal(Fraction(-106594, 5)), decimal(Fraction(1, 3)), decimal(Fraction(2))
    ('-21318.8', '0.333333', '2')
    """
    return people_text(q, _DIGITS).lstrip("~")


def margin(m: verdict.Margin | None) -> Margin | None:
    """A margin as the report holds it: a rational, or the two ends of an enclosure.

    Its decimal is the middle of these where they nearly agree, else the lower one: the margin is no less.
    """
    if m is None:
        return None
    if m.low == m.high:
        return Margin(rational_text(m.low), decimal(m.low), m.unit, m.at)
    value = [rational_text(m.low), rational_text(m.high)]
    is_close = m.high - m.low <= _CLOSE * max(abs(m.low), abs(m.high))
    return Margin(value, decimal((m.low + m.high) / 2 if is_close else m.low), m.unit, m.at)


def ends(m: Margin) -> tuple[Fraction, Fraction] | None:
    """The ends of a margin's enclosure, the same where it is exact; None where a text is no such number."""
    texts = [m.value] if isinstance(m.value, str) else m.value
    if not 1 <= len(texts) <= 2 or any(len(t) > _LONG for t in texts):
        return None
    try:
        numbers = [Fraction(t) for t in texts]
    except (ValueError, ZeroDivisionError):
        return None
    return (numbers[0], numbers[-1]) if numbers[0] <= numbers[-1] else None


def agreed(low: float, high: float) -> str:
    """A number between two ends to the digits they agree on, or both ends where these are few.

    >>> agreed(1.23456711, 1.23456722), agreed(-1e-9, 1e-9), agreed(1.36, 1.386)
    ('1.234567', '0', '1.36 to 1.386')
    """
    for digits in range(9, 3, -1):
        first, last = (f"{x:.{digits}g}" for x in (low, high))
        if first == last:
            return "0" if float(first) == 0 else first
    if max(abs(low), abs(high)) < 1e-6:
        return "0"
    return f"{low:.5g} to {high:.5g}"
