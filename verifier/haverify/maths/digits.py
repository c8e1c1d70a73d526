"""Rationals as text in lowest terms, of any length."""

from __future__ import annotations

from fractions import Fraction


def rational_text(q: Fraction) -> str:
    """A rational in lowest terms: `5`, `-106594/5`. Any length, whatever Python's limit on digits is."""
    if q.denominator == 1:
        return integer_text(q.numerator)
    return f"{integer_text(q.numerator)}/{integer_text(q.denominator)}"


def integer_text(n: int) -> str:
    """The decimal digits of an integer."""
    try:
        return str(n)
    except ValueError:  # longer than Python converts at once: in two halves
        half = n.bit_length() * 3 // 20  # about half of its decimal digits
        high, low = divmod(abs(n), 10**half)
        return f"{'-' if n < 0 else ''}{integer_text(high)}{integer_text(low).zfill(half)}"
