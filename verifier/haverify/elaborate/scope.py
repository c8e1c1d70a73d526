"""Names and what they stand for, in nested scopes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from haverify.model.expression import Expr
from haverify.model.hybrid import Range
from haverify.model.spec import EnumType
from haverify.model.unit import Unit
from haverify.syntax.tree import Item
from haverify.text.record import field, holder
from haverify.text.span import Span


class Typed(NamedTuple):
    """An expression and its type: `real`, `bool`, `cell C` or the name of an enumeration."""

    expr: Expr
    type: str


@holder
class Symbol:
    """What a name stands for.

    `kind` says what `payload` holds; `name` is the name in the core. A symbol with `make` is elaborated when it is
    first used; `state` is `ready`, `pending`, `busy` or `lost` (its declaration has an error).
    """

    kind: str
    name: str
    span: Span | None = None
    type: str = "real"
    unit: Unit | None = None
    payload: Any = None
    make: Callable[[], None] | None = None
    state: str = "ready"
    used: bool = False


@holder
class Members:
    """The members of a family by value of `enum`."""

    enum: EnumType
    by_value: dict[str, Symbol] = field(default_factory=dict)


@holder
class Table:
    """A keyed table: constants by key values and column; `poly` are (column, exponent) per row."""

    name: str
    keys: tuple[EnumType, ...]
    rows: dict[tuple[str, ...], dict[str, Symbol]]
    poly: dict[tuple[str, ...], tuple[tuple[str, int], ...]] | None = None
    argument: Unit | None = None
    result: Unit | None = None
    is_matrix: bool = False
    columns: tuple[str, ...] = ()


class Row(NamedTuple):
    """A keyed table with some of its keys given."""

    table: Table
    keys: tuple[str, ...]


class Cases(NamedTuple):
    """Denotations by value of an enumeration, where the run decides which one is meant."""

    selector: Typed
    enum: EnumType
    options: dict[str, Any]


class SetValue(NamedTuple):
    """An interval, usable after `in`."""

    range: Range
    unit: Unit | None


@holder
class Scope:
    """Names of one block; what is not here is looked up in `parent`. Modes and edges have namespaces of their own."""

    label: str
    parent: Scope | None = None
    names: dict[str, Symbol] = field(default_factory=dict)
    modes: dict[str, Symbol] = field(default_factory=dict)
    edges: dict[str, Symbol] = field(default_factory=dict)
    is_machine: bool = False
    is_local: bool = False
    items: Sequence[Item] = ()

    def lookup(self, name: str) -> Symbol | None:
        """The innermost symbol of that name."""
        scope: Scope | None = self
        while scope is not None:
            found = scope.names.get(name)
            if found is not None:
                return found
            scope = scope.parent
        return None

    def local(self, name: str) -> Symbol | None:
        """The symbol of a family variable, formal or bound variable of that name."""
        scope: Scope | None = self
        while scope is not None and scope.is_local:
            if name in scope.names:
                return scope.names[name]
            scope = scope.parent
        return None

    def machine(self) -> Scope | None:
        """The innermost automaton or system."""
        scope: Scope | None = self
        while scope is not None and not scope.is_machine:
            scope = scope.parent
        return scope

    def visible(self) -> Iterator[str]:
        """All names, inner ones first."""
        scope: Scope | None = self
        while scope is not None:
            yield from scope.names
            scope = scope.parent

    def bind(self, values: Mapping[str, Typed]) -> Scope:
        """A scope inside this one in which names stand for given values."""
        names = {n: Symbol("value", n, type=v.type, payload=v) for n, v in values.items()}
        return Scope(self.label, self, names, is_local=True)
