"""Automata that run side by side: parts, interactions, priorities."""

from __future__ import annotations

from haverify.model.expression import Expr
from haverify.model.hybrid import Assign, Constant, Init, Input, Output, Param, Priority, Range, Variable
from haverify.text.record import record
from haverify.text.span import Span


@record
class Binding:
    """A constant, param or input of a part, bound to an expression (or a `Range`) in the scope of the system."""

    name: str
    to: Expr | Range
    span: Span | None = None


@record
class Part:
    """One automaton (or system) inside a system, under a name of its own."""

    name: str
    of: str
    bindings: tuple[Binding, ...]
    span: Span | None = None


@record
class Sync:
    """An interaction: `edges` fire together; each of `listeners` joins when enabled. Edges are `part.edge`."""

    name: str
    edges: tuple[str, ...]
    listeners: tuple[str, ...]
    guard: Expr
    resets: tuple[Assign, ...]
    is_broadcast: bool = False
    span: Span | None = None


@record
class System:
    """A network of automata; names of parts are `part.x`."""

    name: str
    constants: tuple[Constant, ...]
    params: tuple[Param, ...]
    inputs: tuple[Input, ...]
    vars: tuple[Variable, ...]
    lets: tuple[Output, ...]
    init: tuple[Init, ...]
    parts: tuple[Part, ...]
    syncs: tuple[Sync, ...]
    priorities: tuple[Priority, ...]
    flow: tuple[tuple[str, Expr], ...] = ()
    doc: str = ""
    span: Span | None = None
