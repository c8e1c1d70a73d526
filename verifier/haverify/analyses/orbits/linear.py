"""Small matrices of intervals, and bounds of their eigenvalues and norms in exact arithmetic."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any, NamedTuple

from haverify.maths.interval import Interval

Q = Fraction
Matrix = list[list[Interval]]
Exact = list[list[Q]]
DIGITS = 10**40


class Disc(NamedTuple):
    """A disc of the complex plane that holds one eigenvalue; its middle and radius, as floats that are not less."""

    real: Q
    imaginary: Q
    radius: Q

    def is_apart(self, other: Disc) -> bool:
        """Whether the discs have no number in common."""
        between = (self.real - other.real) ** 2 + (self.imaginary - other.imaginary) ** 2
        return between > (self.radius + other.radius) ** 2

    def least(self) -> Q:
        """No number of the disc is nearer to zero."""
        return max(_root_below(self.real**2 + self.imaginary**2) - self.radius, Q(0))

    def largest(self) -> Q:
        """No number of the disc is farther from zero."""
        return root_above(self.real**2 + self.imaginary**2) + self.radius


def root_above(q: Q) -> Q:
    """A number whose square is not less, and near."""
    return Q(_isqrt(q) + 1, DIGITS)


def _root_below(q: Q) -> Q:
    return Q(_isqrt(q), DIGITS)


def _isqrt(q: Q) -> int:
    from math import isqrt

    return isqrt(int(q * DIGITS * DIGITS))


def middle(a: Matrix) -> list[list[float]]:
    """Floats inside of the entries."""
    return [[x.midpoint for x in row] for row in a]


def product(a: Sequence[Sequence[Interval]], b: Sequence[Sequence[Interval]]) -> Matrix:
    """The product."""
    columns = list(zip(*b, strict=True))
    return [[_dot(row, column) for column in columns] for row in a]


def _dot(row: Sequence[Interval], column: Sequence[Interval]) -> Interval:
    total = Interval.at(0)
    for x, y in zip(row, column, strict=True):
        total = total + x * y
    return total


def transformed(a: Matrix, basis: Sequence[Sequence[float]]) -> tuple[Exact, Exact] | None:
    """The middle and radii of `S^-1 A S`, exactly; None where the basis S is none."""
    s = [[Q(x) for x in row] for row in basis]
    back = inverse(s)
    if back is None:
        return None
    mid, rad = ends(a)
    return times(times(back, mid), s), times(times(_sizes(back), rad), _sizes(s))


def ends(a: Matrix) -> tuple[Exact, Exact]:
    """The middle and radii of the entries, exactly."""
    pairs = [[x.exactly() for x in row] for row in a]
    mid = [[(low + high) / 2 for low, high in row] for row in pairs]
    return mid, [[(high - low) / 2 for low, high in row] for row in pairs]


def _sizes(a: Exact) -> Exact:
    return [[abs(x) for x in row] for row in a]


def times(a: Exact, b: Exact) -> Exact:
    """The product of exact matrices."""
    columns = list(zip(*b, strict=True))
    return [[sum((x * y for x, y in zip(row, c, strict=True)), Q(0)) for c in columns] for row in a]


def inverse(a: Exact) -> Exact | None:
    """The inverse, by elimination; None where there is none."""
    n = len(a)
    rows = [[*row, *(Q(i == j) for j in range(n))] for i, row in enumerate(a)]
    for k in range(n):
        at = max(range(k, n), key=lambda i: abs(rows[i][k]))
        if rows[at][k] == 0:
            return None
        rows[k], rows[at] = rows[at], rows[k]
        rows[k] = [x / rows[k][k] for x in rows[k]]
        for i in range(n):
            if i != k and rows[i][k] != 0:
                rows[i] = [x - rows[i][k] * y for x, y in zip(rows[i], rows[k], strict=True)]
    return [row[n:] for row in rows]


def square_norm(mid: Exact, rad: Exact) -> Q:
    """A bound of the square of the Euclidean norm of all matrices between `mid - rad` and `mid + rad`."""
    turned = [list(row) for row in zip(*mid, strict=True)]
    gram, wide = times(turned, mid), _sizes(mid)
    across = [list(row) for row in zip(*rad, strict=True)]
    first, second = times(across, wide), times([list(r) for r in zip(*wide, strict=True)], rad)
    both = times(across, rad)
    sums = (
        sum((abs(gram[i][j]) + first[i][j] + second[i][j] + both[i][j] for j in range(len(mid))), Q(0))
        for i in range(len(mid))
    )
    return max(sums, default=Q(0))


def basis_of(a: Sequence[Sequence[float]], sizes: Sequence[float]) -> list[list[float]]:
    """Near a real basis in which a matrix consists of numbers and of turns with a stretching; another if none is.

    Its columns are as long as the sizes of the components allow, both of a turn by the same factor.
    """
    import numpy as np

    if not a:
        return []
    values, vectors = np.linalg.eig(np.array(a))
    columns: list[list[Any]] = []
    for k, value in enumerate(values):
        if abs(value.imag) <= 1e-12 * max(1e-3, abs(value)):
            columns.append([vectors[:, k].real])
        elif value.imag > 0:
            columns.append([vectors[:, k].real, vectors[:, k].imag])
    scaled = [c / max(float(np.max(np.abs(b) / np.array(sizes))) for b in block) for block in columns for c in block]
    found = np.stack(scaled, axis=1) if len(scaled) == len(values) else np.diag(sizes)
    if not np.linalg.cond(found / np.array(sizes)[:, None]) < 1e8:
        found = np.diag(sizes)
    return [[float(x) for x in row] for row in found]


def discs(a: Matrix) -> list[Disc]:
    """Discs that hold all eigenvalues of all matrices in `a`; a disc that touches no other holds exactly one.

    `S^-1 A S` has blocks of one and two columns near its diagonal; a turn by `p + i q` has the eigenvectors (1, +-i).
    By Gershgorin's theorem, for the matrix after a further change of basis to these.
    """
    if not a:
        return []
    found = transformed(a, basis_of(middle(a), [1.0] * len(a)))
    assert found is not None, "a basis has an inverse"
    mid, rad = found
    pairs = _pairs(mid)
    real, imaginary, radius = _unturned(mid, rad, pairs)
    n = len(mid)
    result = []
    for i in range(n):
        off = sum((root_above(real[i][j] ** 2 + imaginary[i][j] ** 2) + radius[i][j] for j in range(n) if j != i), Q(0))
        result.append(Disc(real[i][i], imaginary[i][i], off + radius[i][i]))
    return result


def _pairs(mid: Exact) -> list[tuple[int, int]]:
    """Neighbouring rows that are about a turn, not two numbers and rounding."""
    found, k = list[tuple[int, int]](), 0
    while k + 1 < len(mid):
        here, there, apart = mid[k][k + 1], mid[k + 1][k], abs(mid[k][k] - mid[k + 1][k + 1])
        if here * there < 0 and min(abs(here), abs(there)) > max(abs(here), abs(there), 2 * apart) / 2:
            found.append((k, k + 1))
            k += 1
        k += 1
    return found


def _unturned(mid: Exact, rad: Exact, pairs: list[tuple[int, int]]) -> tuple[Exact, Exact, Exact]:
    """The matrix in the basis (1, i), (1, -i) of each pair: real and imaginary parts, and radii.

    With `T = [[1, 1], [i, -i]]` and `T^-1 = [[1, -i], [1, i]] / 2`.
    """
    n = len(mid)
    one, none = [[Q(i == j) for j in range(n)] for i in range(n)], [[Q(0)] * n for _ in range(n)]
    there_re, there_im = [list(r) for r in one], [list(r) for r in none]
    back_re, back_im = [list(r) for r in one], [list(r) for r in none]
    for i, j in pairs:
        there_re[i][i], there_re[i][j], there_re[j][i], there_re[j][j] = Q(1), Q(1), Q(0), Q(0)
        there_im[j][i], there_im[j][j] = Q(1), Q(-1)
        back_re[i][i], back_re[j][i], back_re[i][j], back_re[j][j] = Q(1, 2), Q(1, 2), Q(0), Q(0)
        back_im[i][j], back_im[j][j] = Q(-1, 2), Q(1, 2)
    half_re, half_im = times(back_re, mid), times(back_im, mid)
    real = _less(times(half_re, there_re), times(half_im, there_im))
    imaginary = _plus(times(half_re, there_im), times(half_im, there_re))
    size_back = _plus(_sizes(back_re), _sizes(back_im))
    size_there = _plus(_sizes(there_re), _sizes(there_im))
    return real, imaginary, times(times(size_back, rad), size_there)


def _plus(a: Exact, b: Exact) -> Exact:
    return [[x + y for x, y in zip(r, s, strict=True)] for r, s in zip(a, b, strict=True)]


def _less(a: Exact, b: Exact) -> Exact:
    return [[x - y for x, y in zip(r, s, strict=True)] for r, s in zip(a, b, strict=True)]
