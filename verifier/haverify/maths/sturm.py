"""Exact real roots of polynomials in one variable, and what follows from them: extremes and signs on an interval.

Roots are isolated by bisection on sign variations of Bernstein coefficients (no variation: no root; one: one root) and
refined by a guess in floating point that counts only once two exact signs confirm it. `count` is Sturm's theorem, the
slow and independent way to the same number.
Source: A. Eigenwillig et al., CASC 2005 (isolation); S. Basu, R. Pollack, M.-F. Roy, "Algorithms in Real Algebraic
Geometry", 2006, theorem 2.50 (Sturm).
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from fractions import Fraction

from haverify.maths import bernstein
from haverify.maths.univariate import (
    Integers,
    derivative,
    greatest_common_divisor,
    primitive,
    product,
    quotient,
    sign_at,
    square_free,
    value,
)
from haverify.text.record import record

DEEP = 48  # bisections before multiple roots are divided out
FINE = 44  # bits to which a critical point is refined, relative to its isolating interval


@record
class Root:
    """One real root: the number `low` where `low == high`, else the only root in the open interval.

    In the second case it is simple in the polynomial it was isolated for, whose signs at the two ends differ.
    """

    low: Fraction
    high: Fraction

    @property
    def middle(self) -> Fraction:
        """A rational in the interval."""
        return (self.low + self.high) / 2


@record
class Extreme:
    """The least or greatest value on an interval: `low <= value <= high`, attained at or near `at`;
    exactly there if `exact`."""

    low: Fraction
    high: Fraction
    at: Fraction
    exact: bool


def count(p: Integers, low: Fraction, high: Fraction) -> int:
    """The number of distinct real roots in (low, high], by Sturm's theorem; `p` not zero."""
    p = square_free(p)
    chain = [p, primitive(derivative(p))]
    while len(chain[-1]) > 1:
        chain.append(_negated_remainder(chain[-2], chain[-1]))
    chain = [c for c in chain if c]
    return _changes(chain, low) - _changes(chain, high)


def _negated_remainder(p: Integers, q: Integers) -> Integers:
    rest = [Fraction(c) for c in p]
    while len(rest) >= len(q):
        factor, shift = rest[-1] / q[-1], len(rest) - len(q)
        for j, c in enumerate(q):
            rest[shift + j] -= factor * c
        rest.pop()
    common = 1
    for r in rest:
        common = common * r.denominator // _gcd(common, r.denominator)
    return primitive([int(-r * common) for r in rest])


def _gcd(a: int, b: int) -> int:
    while b:
        a, b = b, a % b
    return a


def _changes(chain: Sequence[Integers], x: Fraction) -> int:
    return bernstein.variations([sign_at(c, x) for c in chain])


def isolate(p: Integers, low: Fraction, high: Fraction) -> list[Root]:
    """The distinct real roots in [low, high], in order; none for the zero polynomial.

    Soundness           exact: every root is found, none twice
    """
    if len(p) <= 1:
        return []
    if low == high:
        return [Root(low, low)] if sign_at(p, low) == 0 else []
    found = _bisect(p, low, high)
    if found is None:
        found = _bisect(square_free(p), low, high)
    assert found is not None, "a square-free polynomial has separated roots"
    return found


def _bisect(p: Integers, low: Fraction, high: Fraction) -> list[Root] | None:
    """The roots, or None when `p` seems to have multiple ones."""
    simple = len(p) == 2 or None
    roots: list[Root] = []
    stack = [(low, high, bernstein.coefficients(p, low, high)[0], 0)]
    while stack:
        a, b, coefficients, depth = stack.pop()
        if not coefficients[0] and Root(a, a) not in roots[-1:]:
            roots.append(Root(a, a))
        changes = bernstein.variations(coefficients)
        if changes == 1 and coefficients[0] and coefficients[-1]:
            roots.append(Root(a, b))
        elif changes:
            if depth == DEEP and not simple:
                if len(square_free(p)) != len(p):
                    return None
                simple = True
            left, right = bernstein.halves(coefficients)
            middle = (a + b) / 2
            stack += [(middle, b, right, depth + 1), (a, middle, left, depth + 1)]
        elif b == high and not coefficients[-1]:
            roots.append(Root(b, b))
    return roots


def refine(p: Integers, root: Root, bits: int = FINE) -> Root:
    """The same root in an interval at most `2^-bits` times as wide (or exactly)."""
    if root.low == root.high:
        return root
    if len(p) == 2:
        exact = Fraction(-p[0], p[1])
        return Root(exact, exact)
    width = root.high - root.low
    guess = _guess(bernstein.coefficients(p, root.low, root.high)[0])
    rising = sign_at(p, root.high)
    for margin in (2, 256, 1 << 16):
        inner = _certified(
            p, root, Fraction(round(guess * 2.0**bits), 1 << bits), Fraction(margin, 1 << (bits + 2)), rising
        )
        if inner is not None:
            root = inner
            break
    while root.high - root.low > width / (1 << bits):
        root = _halve(p, root, rising)
    return root


def _certified(p: Integers, root: Root, t: Fraction, margin: Fraction, rising: int) -> Root | None:
    """The root within `margin` of `t` (both on the scale where the interval is [0, 1]), if signs say that
    it is there."""
    width = root.high - root.low
    low = root.low + max(Fraction(0), t - margin) * width
    high = root.low + min(Fraction(1), t + margin) * width
    below, above = sign_at(p, low), sign_at(p, high)
    if below == 0 or above == 0:
        exact = low if below == 0 else high
        return Root(exact, exact)
    return Root(low, high) if below == -rising and above == rising else None


