"""Real expressions put together number by number, for the kernel: constants are folded, nothing is computed twice.

A `Number` is a constant, exact or enclosed, or the position of an operation on a tape. What is zero or one exactly
vanishes from sums and products, so that a chain of joints whose axes are the coordinate axes stays short.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction

from haverify.maths.interval import Interval
from haverify.solvers.kernel import Listing, Operation, Pair
from haverify.text.record import field, holder, record

Q = Fraction
Constant = Q | Interval


@record
class Number:
    """A constant, or the operation `at` of a tape."""

    constant: Constant | None = None
    at: int = -1


Vector = tuple[Number, Number, Number]
Matrix = tuple[Vector, Vector, Vector]  # by rows


def exact(q: Q | int) -> Number:
    """A rational."""
    return Number(Q(q))


ZERO, ONE = exact(0), exact(1)
NOWHERE: Vector = (ZERO, ZERO, ZERO)
UNTURNED: Matrix = ((ONE, ZERO, ZERO), (ZERO, ONE, ZERO), (ZERO, ZERO, ONE))


@holder
class Formulas:
    """The operations of a tape under construction."""

    operations: list[Operation] = field(default_factory=list)
    constants: list[Pair] = field(default_factory=list)
    _known: dict[Operation, int] = field(default_factory=dict)
    _positions: dict[Pair, int] = field(default_factory=dict)

    def listing(self, outputs: Iterable[Number]) -> Listing:
        """The tape as the kernel takes it."""
        found = [self._position(n) for n in outputs]
        return self.operations, self.constants, found

    def variable(self, number: int) -> Number:
        """A variable."""
        return self._push("variable", number, 0)

    def add(self, a: Number, b: Number) -> Number:
        """`a + b`."""
        if a.constant == 0 or b.constant == 0:
            return b if a.constant == 0 else a
        if a.constant is not None and b.constant is not None:
            return Number(_plus(a.constant, b.constant))
        return self._push("add", *sorted((self._position(a), self._position(b))))

    def sub(self, a: Number, b: Number) -> Number:
        """`a - b`."""
        if b.constant == 0:
            return a
        if b.constant is not None:
            return self.add(a, Number(-b.constant))
        if a.constant == 0:
            return self._push("neg", self._position(b), 0)
        return self._push("sub", self._position(a), self._position(b))

    def mul(self, a: Number, b: Number) -> Number:
        """`a b`."""
        if a.constant == 0 or b.constant == 0:
            return ZERO
        if a.constant == 1 or b.constant == 1:
            return b if a.constant == 1 else a
        if a.constant is not None and b.constant is not None:
            return Number(_times(a.constant, b.constant))
        if a.constant == -1 or b.constant == -1:
            return self.sub(ZERO, b if a.constant == -1 else a)
        return self._push("mul", *sorted((self._position(a), self._position(b))))

    def div(self, a: Number, b: Number) -> Number:
        """`a / b`."""
        return self._push("div", self._position(a), self._position(b))

    def sine_and_cosine(self, a: Number) -> tuple[Number, Number]:
        """Both, of an angle in rad."""
        if a.constant == 0:
            return ZERO, ONE
        at = self._position(a)
        if ("sin", at, 0) not in self._known:
            self._push("sin", at, 0)
            self._push("cos", at, 0)
        sine = self._known[("sin", at, 0)]
        return Number(None, sine), Number(None, sine + 1)

    def total(self, numbers: Iterable[Number]) -> Number:
        """The sum."""
        sum_ = ZERO
        for n in numbers:
            sum_ = self.add(sum_, n)
        return sum_

    def dot(self, a: Sequence[Number], b: Sequence[Number]) -> Number:
        """The inner product."""
        return self.total(self.mul(x, y) for x, y in zip(a, b, strict=True))

    def plus(self, a: Vector, b: Vector) -> Vector:
        """The sum of vectors."""
        x, y, z = (self.add(p, q) for p, q in zip(a, b, strict=True))
        return (x, y, z)

    def minus(self, a: Vector, b: Vector) -> Vector:
        """The difference of vectors."""
        x, y, z = (self.sub(p, q) for p, q in zip(a, b, strict=True))
        return (x, y, z)

    def scaled(self, a: Vector, by: Number) -> Vector:
        """A multiple of a vector."""
        x, y, z = (self.mul(p, by) for p in a)
        return (x, y, z)

    def cross(self, a: Vector, b: Vector) -> Vector:
        """The vector product."""
        (a1, a2, a3), (b1, b2, b3) = a, b
        return (
            self.sub(self.mul(a2, b3), self.mul(a3, b2)),
            self.sub(self.mul(a3, b1), self.mul(a1, b3)),
            self.sub(self.mul(a1, b2), self.mul(a2, b1)),
        )

    def turned(self, m: Matrix, v: Vector) -> Vector:
        """A matrix times a vector."""
        x, y, z = (self.dot(row, v) for row in m)
        return (x, y, z)

    def product(self, a: Matrix, b: Matrix) -> Matrix:
        """A product of matrices."""
        columns = transposed(b)
        x, y, z = (self.turned(columns, row) for row in a)
        return (x, y, z)

    def _position(self, n: Number) -> int:
        if n.constant is None:
            return n.at
        c = n.constant if isinstance(n.constant, Interval) else Interval.at(n.constant)
        pair = (c.low, c.high)
        if pair not in self._positions:
            self._positions[pair] = len(self.constants)
            self.constants.append(pair)
        return self._push("constant", self._positions[pair], 0).at

    def _push(self, name: str, a: int, b: int) -> Number:
        operation = (name, a, b)
        if operation not in self._known:
            self._known[operation] = len(self.operations)
            self.operations.append(operation)
        return Number(None, self._known[operation])


def _plus(a: Constant, b: Constant) -> Constant:
    return a + b


def _times(a: Constant, b: Constant) -> Constant:
    return a * b


def transposed(m: Matrix) -> Matrix:
    """Rows as columns."""
    (a, b, c), (d, e, f), (g, h, i) = m
    return ((a, d, g), (b, e, h), (c, f, i))
