"""Bounds on `abs`, `min` and `max` as conjunctions, where a proof of those is a proof of the case split."""

from __future__ import annotations

from haverify.model.expression import Expr

UPPER = frozenset({"<", "<="})
LOWER = frozenset({">", ">="})


def spread(e: Expr) -> Expr:
    """`e` with `abs(a) <= b`, `max(a, ..) <= b`, `min(a, ..) >= b` in positive places written as conjunctions.

    Equivalent to `e`. Whatever shows the signs of the new literals shows those that the case split asks for.
    """
    if e.op in ("and", "or"):
        return Expr(e.op, tuple(spread(c) for c in e.children), e.unit, e.span)
    if e.op == "implies":
        premise, conclusion = e.children
        return Expr("implies", (premise, spread(conclusion)), e.unit, e.span)
    if e.op in UPPER or e.op in LOWER:
        return _comparison(e)
    return e


def _comparison(e: Expr) -> Expr:
    a, b = e.children
    if e.op in UPPER:
        left, right = _bounded_above(a), _bounded_below(b)
    else:
        left, right = _bounded_below(a), _bounded_above(b)
    if len(left) == 1 and len(right) == 1:
        return e
    members = tuple(spread(Expr(e.op, (x, y), e.unit, e.span)) for x in left for y in right)
    return Expr("and", members, None, e.span)


def _bounded_above(e: Expr) -> tuple[Expr, ...]:
    """The expressions that all have to stay below a bound for `e` to do so."""
    if e.op == "abs":
        (inner,) = e.children
        return (inner, Expr("neg", (inner,), e.unit, e.span))
    return e.children if e.op == "max" else (e,)


def _bounded_below(e: Expr) -> tuple[Expr, ...]:
    return e.children if e.op == "min" else (e,)
