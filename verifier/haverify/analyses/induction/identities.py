"""Identities that a glance finds: two premises whose multiples add up to a sum of even powers (proof `psatz`)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import Any

from haverify.maths.digits import rational_text
from haverify.maths.polynomial import Monomial, Polynomial
from haverify.obligations.formula import Formula, Literal
from haverify.obligations.functions import factors

Q = Fraction
Json = Any


def glance(entries: Sequence[Formula]) -> Json | None:
    """A proof from one premise or two, None where there is none of this kind."""
    leaves = [(i, f) for i, f in enumerate(entries) if isinstance(f, Literal) and f.op in ("<", "<=", "==")]
    for i, f in leaves:
        for sign in (-1, 1) if f.op == "==" else (-1,):
            found = _proof([(i, f, Q(sign))])
            if found is not None:
                return found
    for i, f in leaves:
        for j, g in leaves:
            if i != j and g.op != "==":
                for a in _ratios(f.polynomial, g.polynomial):
                    if f.op == "==" or a > 0:
                        found = _proof([(i, f, -a), (j, g, Q(-1))])
                        if found is not None:
                            return found
    return None


def _ratios(p: Polynomial, q: Polynomial) -> Iterator[Q]:
    """Numbers a for which `a p + q` has no term with one of the first monomials of q that are no squares."""
    seen = set[Q]()
    for m, c in q.terms.items():
        if m and m in p.terms:
            a = -c / p.terms[m]
            if a and a not in seen:
                seen.add(a)
                yield a
        if len(seen) > 3:
            return


def _proof(parts: list[tuple[int, Literal, Q]]) -> Json | None:
    """Premises times numbers (at most 0 for inequalities) and even powers that add up to 0 and are above it."""
    rest: dict[Monomial, Q] = {}
    for _, f, q in parts:
        for m, c in f.polynomial.terms.items():
            rest[m] = rest.get(m, Q(0)) - q * c
    if any(c < 0 or any(e % 2 for _, e in m) for m, c in rest.items() if c):
        return None
    strict = next(((i, -q) for i, f, q in parts if f.op == "<" and q < 0), None)
    above = rest.pop((), Q(0))
    if not above and strict is None:
        return None
    squares: list[Json] = [[rational_text(-q), [i]] for i, f, q in parts if f.op != "==" and (above or i != strict[0])]  # type: ignore[index]
    squares += [[[[rational_text(c), [["1", *_root(m)]]]], []] for m, c in rest.items() if c]
    equal = [[i, [[rational_text(q)]]] for i, f, q in parts if f.op == "=="]
    last = [rational_text(above), []] if above else [rational_text(strict[1]), [strict[0]]]  # type: ignore[index]
    return ["psatz", squares, equal, last]


def _root(m: Monomial) -> tuple[str, ...]:
    return factors(tuple((v, e // 2) for v, e in m))
