"""A whole spec, elaborated: what `core.json` holds, with the spans and texts that people need beside it."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

from haverify.text.record import field, record
from haverify.text.span import Span

if TYPE_CHECKING:
    from haverify.model.cellular import CellularAutomaton, Relation
    from haverify.model.claim import Claim
    from haverify.model.expression import Expr
    from haverify.model.fuzzy import FuzzyController
    from haverify.model.hybrid import Constant, HybridAutomaton, Input, Param
    from haverify.model.system import System
    from haverify.model.tables import DataTable, Network


@record
class EnumType:
    """An enumeration; `codes` as written (`0b011`, `3`) or None; `low`, `high` for an integer one."""

    name: str
    values: tuple[str, ...]
    codes: tuple[str | None, ...]
    low: Fraction | None = None
    high: Fraction | None = None
    span: Span | None = None


@record
class UnitDef:
    """A unit made by the file: `value` is (rational, pi exponent, base dimensions), None for a new base unit."""

    name: str
    value: tuple[Fraction, int, tuple[tuple[str, Fraction], ...]] | None


@record
class Cell:
    """A cell of a CSV table: `number` is the value of the constant `constant`; rows are the lines of the file."""

    file: str
    row: int
    column: str
    number: Fraction
    constant: str
    span: Span


@record
class Allowed:
    """An `@allow(code, reason = ...)`; it covers findings whose primary span lies in `span`."""

    code: str
    reason: str | None
    span: Span
    at: Span  # of the attribute itself


@record
class Spec:
    """Everything a spec says. Order is that of the text (imports first)."""

    name: str
    version: str
    unitless: bool
    units: tuple[UnitDef, ...]
    enums: tuple[EnumType, ...]
    constants: tuple[Constant, ...]
    params: tuple[Param, ...]
    inputs: tuple[Input, ...]
    tables: tuple[DataTable, ...]
    networks: tuple[Network, ...]
    assumptions: tuple[Expr, ...]
    automata: tuple[HybridAutomaton, ...]
    systems: tuple[System, ...]
    cellular: tuple[CellularAutomaton, ...]
    relations: tuple[Relation, ...]
    fuzzy: tuple[FuzzyController, ...]
    claims: tuple[Claim, ...]
    cells: tuple[Cell, ...]
    allowed: tuple[Allowed, ...] = field(default=())
    lost: tuple[tuple[str, Span, str], ...] = field(default=())  # claims without meaning: name, place, reason
