"""Sparse polynomials over the rationals."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction

from hacheck.rational import MAX_BITS, MAX_DEGREE, Beyond, spend

Mono = tuple[tuple[str, int], ...]  # (variable, exponent) pairs, sorted by variable
Poly = dict[Mono, Fraction]  # no zero coefficients; {} is 0


def const(q: Fraction | int) -> Poly:
    """The constant polynomial."""
    return {(): q if isinstance(q, Fraction) else Fraction(q)} if q else {}


def var(name: str) -> Poly:
    """The polynomial that is one variable."""
    return {((name, 1),): Fraction(1)}


ONE = const(1)


def constant(p: Poly) -> Fraction | None:
    """The value of a polynomial without variables."""
    return Fraction(0) if not p else p.get(()) if len(p) == 1 else None


def names(p: Poly) -> set[str]:
    """The variables that occur."""
    return {v for m in p for v, _ in m}


def _bits(p: Poly) -> int:
    return max([c.numerator.bit_length() + c.denominator.bit_length() for c in p.values()], default=0)


def add(p: Poly, q: Poly, sign: int = 1) -> Poly:
    """`p + sign * q` for a sign of 1 or -1."""
    spend(len(q) + 1)
    out = dict(p)
    for m, c in q.items():
        if m in out:
            total = out.pop(m) + (c if sign > 0 else -c)
            bits = total.denominator.bit_length()
            spend(bits * bits >> 20)
            if bits > MAX_BITS:
                raise Beyond("numbers grow beyond what the checker allows")
            if total:
                out[m] = total
        else:
            out[m] = c if sign > 0 else -c
    return out


def _times(m: Mono, n: Mono) -> Mono:
    if not m or not n:
        return m or n
    out = dict(m)
    for v, e in n:
        out[v] = out.get(v, 0) + e
    if sum(out.values()) > MAX_DEGREE:
        raise Beyond(f"a polynomial has a degree above {MAX_DEGREE}")
    return tuple(sorted(out.items()))


def mul(p: Poly, q: Poly) -> Poly:
    """The product."""
    if p == ONE or q == ONE:
        return q if p == ONE else p
    bits, steps = _bits(p) + _bits(q), len(p) * len(q) + 1
    spend(steps + (steps * bits * bits >> 20))
    if bits > MAX_BITS:
        raise Beyond("numbers grow beyond what the checker allows")
    out: Poly = {}
    for m, a in p.items():
        for n, b in q.items():
            k = _times(m, n)
            out[k] = out[k] + a * b if k in out else a * b
    return {m: c for m, c in out.items() if c}


def power(p: Poly, n: int) -> Poly:
    """`p ** n` for n >= 0, by multiplication from the left."""
    q = constant(p)
    if n > MAX_DEGREE and (q is None or n * (_bits(p) + 1) > MAX_BITS):
        raise Beyond("an exponent is too large")
    if q is not None:
        return const(q**n)
    out = ONE
    for _ in range(n):
        out = mul(out, p)
    return out


def scale(p: Poly, q: Fraction | int) -> Poly:
    """`q * p`."""
    return {m: -c for m, c in p.items()} if q == -1 else mul(p, const(q))


def total(terms: Iterable[Poly]) -> Poly:
    """The sum."""
    out: Poly = {}
    for p in terms:
        out = add(out, p)
    return out


def by_power(p: Poly, v: str) -> dict[int, Poly]:
    """Coefficients with respect to one variable: `p = sum(c[k] * v**k)`."""
    out: dict[int, Poly] = {}
    for m, c in p.items():
        k = dict(m).get(v, 0)
        out.setdefault(k, {})[tuple(x for x in m if x[0] != v)] = c
    return out


def derivative(p: Poly, v: str) -> Poly:
    """The partial derivative."""
    parts = by_power(p, v).items()
    return total(mul(scale(c, k), power(var(v), k - 1)) for k, c in parts if k)


def along(p: Poly, rates: dict[str, Poly]) -> Poly:
    """The derivative along a flow."""
    return total(mul(derivative(p, v), r) for v, r in rates.items())


Powers = dict[tuple[str, int], Poly]


def substitute(p: Poly, env: dict[str, Poly], powers: Powers) -> Poly:
    """`p` with variables replaced at once; `powers` remembers the powers of this `env`."""
    out: Poly = {}
    for m, c in p.items():
        rest = tuple([x for x in m if x[0] not in env])
        term: Poly = {rest: c}
        for v, k in m if len(rest) < len(m) else ():
            if v in env:
                if (v, k) not in powers:
                    powers[v, k] = power(env[v], k)
                term = mul(powers[v, k], term)
        out = add(out, term) if out else term
    return out
