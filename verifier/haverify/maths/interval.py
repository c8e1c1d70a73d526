"""Outward-rounded intervals: the kernel's numbers with a Python face, and the only door to them.

An `Interval` has float ends and is read as the set of reals between them. Every operation encloses the exact result
for all points of its operands. Where no enclosure exists (a divisor that may be zero, an argument that may leave the
domain, an end beyond the largest float, nothing in common), `Fault` is raised, never a number returned.
Importing this module raises `ToolError` if the kernel is missing or was built from other sources.
"""

from __future__ import annotations

from fractions import Fraction

from haverify.errors import ToolError
from haverify.maths.freshness import require_fresh
from haverify.text.record import record

try:
    from haverify import _kernel
except ImportError as missing:
    raise ToolError("the kernel haverify._kernel is not built: run `make`") from missing

require_fresh(_kernel.source_hash())

Fault = _kernel.Fault
Exact = int | Fraction


@record
class Interval:
    """The reals between two finite floats, ends included.

    Example
    -------
    >>> Interval(1.0, 2.0) * Interval(-3.0, 4.0)
    Interval(low=-6.0, high=8.0)
    """

    low: float
    high: float

    def __post_init__(self) -> None:
        if not (isinstance(self.low, float) and isinstance(self.high, float)):
            raise TypeError("the ends of an interval are floats; `Interval.between` encloses exact ones")
        low, high = _kernel.interval(self.low, self.high)
        object.__setattr__(self, "low", low)
        object.__setattr__(self, "high", high)

    @classmethod
    def at(cls, number: Exact | float) -> Interval:
        """Enclose one number; a float stands for itself."""
        if isinstance(number, float):
            return cls(number, number)
        return enclose(Fraction(number))

    @classmethod
    def between(cls, low: Exact | float, high: Exact | float) -> Interval:
        """Enclose all reals from one number to another, given in order."""
        if low > high:
            raise Fault("the interval is empty")
        return cls(cls.at(low).low, cls.at(high).high)

    @property
    def width(self) -> float:
        """At least `high - low`, and the next float at most."""
        return _kernel.width((self.low, self.high))

    @property
    def midpoint(self) -> float:
        """A float of the interval, near its middle."""
        return _kernel.midpoint((self.low, self.high))

    def exactly(self) -> tuple[Fraction, Fraction]:
        """The ends as the rationals they are."""
        return Fraction(self.low), Fraction(self.high)

    def contains(self, number: Exact | float) -> bool:
        """True if the number lies between the ends, compared exactly."""
        return self.low <= number <= self.high

    def encloses(self, other: Interval) -> bool:
        """True if every point of `other` is a point of this interval."""
        return self.low <= other.low and other.high <= self.high

    def __add__(self, other: Interval | Exact | float) -> Interval:
        return _binary("add", self, other)

    def __radd__(self, other: Exact | float) -> Interval:
        return _binary("add", other, self)

    def __sub__(self, other: Interval | Exact | float) -> Interval:
        return _binary("sub", self, other)

    def __rsub__(self, other: Exact | float) -> Interval:
        return _binary("sub", other, self)

    def __mul__(self, other: Interval | Exact | float) -> Interval:
        return _binary("mul", self, other)

    def __rmul__(self, other: Exact | float) -> Interval:
        return _binary("mul", other, self)

    def __truediv__(self, other: Interval | Exact | float) -> Interval:
        return _binary("div", self, other)

    def __rtruediv__(self, other: Exact | float) -> Interval:
        return _binary("div", other, self)

    def __neg__(self) -> Interval:
        return _unary("neg", self)

    def __abs__(self) -> Interval:
        return _unary("abs", self)

    def __pow__(self, exponent: int) -> Interval:
        """An integer power; the zeroth is 1, also of zero."""
        return Interval(*_kernel.power((self.low, self.high), exponent))

    def minimum(self, other: Interval) -> Interval:
        """Enclose the lesser of a point of each."""
        return _binary("min", self, other)

    def maximum(self, other: Interval) -> Interval:
        """Enclose the greater of a point of each."""
        return _binary("max", self, other)

    def hull(self, other: Interval) -> Interval:
        """The smallest interval that contains both."""
        return _binary("hull", self, other)

    def intersection(self, other: Interval) -> Interval:
        """The points of both; `Fault` if there is none."""
        return _binary("intersection", self, other)

    def sqr(self) -> Interval:
        """The squares: never negative, unlike the product with itself."""
        return _unary("sqr", self)

    def sqrt(self) -> Interval:
        """The roots; `Fault` if a point may be negative."""
        return _unary("sqrt", self)

    def exp(self) -> Interval:
        """The exponentials; `Fault` where they leave the floats."""
        return _unary("exp", self)

    def log(self) -> Interval:
        """The natural logarithms; `Fault` unless every point is positive."""
        return _unary("log", self)

    def sin(self) -> Interval:
        """The sines; [-1, 1] for arguments so large that floats are coarser than a period."""
        return _unary("sin", self)

    def cos(self) -> Interval:
        """The cosines; [-1, 1] for arguments so large that floats are coarser than a period."""
        return _unary("cos", self)

    def tan(self) -> Interval:
        """The tangents; `Fault` if a pole may lie inside."""
        return _unary("tan", self)

    def asin(self) -> Interval:
        """The arc sines; `Fault` unless every point lies in [-1, 1]."""
        return _unary("asin", self)

    def acos(self) -> Interval:
        """The arc cosines; `Fault` unless every point lies in [-1, 1]."""
        return _unary("acos", self)

    def atan(self) -> Interval:
        """The arc tangents."""
        return _unary("atan", self)

    def sinh(self) -> Interval:
        """The hyperbolic sines."""
        return _unary("sinh", self)

    def cosh(self) -> Interval:
        """The hyperbolic cosines, at least 1."""
        return _unary("cosh", self)

    def tanh(self) -> Interval:
        """The hyperbolic tangents, in [-1, 1]."""
        return _unary("tanh", self)


def enclose(q: Fraction) -> Interval:
    """The tightest interval around a rational: itself if it is a float, else two neighbours.

    Raises
    ------
    Fault               if `q` is beyond the largest float

    Soundness           exact division of integers; below 2^-960 an end may lie one float further out
    Example
    -------
    >>> enclose(Fraction(3, 4))
    Interval(low=0.75, high=0.75)
    """
    return Interval(*_kernel.enclose(q.numerator, q.denominator))


def _unary(name: str, operand: Interval) -> Interval:
    return Interval(*_kernel.unary(name, (operand.low, operand.high)))


def _binary(name: str, left: Interval | Exact | float, right: Interval | Exact | float) -> Interval:
    x = left if isinstance(left, Interval) else Interval.at(left)
    y = right if isinstance(right, Interval) else Interval.at(right)
    return Interval(*_kernel.binary(name, (x.low, x.high), (y.low, y.high)))
