"""Quantities as exact polynomials in the state, in params, and in whatever else they read, which is left as it is."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from haverify.maths.polynomial import Polynomial, constant, variable
from haverify.model.expression import Expr
from haverify.text.record import field, holder

Q = Fraction
TERMS, POWER = 300, 12  # of a polynomial; more is not looked at
LEAVES = ("var", "param")
Key = tuple[object, ...]


class TooLargeError(Exception):
    """A polynomial has very many terms."""


@holder
class Normal:
    """Polynomials of expressions; equal expressions that are no polynomials have one name, which starts with `@`."""

    others: dict[Key, str] = field(default_factory=dict)

    def of(self, e: Expr, known: Mapping[tuple[str, str], Expr]) -> Polynomial:
        """The polynomial of an expression, in a mode where lets and constants stand for what is given.

        Raises
        ------
        TooLargeError           if it has very many terms
        """
        if e.op == "num":
            return constant(Q(str(e.args[0])))
        if e.op in LEAVES:
            return variable(e.name)
        if e.op == "time":
            return variable("time")
        if e.op in ("let", "const") and (e.op, e.name) in known:
            return self.of(known[e.op, e.name], known)
        parts = [self.of(c, known) for c in e.children]
        return _sized(self._combined(e, parts))

    def _combined(self, e: Expr, parts: list[Polynomial]) -> Polynomial:
        if e.op == "neg":
            return -parts[0]
        if e.op == "+":
            return _sum(parts)
        if e.op == "-" and len(parts) == 2:
            return parts[0] - parts[1]
        if e.op == "*":
            return _product(parts)
        if e.op == "/" and len(parts) == 2:
            return _product([parts[0], self._inverse(parts[1])])
        power = parts[1].constant if e.op == "^" and len(parts) == 2 else None
        if power is not None and power.denominator == 1 and 0 <= power <= POWER:
            return _product([parts[0]] * int(power)) if power else constant(1)
        return self._other((e.op, *parts, *(a for a in e.args if not isinstance(a, Expr))))

    def _inverse(self, p: Polynomial) -> Polynomial:
        c = p.constant
        return constant(1 / c) if c else self._other(("inverse", p))

    def _other(self, key: Key) -> Polynomial:
        return variable(self.others.setdefault(key, f"@{len(self.others)}"))


def _sum(parts: list[Polynomial]) -> Polynomial:
    found = parts[0]
    for p in parts[1:]:
        found = found + p
    return found


def _product(parts: list[Polynomial]) -> Polynomial:
    found = parts[0]
    for p in parts[1:]:
        if len(found.whole) * len(p.whole) > 4 * TERMS:
            raise TooLargeError
        found = _sized(found * p)
    return found


def _sized(p: Polynomial) -> Polynomial:
    if len(p.whole) > TERMS:
        raise TooLargeError
    return p