def _halve(p: Integers, root: Root, rising: int) -> Root:
    middle = root.middle
    sign = sign_at(p, middle)
    if sign == 0:
        return Root(middle, middle)
    return Root(root.low, middle) if sign == rising else Root(middle, root.high)


def _guess(coefficients: list[int]) -> float:
    """About the root in [0, 1] of the polynomial with these Bernstein coefficients: bisection, then
    Newton; no guarantee."""
    shift = max(0, max(abs(c) for c in coefficients).bit_length() - 900)
    b = [float(c >> shift) for c in coefficients]
    low, high, rising = 0.0, 1.0, b[-1] > 0
    t = 0.5
    for _ in range(60):
        v, slope = _casteljau(b, t)
        if v == 0 or high - low < 1e-15:
            break
        low, high = (low, t) if (v > 0) == rising else (t, high)
        step = t - v / slope if slope else 0.5 * (low + high)
        following = step if low < step < high else 0.5 * (low + high)
        if abs(following - t) < 1e-16:
            break
        t = following
    return t


def _casteljau(b: list[float], t: float) -> tuple[float, float]:
    """Value and slope at `t`."""
    row, n = b, len(b) - 1
    while len(row) > 2:
        row = [x + (y - x) * t for x, y in itertools.pairwise(row)]
    return row[0] + (row[1] - row[0]) * t, n * (row[1] - row[0])


def extremes(p: Integers, low: Fraction, high: Fraction) -> tuple[Extreme, Extreme]:
    """Least and greatest value of `p` on [low, high].

    They are attained at an end or at a zero of the derivative. There the value at the refined midpoint is
    off by at most
    `w^2 / 2 * max |p''|`, w being its distance to the zero, because the slope vanishes at the zero.

    Soundness           exact where `exact`; else a rational enclosure, relative width about 2^-80
    """
    ends = [_at(p, x) for x in ((low,) if low == high else (low, high))]
    slope = derivative(p)
    inner = [_critical(p, slope, r) for r in isolate(slope, low, high)] if low < high else []
    points = ends + inner
    return min(points, key=lambda e: (e.low, e.at)), max(points, key=lambda e: (e.high, -e.at))


def _at(p: Integers, x: Fraction) -> Extreme:
    v = value(p, x)
    return Extreme(v, v, x, True)


def _critical(p: Integers, slope: Integers, root: Root) -> Extreme:
    simple = slope if sign_at(slope, root.low) * sign_at(slope, root.high) < 0 else square_free(slope)
    fine = refine(simple, root)
    if fine.low == fine.high:
        return _at(p, fine.low)
    x = fine.middle
    v = value(p, x)
    bend, scale = bernstein.coefficients(derivative(slope), root.low, root.high)
    error = Fraction(max(abs(c) for c in bend), scale) * (fine.high - fine.low) ** 2 / 8
    return Extreme(v - error, v + error, x, False)


@record
class Piece:
    """A root of some of the polynomials (`is_root`), or one rational of a stretch between roots, and the
    signs there."""

    place: Root
    is_root: bool
    signs: tuple[int, ...]


def sign_vectors(polynomials: Sequence[Integers], low: Fraction, high: Fraction) -> list[Piece]:
    """Every combination of signs that the polynomials take together on [low, high], each with a place where they do.

    The roots of all of them cut the interval into points and stretches on which no sign changes; they are listed in
    order, stretches between any two roots, and at the ends where no root lies there.

    Soundness           exact and complete
    """
    parts = [square_free(p) if len(p) > 1 else p for p in polynomials]
    known = {Fraction(-p[0], p[1]) for p in parts if len(p) == 2}
    if all(len(p) <= 2 for p in parts):
        roots = [_point(x) for x in sorted(known) if low <= x <= high]
    else:
        roots = [_known(r, known) for r in isolate(_square_free_product(parts), low, high)]
    vectors: list[Piece] = []
    for x, is_root in _samples(roots, low, high):
        if x.low == x.high:
            signs = tuple(sign_at(p, x.low) for p in polynomials)
        else:
            signs = tuple(_sign_at_root(p, q, x) for p, q in zip(polynomials, parts, strict=True))
        vectors.append(Piece(x, is_root, signs))
    return vectors


def _known(root: Root, known: Iterable[Fraction]) -> Root:
    """The root as a number, where it is one of those that linear polynomials have."""
    return next((_point(x) for x in known if root.low < x < root.high), root)


def _square_free_product(parts: Sequence[Integers]) -> Integers:
    whole: Integers = (1,)
    for p in parts:
        if len(p) > 1:
            common = greatest_common_divisor(whole, p)
            whole = product(whole, p if len(common) <= 1 else quotient(p, common))
    return whole


def _samples(roots: list[Root], low: Fraction, high: Fraction) -> list[tuple[Root, bool]]:
    """The roots, and between them (and before, and after) one rational each; True marks the roots."""
    result: list[tuple[Root, bool]] = []
    last = low
    for root in roots:
        if result or last < root.low or root.low < root.high:
            result.append((_point((last + root.low) / 2), False))
        result.append((root, True))
        last = root.high
    if not roots or last < high or roots[-1].low < last:
        result.append((_point((last + high) / 2), False))
    return result


def _point(x: Fraction) -> Root:
    return Root(x, x)


def _sign_at_root(p: Integers, simple: Integers, x: Root) -> int:
    """The sign of `p` at the root in `x`; `simple` has the roots of `p`, and no other root of the product
    lies in `x`."""
    if len(p) <= 1:
        return sign_at(p, x.low)
    if sign_at(simple, x.low) != sign_at(simple, x.high):
        return 0
    return sign_at(p, x.low)
