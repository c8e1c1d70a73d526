"""Quotients, roots, exponentials, logarithms, sines of models: series about the middle with a bound of the rest.

What is found by iteration is a guess, put into the equation it has to solve to find how far it is off.
"""

from __future__ import annotations

from math import factorial, isqrt

from hacheck.enclosures import Model, Space, add, bounds, middle, norm, widened
from hacheck.rational import Beyond, spend

LARGEST = 300  # exponentials and sines of larger numbers are not looked at
TERMS = 48


def powers(x: int, bits: int) -> tuple[int, int, int]:
    """`e^x`, `cos x`, `sin x` of an exact number, each within 2 units.

    With W more bits each of the n < 2^12 terms is off by `2 e^|x|` of the smaller units at most, their rest by
    `6 e^|x|`, and `e^|x| < 2^(W - 32)`.
    """
    if abs(x) >> bits >= LARGEST:
        raise Beyond("an exponential or a sine of a large number")
    extra = 34 + 3 * (abs(x) >> bits) // 2
    x, bits = x << extra, bits + extra
    sums, term, k = [0, 0, 0], 1 << bits, 0
    while abs(term) > 1 or k <= 2 * (abs(x) >> bits) + 3:
        sums[0] += term
        sums[1 + k % 2] += -term if k & 2 else term
        k += 1
        term = (term * x >> bits) // k
    spend(1 + k * bits >> 8)
    return sums[0] >> extra, sums[1] >> extra, sums[2] >> extra


def logarithm(x: int, bits: int) -> tuple[int, int]:
    """A number near the logarithm of an exact positive number, and how far it is off at most."""
    one = 1 << bits
    y = (x.bit_length() - bits) * 7 * one // 10
    for _ in range(12):
        y += 2 * (x - powers(y, bits)[0]) * one // (x + powers(y, bits)[0] + 1)
    back = powers(y, bits)[0]
    least = min(x, back - 2)
    if least <= 0:
        raise Beyond("a logarithm of a tiny number")
    return y, (abs(x - back) + 2) * one // least + 1


def waves(space: Space, a: Model) -> tuple[Model, Model]:
    """The sine and the cosine: all their derivatives are at most 1."""
    _, cosine, sine = powers(middle(a), space.bits)
    rest, terms, left = _about(space, a, 1, 1)
    turn = [sine, cosine, -sine, -cosine]
    found = [[(turn[(k + s) % 4] // factorial(k), 3) for k in range(terms)] for s in (0, 1)]
    made = space.polynomials(found, rest, left)
    return made[0], made[1]


def exponential(space: Space, a: Model) -> Model:
    """The exponential, whose derivatives are at most its largest value."""
    at = powers(middle(a), space.bits)[0]
    rest, terms, left = _about(space, a, 1, 1)
    most = powers(middle(a) + norm(rest), space.bits)[0] + 2
    return space.polynomials([[(at // factorial(k), 3) for k in range(terms)]], rest, space.up(most * left))[0]


def log(space: Space, a: Model) -> Model:
    """The logarithm of what is positive: its k-th coefficient is at most `1 / (k low^k)`."""
    low, c, one = bounds(a)[0], middle(a), space.one
    if low <= 0:
        raise Beyond("a logarithm of what may not be positive")
    rest, terms, left = _about(space, a, low, 0)
    found = [logarithm(c, space.bits)]
    found += [((-1) ** (k + 1) * one ** (k + 1) // (k * c**k), 1) for k in range(1, terms)]
    return space.polynomials([found], rest, left)[0]


def _about(space: Space, a: Model, low: int, factorials: int) -> tuple[Model, int, int]:
    """`a` without its middle, how many terms of a series to take, and a bound of `(|a| / low)^n`, over n! or not."""
    rest = add(a, space.constant(middle(a)), -1)
    size, left, n = norm(rest), space.one, 0
    while (left > 2 and n < TERMS) or n < 2:
        n += 1
        left = -(-left * size // (space.one * n if factorials else low))
    return rest, n, left


def inverse(space: Space, a: Model) -> Model:
    """`1 / a`: with `a q = 1 - r` it is q within `|q| |r| / (1 - |r|)`."""
    if not middle(a):
        raise Beyond("a division by what may be zero")
    one, b = space.constant(space.one), Model(a.parts, 0)
    q = space.constant(space.one**2 // middle(a))
    r, size = _short(space, one, b, q), 0
    for _ in range(8):
        size, better = norm(r), add(q, space.mul(q, r))
        q = Model(better.parts, 0)
        r = _short(space, one, b, q)
        if 2 * norm(r) > size:
            break
    off = norm(_short(space, one, a, q))
    if off >= space.one:
        raise Beyond("a division by what may be zero")
    return widened(q, norm(q) * off // (space.one - off) + 1)


def _short(space: Space, of: Model, a: Model, b: Model) -> Model:
    return add(of, space.mul(a, b), -1)


def root(space: Space, a: Model) -> Model:
    """The square root of what is positive: it is w within `|a - w^2| / w`."""
    if bounds(a)[0] <= 0 or middle(a) <= 0:
        raise Beyond("a square root of what may not be positive")
    one, b = space.constant(space.one), Model(a.parts, 0)
    r = space.constant(isqrt(space.one**3 // middle(a)))  # of 1 / sqrt(a), by Newton's iteration
    for _ in range(8):
        d = _short(space, one, b, space.mul(r, r))
        r = Model(add(r, space.scaled(space.mul(r, d), space.one >> 1)).parts, 0)
        if norm(d) < 8:
            break
    w = Model(space.mul(b, r).parts, 0)
    low = bounds(w)[0]
    if low <= 0:
        raise Beyond("a square root of what is near zero")
    return widened(w, norm(_short(space, a, w, w)) * space.one // low + 1)


def magnitude(space: Space, a: Model) -> Model:
    """The absolute value."""
    low, high = bounds(a)
    if low >= 0:
        return a
    if high <= 0:
        return add(Model({}, 0), a, -1)
    most = max(-low, high)
    return space.constant(most >> 1, most - (most >> 1))


def sign(space: Space, a: Model) -> Model:
    """The slope of the absolute value: any number between -1 and 1 where the sign is not known."""
    low, high = bounds(a)
    return space.constant(space.one) if low >= 0 else space.constant(-space.one) if high <= 0 else Model({}, space.one)
