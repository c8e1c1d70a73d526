"""A printed row of coefficients against the least-squares polynomial of the same degree through given samples.

The polynomial is the way such tables were made: raw time, no side conditions, each row by itself. Its coefficients are
rational, since samples are, and computed as such: in raw time the equations are too ill-conditioned for floats.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from haverify.maths.elimination import echelon
from haverify.maths.exact import leading_exponent
from haverify.text.record import record

Q = Fraction

_DIGITS = 4


@record
class Coefficient:
    """A printed coefficient beside the refitted one; `units` is their distance in units of the last printed digit."""

    printed: Q
    refitted: Q
    units: Q

    @property
    def agrees(self) -> bool:
        """Whether rounding the refitted number gives the printed one; one unit more or less is what printing did."""
        return abs(self.units) <= 1

    @property
    def has_other_sign(self) -> bool:
        """Whether it would agree with the other sign."""
        return not self.agrees and abs(self.units + 2 * self.printed / _unit(self.printed)) <= 1


@record
class Row:
    """A refitted row: its coefficients, highest power first, the printed constant added to them, and what was needed.

    `offset` is the mean distance of the samples from the printed coefficients, signs as refitted, rounded as printed:
    what the added constant has to be.
    """

    coefficients: tuple[Coefficient, ...]
    error: Q
    offset: Q


def refit(times: Sequence[Q], angles: Sequence[Q], printed: Sequence[Q], error: Q, digits: int = _DIGITS) -> Row:
    """The row refitted to samples, beside the printed one (highest power first)."""
    exact = least_squares(times, angles, len(printed) - 1)
    pairs = tuple(Coefficient(p, q, (q - p) / _unit(p, digits)) for p, q in zip(printed, reversed(exact), strict=True))
    signed = [-c.printed if c.has_other_sign else c.printed for c in pairs]
    distances = [a - _value(signed, t) for t, a in zip(times, angles, strict=True)]
    return Row(pairs, error, sum(distances, Q(0)) / len(distances))


def least_squares(times: Sequence[Q], angles: Sequence[Q], degree: int) -> tuple[Q, ...]:
    """The coefficients, lowest power first, of the polynomial nearest to some points in the mean square: exactly.

    >>> [str(c) for c in least_squares([Q(0), Q(1), Q(2)], [Q(1), Q(2), Q(4)], 1)]
    ['5/6', '3/2']
    """
    powers = [sum((t**k for t in times), Q(0)) for k in range(2 * degree + 1)]
    equations = []
    for i in range(degree + 1):
        row = {j: powers[i + j] for j in range(degree + 1) if powers[i + j]}
        equations.append((row, sum((a * t**i for t, a in zip(times, angles, strict=True)), Q(0))))
    solved = echelon(equations)
    assert solved is not None
    found = solved.solution({})
    return tuple(found.get(i, Q(0)) for i in range(degree + 1))


def _value(coefficients: Sequence[Q], t: Q) -> Q:
    total = Q(0)
    for c in coefficients:
        total = total * t + c
    return total


def _unit(q: Q, digits: int = _DIGITS) -> Q:
    """A unit of the last of some significant digits."""
    return Q(10) ** (leading_exponent(q) - digits + 1) if q else Q(1, 10**digits)
