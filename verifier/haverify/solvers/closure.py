"""A domain as the closed set that runs may dwell in (`LANGUAGE S6`)."""

from __future__ import annotations

from haverify.model.expression import TRUE, Expr
from haverify.model.hybrid import Range
from haverify.solvers.frame import Frame

_NEGATED = {"<": ">=", "<=": ">", ">": "<=", ">=": "<", "==": "!=", "!=": "=="}
_CLOSED = {"<": "<=", ">": ">="}
_DUAL = {"and": "or", "or": "and", "true": "false", "false": "true"}


def closure(e: Expr, frame: Frame, holds: bool = True) -> Expr:
    """`e` (or its negation) with negations pushed inwards, `<` read as `<=`, `>` as `>=` and `!=` as true."""
    if e.op in ("and", "or"):
        return Expr(e.op if holds else _DUAL[e.op], tuple(closure(c, frame, holds) for c in e.children), span=e.span)
    if e.op == "not":
        return closure(e.children[0], frame, not holds)
    if e.op == "implies":
        left, right = e.children
        return Expr(
            "or" if holds else "and", (closure(left, frame, not holds), closure(right, frame, holds)), span=e.span
        )
    if e.op in _NEGATED:
        return _comparison(e, holds)
    if e.op in ("true", "false"):
        return e if holds else Expr(_DUAL[e.op])
    return _named(e, frame, holds)


def _comparison(e: Expr, holds: bool) -> Expr:
    op = e.op if holds else _NEGATED[e.op]
    return TRUE if op == "!=" else Expr(_CLOSED.get(op, op), e.args, e.unit, e.span)


def _named(e: Expr, frame: Frame, holds: bool) -> Expr:
    """A truth value behind a name is looked into; any other atom stays."""
    inner: Expr | Range | None = None
    if e.op == "let":
        inner = frame.let(e.name)
    elif e.op == "const" and e.name in frame.scope.constants:
        inner = frame.scope.constants[e.name].value
    if isinstance(inner, Expr):
        return closure(inner, frame, holds)
    if e.op == "if":
        condition, yes, no = e.children
        left = Expr("and", (closure(condition, frame), closure(yes, frame, holds)))
        return Expr("or", (left, Expr("and", (closure(condition, frame, False), closure(no, frame, holds)))))
    return e if holds else Expr("not", (e,), span=e.span)
