"""What makes a condition false where everything in it is defined: its negation, pushed inwards to the comparisons.

The negation of `1 / b <= c` as a formula is also true where `b` is zero; the denial, `1 / b > c`, is not. A run that
shows a violation has to end where the denial holds.
"""

from __future__ import annotations

from haverify.model.expression import FALSE, TRUE, Expr

_OPPOSITE = {"<": ">=", "<=": ">", ">": "<=", ">=": "<", "==": "!=", "!=": "=="}
_DUAL = {"and": "or", "or": "and"}


def denial(e: Expr) -> Expr:
    """The condition that holds where `e` is false and defined."""
    if e.op in _OPPOSITE:
        return Expr(_OPPOSITE[e.op], e.args, e.unit, e.span)
    if e.op in _DUAL:
        return Expr(_DUAL[e.op], tuple(denial(c) for c in e.children), e.unit, e.span)
    if e.op == "implies":
        premise, conclusion = e.children
        return Expr("and", (premise, denial(conclusion)), e.unit, e.span)
    if e.op == "not":
        return e.children[0]
    if e.op in ("true", "false"):
        return FALSE if e.op == "true" else TRUE
    return Expr("not", (e,), e.unit, e.span)
