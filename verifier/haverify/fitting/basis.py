"""Polynomials per phase that meet of themselves: nodal values shared by neighbouring phases, and bubbles within each.

In a phase of length L and local time u in [0, 1] a polynomial of degree d >= 2r + 1 is written as

    sum over i <= r of L^i (y_i A_i(u) + z_i B_i(u))  +  u^(r+1) (1 - u)^(r+1) sum over j of b_j (2u - 1)^j

with Hermite's polynomials A_i, B_i: y_i and z_i are its i-th derivatives by time at both ends. Sharing them between
neighbours, the last phase with the first, makes every choice of unknowns continuous of order r and periodic. So least
squares need no side conditions, and unknowns may be rounded freely: continuity stays exact.
"""

from __future__ import annotations

from fractions import Fraction
from functools import cache
from typing import TYPE_CHECKING, Any

from haverify.fitting.knots import Knots

if TYPE_CHECKING:
    from numpy import ndarray

    Array = ndarray[Any, Any]

Q = Fraction
Poly = tuple[Q, ...]  # coefficients in u, lowest power first

_H = Q(1, 2)

# HERMITE[r][end][i]: the polynomial whose i-th derivative at that end is 1, all others up to order r at both ends 0.
HERMITE: tuple[tuple[tuple[tuple[Q | int, ...], ...], ...], ...] = (
    (((1, -1),), ((0, 1),)),
    (((1, 0, -3, 2), (0, 1, -2, 1)), ((0, 0, 3, -2), (0, 0, -1, 1))),
    (
        ((1, 0, 0, -10, 15, -6), (0, 1, 0, -6, 8, -3), (0, 0, _H, -3 * _H, 3 * _H, -_H)),
        ((0, 0, 0, 10, -15, 6), (0, 0, 0, -4, 7, -3), (0, 0, 0, _H, -1, _H)),
    ),
)

DECIMALS = (4, 3, 2)
"""Decimals that are kept of values (deg), velocities (deg/s) and accelerations (deg/s^2) at the knots."""
BUBBLE_DECIMALS = 3


@cache
def bubbles(order: int, degree: int) -> tuple[Poly, ...]:
    """The polynomials that vanish up to the given order at both ends, up to a degree."""
    base: Poly = (Q(1),)
    for factor in [(Q(0), Q(1)), (Q(1), Q(-1))] * (order + 1):
        base = times(base, factor)
    found = []
    for _ in range(degree - 2 * order - 1):
        found.append(base)
        base = times(base, (Q(-1), Q(2)))
    return tuple(found)


def times(p: Poly, q: Poly) -> Poly:
    """The product of two polynomials.

    >>> [str(c) for c in times((Q(1), Q(1)), (Q(1), Q(-1)))]
    ['1', '0', '-1']
    """
    result = [Q(0)] * (len(p) + len(q) - 1)
    for i, a in enumerate(p):
        for j, b in enumerate(q):
            result[i + j] += a * b
    return tuple(result)


def design(t: Array, knots: Knots, order: int, degree: int) -> Array:
    """The matrix (samples, unknowns): what each unknown adds at the instants `t` (n,) in [0, period].

    Unknowns: for each knot its derivatives 0 .. order, then for each phase its bubbles.
    """
    import numpy as np

    n, width = len(knots.lengths), degree - 2 * order - 1
    phase, u = local(t, knots)
    matrix = np.zeros((len(t), n * (order + 1 + width)))
    rows = np.arange(len(t))
    lengths = np.array([float(x) for x in knots.lengths])[phase]
    for i in range(order + 1):
        for end, knot in ((0, phase), (1, (phase + 1) % n)):
            values = _value(HERMITE[order][end][i], u) * lengths**i
            np.add.at(matrix, (rows, knot * (order + 1) + i), values)
    for j, bubble in enumerate(bubbles(order, degree)):
        matrix[rows, n * (order + 1) + phase * width + j] = _value(bubble, u)
    return matrix


def local(t: Array, knots: Knots) -> tuple[Array, Array]:
    """The phase and the local time of some instants."""
    import numpy as np

    at = np.array([float(x) for x in knots.at])
    phase = np.clip(np.searchsorted(at, t, side="right") - 1, 0, len(at) - 2)
    return phase, (t - at[phase]) / (at[phase + 1] - at[phase])


def _value(p: tuple[Q | int, ...], u: Array) -> Array:
    import numpy as np

    return np.asarray(np.polynomial.polynomial.polyval(u, [float(c) for c in p]))


def polynomials(unknowns: Array, knots: Knots, order: int, degree: int) -> tuple[Poly, ...]:
    """The polynomial of each phase, with unknowns rounded to a few decimals: finite decimals, exactly continuous."""
    n, width = len(knots.lengths), degree - 2 * order - 1
    nodal = [_decimal(unknowns[k], DECIMALS[k % (order + 1)]) for k in range(n * (order + 1))]
    inner = [_decimal(x, BUBBLE_DECIMALS) for x in unknowns[n * (order + 1) :]]
    shapes = bubbles(order, degree)
    found = []
    for k, length in enumerate(knots.lengths):
        p = [Q(0)] * (degree + 1)
        for end, knot in ((0, k), (1, (k + 1) % n)):
            for i in range(order + 1):
                _add(p, HERMITE[order][end][i], nodal[knot * (order + 1) + i] * length**i)
        for j in range(width):
            _add(p, shapes[j], inner[k * width + j])
        found.append(tuple(p))
    return tuple(found)


def _add(p: list[Q], shape: tuple[Q | int, ...], factor: Q) -> None:
    for i, c in enumerate(shape):
        p[i] += c * factor


def _decimal(x: float, places: int) -> Q:
    return Q(round(float(x) * 10**places), 10**places)
