"""The last instant that a condition itself speaks of: `time <= 2 s implies P` is true of all later ones."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from fractions import Fraction

from haverify.model.expression import Expr
from haverify.obligations.parts import conjuncts, pushed

Number = Callable[[Expr], Fraction | None]

_UPPER = {"<": (0, 1), "<=": (0, 1), ">": (1, 0), ">=": (1, 0)}  # where `time` and its bound stand


def implied_end(condition: Expr, number: Number) -> Fraction | None:
    """A time after which `condition`, claimed always, is true by its shape; None where it has no such shape.

    `number` gives the value of an expression in constants, None for others.
    """
    ends = [_true_after(c, number) for c in conjuncts(pushed(condition))]
    known = [e for e in ends if e is not None]
    return max(known) if known and len(known) == len(ends) else None


def _true_after(e: Expr, number: Number) -> Fraction | None:
    if e.op == "not":
        return _false_after(e.children[0], number)
    if e.op != "implies":
        return None
    premise, conclusion = e.children
    return _least((_false_after(premise, number), _true_after(conclusion, number)))


def _false_after(e: Expr, number: Number) -> Fraction | None:
    if e.op == "and":
        return _least(_false_after(c, number) for c in e.children)
    if e.op not in _UPPER:
        return None
    clock, bound = (e.children[k] for k in _UPPER[e.op])
    return number(bound) if clock.op == "time" else None


def _least(ends: Iterable[Fraction | None]) -> Fraction | None:
    return min((e for e in ends if e is not None), default=None)
