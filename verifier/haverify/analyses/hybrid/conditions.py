"""Conditions on quantities: what claims, domains, guards and starts say of a state."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from haverify.model.expression import Expr
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import record

Q = Fraction

COMPARISONS = {"<", "<=", ">", ">=", "==", "!="}
NEGATED = {"<": ">=", "<=": ">", ">": "<=", ">=": "<", "==": "!=", "!=": "=="}
CLOSED = {"<": "<=", ">": ">=", "<=": "<=", ">=": ">=", "==": "=="}
MIRRORED = {"<": ">", "<=": ">=", ">": "<", ">=": "<=", "==": "==", "!=": "!="}


@record
class Atom:
    """`quantity op 0`."""

    quantity: Expr
    op: str


@record
class Every:
    """All of them hold."""

    members: tuple[Condition, ...]


@record
class Some:
    """At least one of them holds."""

    members: tuple[Condition, ...]


Condition = Atom | Every | Some | bool


def members(e: Expr) -> Iterator[Expr]:
    """The conjuncts of a condition."""
    if e.op == "and":
        for c in e.children:
            yield from members(c)
    elif e.op != "true":
        yield e


def atoms(c: Condition) -> Iterator[Atom]:
    """The comparisons in a condition."""
    if isinstance(c, Atom):
        yield c
    elif not isinstance(c, bool):
        for member in c.members:
            yield from atoms(member)


def closed(c: Condition) -> Condition:
    """The condition as a domain is read: bounds closed, `!=` left out."""
    if isinstance(c, bool):
        return c
    if isinstance(c, Atom):
        return True if c.op == "!=" else Atom(c.quantity, CLOSED[c.op])
    members = tuple(closed(m) for m in c.members)
    return Every(members) if isinstance(c, Every) else Some(members)


def condition(e: Expr, definitions: dict[tuple[str, str], Expr], is_denied: bool = False) -> Condition:
    """A truth-valued expression (or its denial) as comparisons of quantities with zero.

    Raises
    ------
    OutsideFragmentError    if it holds what is no comparison of numbers
    """
    if e.op in ("true", "false"):
        return (e.op == "true") is not is_denied
    if e.op == "not":
        return condition(e.children[0], definitions, not is_denied)
    if e.op in ("let", "const") and (e.op, e.name) in definitions:
        return condition(definitions[e.op, e.name], definitions, is_denied)
    if e.op == "implies":
        premise, conclusion = e.children
        parts = (condition(premise, definitions, not is_denied), condition(conclusion, definitions, is_denied))
        return Every(parts) if is_denied else Some(parts)
    if e.op in ("and", "or"):
        members = tuple(condition(c, definitions, is_denied) for c in e.children)
        return Every(members) if (e.op == "and") is not is_denied else Some(members)
    if e.op in COMPARISONS:
        return _compared(e.children[0], e.children[1], NEGATED[e.op] if is_denied else e.op)
    raise OutsideFragmentError(f"`{e.op}` in a claim about a flow")


def _compared(left: Expr, right: Expr, op: str) -> Condition:
    """A comparison, a magnitude on one side split into its cases."""
    if (left.op != "abs" and right.op == "abs") or left.op == "num":
        left, right, op = right, left, MIRRORED[op]
    if left.op == "abs":
        inner = left.children[0]
        minus = Expr("neg", (inner,))
        if op in ("<", "<="):
            return Every((_compared(inner, right, op), _compared(minus, right, op)))
        if op in (">", ">="):
            return Some((_compared(inner, right, op), _compared(minus, right, op)))
    return Atom(left if right == Expr("num", (Q(0),)) else Expr("-", (left, right)), op)
