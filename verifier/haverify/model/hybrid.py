"""Hybrid automata as exact data: H = (Q, X, f, Init, D, E, G, R), desugared."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

from haverify.model.expression import Expr
from haverify.text.record import record
from haverify.text.span import Span

if TYPE_CHECKING:
    from haverify.model.unit import Unit


@record
class Range:
    """The closed interval between two expressions, in the unit of what it bounds."""

    low: Expr
    high: Expr


@record
class Constant:
    """One exact value, or a set (`Range`); `half` is half a unit of the last printed digit, under `digits n`."""

    name: str
    type: str  # "real", "bool" or an enumeration
    unit: Unit | None
    value: Expr | Range
    half: Fraction | None = None
    span: Span | None = None


@record
class Param:
    """One unknown value of `range` per run; `default` serves simulation and plots only."""

    name: str
    unit: Unit | None
    range: Range
    default: Expr | None
    span: Span | None = None


@record
class Input:
    """A value chosen by an adversary at every instant; without `range` a port to be bound."""

    name: str
    type: str
    unit: Unit | None
    range: Range | None
    rate: Range | None
    every: Expr | None
    span: Span | None = None


@record
class Variable:
    """A state variable; `type` is `real`, `bool` or an enumeration; `range` the declared window of the analysis."""

    name: str
    type: str
    unit: Unit | None
    range: Range | None
    span: Span | None = None


@record
class Output:
    """A `let`: a quantity computed from the state."""

    name: str
    type: str
    unit: Unit | None
    expr: Expr
    span: Span | None = None


@record
class Assign:
    """`var := to`, or any value of `to` where it is a `Range`."""

    var: str
    to: Expr | Range
    span: Span | None = None


@record
class FlowLine:
    """`var' = rate`, or an inclusion where `rate` is a `Range`."""

    var: str
    rate: Expr | Range
    span: Span | None = None


@record
class Init:
    """Start states of `mode` (None: of every mode whose domain holds) that satisfy `where` after the assignments."""

    mode: str | None
    where: Expr
    assigns: tuple[Assign, ...]
    span: Span | None = None


@record
class Mode:
    """A discrete state: where a run may dwell, how it flows, which outputs it computes in its own way."""

    name: str
    domain: Expr
    flow: tuple[FlowLine, ...]
    lets: tuple[Output, ...]
    terminal: bool
    span: Span | None = None


@record
class Edge:
    """An arrow between modes; an index in the automaton's list identifies it, a name may be shared."""

    name: str
    source: str
    target: str
    urgent: bool
    guard: Expr
    resets: tuple[Assign, ...]
    span: Span | None = None


@record
class Priority:
    """Edges (in systems: interactions), highest first, where `when` holds."""

    over: tuple[str, ...]
    when: Expr
    span: Span | None = None


@record
class HybridAutomaton:
    """An automaton with every mode and edge written out."""

    name: str
    constants: tuple[Constant, ...]
    params: tuple[Param, ...]
    inputs: tuple[Input, ...]
    vars: tuple[Variable, ...]
    lets: tuple[Output, ...]
    init: tuple[Init, ...]
    modes: tuple[Mode, ...]
    edges: tuple[Edge, ...]
    priorities: tuple[Priority, ...]
    doc: str = ""
    span: Span | None = None
    is_system: bool = False  # put together of the parts of a system; then no part of the core
    open: frozenset[str] = frozenset()  # modes of a system whose edges are not listed
