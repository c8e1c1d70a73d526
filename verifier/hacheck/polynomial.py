"""Sparse polynomials with integer coefficients over one positive denominator."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from fractions import Fraction
from math import gcd, lcm
from typing import NamedTuple

from hacheck.rational import MAX_BITS, MAX_DEGREE, Beyond, spend

Mono = tuple[str, ...]  # variables in order, each as often as its exponent says


class Poly(NamedTuple):
    """The sum of `c` times the product of `m`, divided by `unit`; no zero, lowest terms: equal ones compare equal."""

    terms: dict[Mono, int]
    unit: int
    bits: int  # what the longest coefficient and the unit take together


_LENGTH = int.bit_length


def _made(terms: dict[Mono, int], unit: int) -> Poly:
    """A polynomial in lowest terms, unless its numbers are too long."""
    if not all(terms.values()):
        terms = {m: c for m, c in terms.items() if c}
    if unit > 1 and (common := gcd(unit, *terms.values())) > 1:
        terms, unit = {m: c // common for m, c in terms.items()}, unit // common
    bits = unit.bit_length() + (max(map(_LENGTH, terms.values())) if terms else 0)
    spend(len(terms) + 1 + (len(terms) * bits * bits >> 20))
    if bits > MAX_BITS:
        raise Beyond("numbers grow beyond what the checker allows")
    return tuple.__new__(Poly, (terms, unit, bits))  # as Poly(...), in half the time


def const(q: Fraction | int) -> Poly:
    """The constant polynomial."""
    n, d = q.numerator, q.denominator
    return _made({(): n}, d) if n.bit_length() > 400 else Poly({(): n} if n else {}, d, d.bit_length() + n.bit_length())


def var(name: str) -> Poly:
    """The polynomial that is one variable."""
    return Poly({(name,): 1}, 1, 2)


ZERO, ONE = const(0), const(1)


def constant(p: Poly) -> Fraction | None:
    """The value of a polynomial without variables."""
    return Fraction(p.terms.get((), 0), p.unit) if not p.terms or list(p.terms) == [()] else None


def names(p: Poly) -> set[str]:
    """The variables that occur."""
    return set().union(*p.terms)


def total(summands: Iterable[tuple[int, Poly]], divisor: int = 1) -> Poly:
    """The sum of integer multiples, divided by a positive integer."""
    found = list(summands)
    unit = 1
    for _, p in found:
        if p.unit != unit:
            unit = lcm(unit, p.unit)
            if unit.bit_length() > MAX_BITS:
                raise Beyond("numbers grow beyond what the checker allows")
    spend(len(found) * (1 + (unit.bit_length() ** 2 >> 20)))
    out: dict[Mono, int] = {}
    for k, (terms, own, _) in found:
        k *= unit // own
        for m, c in terms.items():
            out[m] = out[m] + k * c if m in out else k * c
    return _made(out, unit * divisor)


def add(p: Poly, q: Poly, sign: int = 1) -> Poly:
    """`p + sign * q` for an integer sign."""
    if p.unit != q.unit:
        return total(((1, p), (sign, q)))
    out = dict(p.terms)
    for m, c in q.terms.items():
        out[m] = out[m] + sign * c if m in out else sign * c
    return _made(out, p.unit)


def mul(p: Poly, q: Poly) -> Poly:
    """The product."""
    if p == ONE or q == ONE:
        return q if p == ONE else p
    bits, steps = p.bits + q.bits, len(p.terms) * len(q.terms)
    if bits > MAX_BITS:
        raise Beyond("numbers grow beyond what the checker allows")
    spend(steps + (steps * bits * bits >> 20))
    out: dict[Mono, int] = {}
    for m, a in p.terms.items():
        for n, b in q.terms.items():
            k = tuple(sorted(m + n)) if m and n else m or n
            out[k] = out[k] + a * b if k in out else a * b
    if max(map(len, out), default=0) > MAX_DEGREE:
        raise Beyond(f"a polynomial has a degree above {MAX_DEGREE}")
    return _made(out, p.unit * q.unit)


def power(p: Poly, n: int) -> Poly:
    """`p ** n` for n >= 0, of a sum by multiplication from the left."""
    if n > MAX_DEGREE and (names(p) or n * p.bits > MAX_BITS):
        raise Beyond("an exponent is too large")
    if len(p.terms) == 1:
        ((m, c),) = p.terms.items()
        if len(m) * n > MAX_DEGREE or n * p.bits > MAX_BITS:
            raise Beyond("an exponent is too large")
        return _made({tuple(sorted(m * n)): c**n}, p.unit**n)
    if not p.terms:
        return ZERO if n else ONE
    out = ONE
    for _ in range(n):
        out = mul(out, p)
    return out


def scale(p: Poly, q: Fraction | int) -> Poly:
    """`q * p`."""
    return Poly({m: -c for m, c in p.terms.items()}, p.unit, p.bits) if q == -1 else mul(p, const(q))


def by_power(p: Poly, v: str) -> dict[int, Poly]:
    """Coefficients with respect to one variable: `p = sum(c[k] * v**k)`, perhaps not in lowest terms."""
    out: dict[int, dict[Mono, int]] = {}
    for m, c in p.terms.items():
        k = m.count(v)
        out.setdefault(k, {})[tuple([w for w in m if w != v]) if k else m] = c
    return {k: Poly(terms, p.unit, p.bits) for k, terms in out.items()}


def derivative(p: Poly, v: str) -> Poly:
    """The partial derivative."""
    out = {}
    for m, c in p.terms.items():
        if v in m:
            i = m.index(v)
            out[m[:i] + m[i + 1 :]] = c * m.count(v)
    return _made(out, p.unit)


class Env(dict[str, Poly]):
    """What replaces variables; it remembers what monomials become, so it is not changed once used."""

    def __init__(self, items: Mapping[str, Poly]) -> None:
        super().__init__(items)
        self.images: dict[Mono, Poly] = {(): ONE}

    def image(self, m: Mono) -> Poly:
        """What a monomial becomes."""
        if m not in self.images:
            self.images[m] = mul(self.image(m[:-1]), self[m[-1]] if m[-1] in self else var(m[-1]))
        return self.images[m]


def substitute(p: Poly, env: Env) -> Poly:
    """`p` with variables replaced at once."""
    if all(map(env.keys().isdisjoint, p.terms)):
        return p
    return total([(c, env.image(m)) for m, c in p.terms.items()], p.unit)
