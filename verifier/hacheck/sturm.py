"""Exact decision of a formula in one variable on an interval, by Sturm sequences.

Polynomials are lists of integers, lowest power first, no zero at the end; positive factors are dropped freely.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from functools import partial
from itertools import pairwise
from math import gcd

from hacheck.formula import Formula, literals, sign_fits, true
from hacheck.polynomial import Poly
from hacheck.rational import MAX_BITS, Beyond, spend

Dense = list[int]
Root = tuple[Fraction, Fraction]  # equal ends: the root itself; else the one root between, no root at the ends


def dense(p: Poly) -> Dense:
    """A positive multiple of a polynomial in at most one variable."""
    out = [0] * (1 + max(map(len, p.terms), default=0))
    for m, c in p.terms.items():
        out[len(m)] = c
    return _primitive(out)


def _primitive(p: Dense) -> Dense:
    while p and not p[-1]:
        p = p[:-1]
    if max(map(int.bit_length, p), default=0) > MAX_BITS:
        raise Beyond("numbers grow beyond what the checker allows")
    g = gcd(*p) if p else 1
    return p if g == 1 else [c // g for c in p]


def _divide(p: Dense, d: Dense) -> tuple[Dense, Dense]:
    """Quotient and remainder of a positive multiple of p by d, each up to a positive factor."""
    quotient = [0] * max(1, len(p) - len(d) + 1)
    lead = abs(d[-1])
    while len(p) >= len(d):
        spend(len(d) * (1 + (p[-1].bit_length() + lead.bit_length() >> 8)))
        shift, factor = len(p) - len(d), p[-1] if d[-1] > 0 else -p[-1]
        p, quotient = [c * lead for c in p], [c * lead for c in quotient]
        quotient[shift] += factor
        for i, c in enumerate(d):
            p[shift + i] -= factor * c
        while p and not p[-1]:
            p.pop()
    return _primitive(quotient), _primitive(p)


def _gcd(p: Dense, q: Dense) -> Dense:
    while q:
        p, q = q, _divide(p, q)[1]
    return p


def _slope(p: Dense) -> Dense:
    return _primitive([k * c for k, c in enumerate(p)][1:])


def square_free(p: Dense) -> Dense:
    """A polynomial with the same roots, all simple."""
    return _divide(p, _gcd(p, _slope(p)))[0] if len(p) > 2 else p


def sign(p: Dense, x: Fraction) -> int:
    """The sign of p at x, by Horner's rule on integers."""
    n, d, scale, value = x.numerator, x.denominator, 1, 0
    spend(len(p) * (1 + (len(p) * (n.bit_length() + d.bit_length()) >> 8)))
    for c in reversed(p):
        value = value * n + c * scale
        scale *= d
    return (value > 0) - (value < 0)


def _variations(chain: list[Dense], x: Fraction) -> int:
    signs = [s for s in (sign(p, x) for p in chain) if s]
    return sum(a != b for a, b in pairwise(signs))


def roots(p: Dense, low: Fraction, high: Fraction) -> list[Root]:
    """The roots in (low, high] of a square-free polynomial, isolated, in order.

    Sturm: a square-free p has V(a) - V(b) roots in (a, b], V counting sign changes of its chain.
    """
    if len(p) == 2:
        x = Fraction(-p[0], p[1])
        return [(x, x)] if low < x <= high else []
    chain = [p, _slope(p)]
    while chain[-1]:
        chain.append([-c for c in _divide(chain[-2], chain[-1])[1]])
    out: list[Root] = []
    stack = [(low, high, _variations(chain[:-1], low), _variations(chain[:-1], high))]
    while stack:
        a, b, va, vb = stack.pop()
        if va - vb == 1 and not sign(p, b):
            out.append((b, b))
        elif va - vb == 1 and sign(p, a):
            out.append((a, b))
        elif va > vb:
            m = (a + b) / 2
            vm = _variations(chain[:-1], m)
            stack += [(m, b, vm, vb), (a, m, va, vm)]
    return out


def _at_root(p: Dense, root: Root) -> int:
    """The sign of p at a root of a multiple of its square-free part."""
    a, b = root
    free = square_free(p)
    return 0 if a < b and sign(free, a) * sign(free, b) < 0 else sign(p, a)


def _extent(p: Dense, low: Fraction | None, high: Fraction | None) -> tuple[Fraction, Fraction]:
    """The interval with infinite ends moved beyond all roots (Cauchy's bound), where no sign changes any more."""
    reach = Fraction(2 + max((abs(c) for c in p[:-1]), default=0) // abs(p[-1]))
    lo = low if low is not None else min(-reach, (high if high is not None else reach) - 1)
    return lo, high if high is not None else max(reach, lo + 1)


def always(f: Formula, low: Fraction | None, high: Fraction | None) -> bool:
    """Is f, a formula in one variable, true for all its values in [low, high]?"""
    if isinstance(f, bool) or f[0] == "and":
        return f if isinstance(f, bool) else all(always(g, low, high) for g in f[1:])
    polys = {id(p): dense(p) for _, p in literals(f)}
    product: Dense = [1]
    for p in polys.values():
        spend(len(product) * len(p))
        share = _divide(p, _gcd(p, product))[0] if len(product) > 1 else p
        product = [sum(share[i] * product[k - i] for i in range(len(share)) if 0 <= k - i < len(product))
                   for k in range(len(share) + len(product) - 1)]  # fmt: skip
    product = square_free(_primitive(product))

    def fits(signs: Callable[[Dense], int]) -> bool:
        return true(f, lambda op, p: sign_fits(op, signs(polys[id(p)])))

    lo, hi = _extent(product, low, high)
    inner = [r for r in roots(product, lo, hi) if r[0] < hi]
    ends = [lo, *(x for r in inner for x in r), hi]
    samples = [lo, hi, *((a + b) / 2 for a, b in zip(ends[::2], ends[1::2], strict=True))]
    return all(fits(partial(sign, x=x)) for x in samples) and all(fits(partial(_at_root, root=r)) for r in inner)
