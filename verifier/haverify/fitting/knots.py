"""Where the phases of a cycle begin, on a clock in seconds with few decimals."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import cached_property

from haverify.text.record import record

Q = Fraction


@record
class Knots:
    """The instants 0 = t0 < t1 < ... < tn at which the n phases begin and the last one ends: decimals, in seconds."""

    at: tuple[Q, ...]

    @cached_property
    def lengths(self) -> tuple[Q, ...]:
        return tuple(b - a for a, b in zip(self.at, self.at[1:], strict=False))

    @property
    def period(self) -> Q:
        return self.at[-1]

    def phase(self, t: Q) -> int:
        """The phase of an instant in [0, period); of a boundary the later one."""
        return max(k for k in range(len(self.lengths)) if self.at[k] <= t)


def knots(shares: Sequence[Q], period: Q) -> Knots:
    """Knots at shares of a period, to a millisecond where this keeps them apart, else to a hundredth of one.

    >>> [str(t) for t in knots([Q(1, 3)], Q("1.23456")).at]
    ['0', '103/250', '6173/5000']
    """
    whole = Q(round(period * 10_000), 10_000)
    unit = 1000 if period > Q(1, 2) else 100_000
    return Knots((Q(0), *(Q(round(q * whole * unit), unit) for q in shares), whole))
