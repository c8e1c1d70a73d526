"""Conditions on quantities: what claims, domains, guards and starts say of a state."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction

from haverify.model.expression import Expr, nodes, rebuild
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import record

Q = Fraction

COMPARISONS = {"<", "<=", ">", ">=", "==", "!="}
NEGATED = {"<": ">=", "<=": ">", ">": "<=", ">=": "<", "==": "!=", "!=": "=="}
CLOSED = {"<": "<=", ">": ">=", "<=": "<=", ">=": ">=", "==": "=="}
Definitions = Mapping[tuple[str, str], Expr]
CORNERS = ("abs", "min", "max")
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


def is_true(c: Condition) -> bool:
    """Whether a condition holds whatever its comparisons say."""
    if isinstance(c, bool | Atom):
        return c is True
    return (all if isinstance(c, Every) else any)(is_true(m) for m in c.members)


def closed(c: Condition) -> Condition:
    """The condition as a domain is read: bounds closed, `!=` left out."""
    if isinstance(c, bool):
        return c
    if isinstance(c, Atom):
        return True if c.op == "!=" else Atom(c.quantity, CLOSED[c.op])
    members = tuple(closed(m) for m in c.members)
    return Every(members) if isinstance(c, Every) else Some(members)


def condition(e: Expr, definitions: Definitions, is_denied: bool = False) -> Condition:
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
        left, right = (in_pairs(c, definitions) for c in e.children)
        return _compared(left, right, NEGATED[e.op] if is_denied else e.op)
    raise OutsideFragmentError(f"`{e.op}` in a claim about a flow")


def _compared(left: Expr, right: Expr, op: str) -> Condition:
    """A comparison, magnitudes and extremes in it split into their cases."""
    if any(n.op in CORNERS for e in (left, right) for n in nodes(e)):
        if op in ("<", "<=", ">", ">="):
            sign = -1 if op[0] == "<" else 1
            for opened, is_left in ((_opened(left, sign), True), (_opened(right, -sign), False)):
                if opened is not None:
                    branches, is_any = opened
                    members = tuple(_compared(b, right, op) if is_left else _compared(left, b, op) for b in branches)
                    return Some(members) if is_any else Every(members)
        return _by_sides(left, right, op)
    if left.op == "num":
        left, right, op = right, left, MIRRORED[op]
    return Atom(left if right == Expr("num", (Q(0),)) else Expr("-", (left, right)), op)


def _opened(e: Expr, sign: int) -> tuple[list[Expr], bool] | None:
    """An expression with each branch of a corner that it is a sum of, and whether one of them has to do, or all.

    It is to be large (`sign` 1) or small: the largest of numbers is large where one of them is, small where all are.
    """
    if e.op in CORNERS:
        return list(branches(e)), (sign > 0) is (e.op != "min")
    for k, (c, s) in enumerate(zip(e.args, _signs(e, sign), strict=False)):
        opened = _opened(c, s) if isinstance(c, Expr) and s != 0 else None
        if opened is not None:
            return [Expr(e.op, (*e.args[:k], b, *e.args[k + 1 :]), e.unit, e.span) for b in opened[0]], opened[1]
    return None


def _signs(e: Expr, sign: int) -> tuple[int, ...]:
    """Which way each argument moves a sum, or a multiple by a number; 0 where it is not known."""
    if e.op == "-":
        return (sign, *[-sign] * (len(e.args) - 1))
    if e.op in ("+", "neg"):
        return (sign if e.op == "+" else -sign,) * len(e.args)
    if e.op == "*" and len(e.children) == 2:
        factors = [Q(str(c.args[0])) if c.op == "num" else Q(0) for c in e.children]
        return tuple(sign * _sign(q) for q in reversed(factors))
    if e.op == "scale":
        return 0, 0, sign * _sign(Q(str(e.args[0])))
    return ()


def _sign(q: Q) -> int:
    return (q > 0) - (q < 0)


def _by_sides(left: Expr, right: Expr, op: str) -> Condition:
    """A comparison that holds on the side of a corner, or on both whichever it is."""
    found = (n for e in (left, right) for n in nodes(e) if n.op in CORNERS)
    corner = next(n for n in found if not any(m.op in CORNERS for c in n.children for m in nodes(c)))
    first, second = branches(corner)
    cases = [_compared(replaced(left, corner, b), replaced(right, corner, b), op) for b in (first, second)]
    is_first = _compared(first, second, "<=" if corner.op == "min" else ">=")
    is_second = _compared(first, second, ">=" if corner.op == "min" else "<=")
    return Some((Every((is_first, cases[0])), Every((is_second, cases[1])), Every(tuple(cases))))


def branches(corner: Expr) -> tuple[Expr, ...]:
    """What a corner is the largest, or the smallest, of."""
    if corner.op != "abs":
        return corner.children
    (inner,) = corner.children
    return inner, Expr("neg", (inner,), inner.unit)


def replaced(e: Expr, old: Expr, new: Expr) -> Expr:
    """An expression with all parts that are some expression replaced by another."""
    return new if e == old else rebuild(e, lambda c: replaced(c, old, new))


def in_pairs(e: Expr, definitions: Definitions) -> Expr:
    """An expression with corners of two arguments, and the lets written out that hold corners."""
    if (meant := definitions.get((e.op, e.name)) if e.op in ("let", "const") else None) is not None:
        inner = in_pairs(meant, definitions)
        return inner if any(n.op in CORNERS or n.op == "if" for n in nodes(inner)) else e
    made = rebuild(e, lambda c: in_pairs(c, definitions))
    if made.op == "clamp":
        x, low, high = made.children
        return Expr("min", (Expr("max", (x, low), e.unit), high), e.unit)
    if made.op in ("min", "max") and len(made.children) > 2:
        first, *rest = made.children
        return Expr(made.op, (first, in_pairs(Expr(made.op, tuple(rest), e.unit), definitions)), e.unit)
    return made
