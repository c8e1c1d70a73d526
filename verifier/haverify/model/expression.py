"""Typed exact expressions: one kind of node, as in `core.json` (docs/core.md section 2)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from fractions import Fraction
from typing import TYPE_CHECKING

from haverify.text.record import field, record
from haverify.text.span import Span

if TYPE_CHECKING:
    from haverify.model.unit import Unit


@record
class Expr:
    """A node `op(args)`.

    `op` is one of docs/core.md section 2, or `num` with one Fraction, or `true`, `false` with none. Arguments are
    expressions, strings (names) and Fractions, in the order of the core. `unit` and `span` are for people: they are
    no part of equality or hash. `unit` is None for truth values, enumeration values and in unitless files.
    """

    op: str
    args: tuple[Arg, ...] = ()
    unit: Unit | None = field(default=None, compare=False)
    span: Span | None = field(default=None, compare=False, repr=False)

    @property
    def name(self) -> str:
        """The name of a `const`, `param`, `input`, `var`, `let`, `bound`, `at` or `jump` node."""
        return str(self.args[0])

    @property
    def children(self) -> tuple[Expr, ...]:
        """The arguments that are expressions."""
        return tuple([a for a in self.args if a.__class__ is Expr])


Arg = Expr | str | Fraction | tuple[tuple[str, Expr], ...]

TRUE = Expr("true")
FALSE = Expr("false")


def number(value: Fraction | int, unit: Unit | None = None, span: Span | None = None) -> Expr:
    """The exact number `value`, measured in `unit`."""
    return Expr("num", (Fraction(value),), unit, span)


def nodes(e: Expr) -> Iterator[Expr]:
    """Every node of an expression, parents before children, from left to right."""
    stack = [e]
    while stack:
        node = stack.pop()
        yield node
        for a in reversed(node.args):
            if a.__class__ is Expr:
                stack.append(a)
            elif a.__class__ is tuple:
                stack.extend([v for _, v in reversed(a)])


def operands(e: Expr) -> tuple[Expr, ...]:
    """The direct subexpressions, those inside named argument lists included."""
    found: list[Expr] = []
    for a in e.args:
        if isinstance(a, Expr):
            found.append(a)
        elif isinstance(a, tuple):
            found.extend(v for _, v in a)
    return tuple(found)


def rebuild(e: Expr, change: Callable[[Expr], Expr]) -> Expr:
    """`e` with each direct subexpression `c` replaced by `change(c)`."""
    args = tuple(_change_arg(a, change) for a in e.args)
    return e if args == e.args else Expr(e.op, args, e.unit, e.span)


def _change_arg(a: Arg, change: Callable[[Expr], Expr]) -> Arg:
    if isinstance(a, Expr):
        return change(a)
    if isinstance(a, tuple):
        return tuple((k, change(v)) for k, v in a)
    return a
