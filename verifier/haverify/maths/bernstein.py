"""Bernstein form: the range of a polynomial on a box, exactly.

On [0, 1] a polynomial of degree n is a convex combination of its n + 1 Bernstein coefficients, so its
range lies between
the least and the greatest of them; the first and the last are its values at the ends.
Source: R. T. Farouki, "The Bernstein polynomial basis: a centennial retrospective", 2012, sections 3 and 5.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import lru_cache
from math import comb, lcm

from haverify.maths.polynomial import Polynomial

Box = Mapping[str, tuple[Fraction, Fraction]]
ZERO = Fraction(0)


def coefficients(p: Sequence[int], low: Fraction, high: Fraction) -> tuple[list[int], int]:
    """`(b, d)`: the Bernstein coefficients of `p` on [low, high] are `b[i] / d`, with `d > 0`.

    Parameters
    ----------
    p : (n + 1,) integers, lowest power first, not empty
    low, high           rationals, low <= high

    Soundness           exact
    """
    n = len(p) - 1
    d = lcm(low.denominator, high.denominator)
    a = low.numerator * (d // low.denominator)
    w = high.numerator * (d // high.denominator) - a
    shifted = _homogeneous(p, d)
    for i in range(n):
        for j in range(n - 1, i - 1, -1):
            shifted[j] += a * shifted[j + 1]
    weights, common = _weights(n)
    power = 1
    for k in range(n + 1):
        shifted[k] *= power * weights[k]
        power *= w
    for i in range(n):
        for j in range(n, i, -1):
            shifted[j] += shifted[j - 1]
    return shifted, common * int(d**n)


def _homogeneous(p: Sequence[int], d: int) -> list[int]:
    """`p[i] * d^(n - i)`."""
    result, power = [0] * len(p), 1
    for i in reversed(range(len(p))):
        result[i] = p[i] * power
        power *= d
    return result


@lru_cache(maxsize=64)
def _weights(n: int) -> tuple[list[int], int]:
    """`lcm / comb(n, k)` for each k, and the lcm of the binomial coefficients."""
    common = lcm(*(comb(n, k) for k in range(n + 1)))
    return [common // comb(n, k) for k in range(n + 1)], common


def halves(b: list[int]) -> tuple[list[int], list[int]]:
    """Multiples, by 2^n, of the Bernstein coefficients on the two halves of the interval (de Casteljau)."""
    n = len(b) - 1
    row, left, right = list(b), [0] * (n + 1), [0] * (n + 1)
    for k in range(n + 1):
        left[k] = row[0] << (n - k)
        right[n - k] = row[-1] << (n - k)
        row = [x + y for x, y in itertools.pairwise(row)]
    return left, right


def variations(b: list[int]) -> int:
    """Sign changes, zeros skipped: an upper bound, of equal parity, for the roots in the open interval."""
    count, last = 0, 0
    for c in b:
        if c:
            sign = 1 if c > 0 else -1
            count += sign == -last
            last = sign
    return count


def bounds(p: Polynomial, box: Box) -> tuple[Fraction, Fraction]:
    """Least and greatest Bernstein coefficient of `p` on the box: rationals that enclose its range there.

    Every variable of `p` must be in the box. With one variable of degree one, or in the corners, the
    bounds are attained.
    """
    names = p.variables
    if not names:
        value = p.constant or ZERO
        return value, value
    tensor, divisor = tensor_coefficients(p, names, box)
    return Fraction(min(tensor), divisor), Fraction(max(tensor), divisor)


def tensor_coefficients(p: Polynomial, names: tuple[str, ...], box: Box) -> tuple[list[int], int]:
    """`(b, d)`: the Bernstein coefficients of `p` on the box are `b[i] / d`, in row-major order of `names`; d > 0."""
    degrees = [p.degree(v) for v in names]
    strides = [1] * len(names)
    for i in reversed(range(len(names) - 1)):
        strides[i] = strides[i + 1] * (degrees[i + 1] + 1)
    divisor = p.divisor
    flat = [0] * (strides[0] * (degrees[0] + 1))
    where = dict(zip(names, strides, strict=True))
    for m, c in p.whole.items():
        flat[sum(where[v] * e for v, e in m)] = c
    axes = zip(names, degrees, strides, strict=True)
    for v, degree, stride in sorted(axes, key=lambda axis: -axis[1]):  # few lines are not zero before the others are
        divisor *= _transform(flat, degree, stride, box[v])
    return flat, divisor


def _transform(flat: list[int], degree: int, stride: int, ends: tuple[Fraction, Fraction]) -> int:
    """From powers of one variable to its Bernstein basis on `ends`, in place, for every line along that variable;
    what is there afterwards is the integer returned times the coefficients."""
    if degree == 1:
        return _linear(flat, stride, ends)
    block = stride * (degree + 1)
    for start in range(0, len(flat), block):
        for offset in range(start, start + stride):
            line = flat[offset : offset + block : stride]
            if any(line):
                flat[offset : offset + block : stride] = coefficients(line, *ends)[0]
    return coefficients([0] * (degree + 1), *ends)[1]


def _linear(flat: list[int], stride: int, ends: tuple[Fraction, Fraction]) -> int:
    """The same for lines of two entries, all at once: the values at the two ends."""
    d = lcm(ends[0].denominator, ends[1].denominator)
    low, high = (x.numerator * (d // x.denominator) for x in ends)
    for start in range(0, len(flat), 2 * stride):
        middle, end = start + stride, start + 2 * stride
        lines = list(zip(flat[start:middle], flat[middle:end], strict=True))
        flat[start:middle] = [p * d + q * low for p, q in lines]
        flat[middle:end] = [p * d + q * high for p, q in lines]
    return d
