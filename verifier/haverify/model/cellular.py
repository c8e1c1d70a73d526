"""Cellular automata and relations: finite partial functions and sets of pairs."""

from __future__ import annotations

from haverify.model.expression import Expr
from haverify.text.record import record
from haverify.text.span import Span


@record
class Rule:
    """`left -> right`, both as bit strings."""

    left: str
    right: str
    span: Span | None = None


@record
class CellularAutomaton:
    """Cells `first ++ second` (two enumerations with bit codes) and rules; or `next(argument) = formula`."""

    name: str
    cell: str
    first: str
    second: str
    rules: tuple[Rule, ...]
    argument: str | None = None
    formula: Expr | None = None
    doc: str = ""
    span: Span | None = None


@record
class Relation:
    """A finite set of pairs of names; `is_map` where every line is written `a -> b`."""

    name: str
    pairs: tuple[tuple[str, str], ...]
    is_map: bool
    doc: str = ""
    span: Span | None = None
    spans: tuple[Span, ...] = ()
