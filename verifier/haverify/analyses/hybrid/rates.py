"""The rate of a quantity along a flow, as an expression."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from haverify.analyses.hybrid.conditions import Definitions
from haverify.model.expression import Expr
from haverify.obligations.translate import OutsideFragmentError

ZERO, ONE = Expr("num", (Fraction(0),)), Expr("num", (Fraction(1),))


def rate(e: Expr, rates: Mapping[str, Expr], definitions: Definitions) -> Expr:
    """The derivative of a polynomial by time, given those of the variables; what has none in `rates` keeps its value.

    Raises
    ------
    OutsideFragmentError    if it is no polynomial
    """

    def of(x: Expr) -> Expr:
        return rate(x, rates, definitions)

    if e.op in ("num", "pi", "param"):
        return ZERO
    if e.op == "time":
        return ONE
    if e.op == "var":
        return rates.get(e.name, ZERO)
    if e.op in ("let", "const") and (e.op, e.name) in definitions:
        return of(definitions[e.op, e.name])
    if e.op in ("+", "-", "neg"):
        return Expr(e.op, tuple(of(c) for c in e.children))
    if e.op == "*":
        terms = [_product([*e.children[:k], of(c), *e.children[k + 1 :]]) for k, c in enumerate(e.children)]
        return Expr("+", tuple(terms)) if len(terms) > 1 else terms[0]
    if e.op == "^" and e.children[1].op == "num":
        base, exponent = e.children
        n = Fraction(str(exponent.args[0]))
        if n.denominator == 1 and n >= 1:
            lower = Expr("^", (base, Expr("num", (n - 1,)))) if n > 1 else ONE
            return _product([Expr("num", (n,)), lower, of(base)])
    raise OutsideFragmentError(f"the rate of `{e.op}`")


def _product(factors: list[Expr]) -> Expr:
    if any(f == ZERO for f in factors):
        return ZERO
    kept = [f for f in factors if f != ONE]
    return Expr("*", tuple(kept)) if len(kept) > 1 else (kept[0] if kept else ONE)
