"""Fuzzy controllers: piecewise linear terms, min/max inference."""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

from haverify.model.expression import Expr
from haverify.text.record import record
from haverify.text.span import Span

if TYPE_CHECKING:
    from haverify.model.unit import Unit


@record
class Term:
    """A membership function: `shape` (tri, trap, ramp, ...) with its corners in the unit of the input."""

    name: str
    shape: str
    corners: tuple[Fraction, ...]
    span: Span | None = None


@record
class FuzzyInput:
    """An input over `[low, high]`; `source` is (system, output) for a chained one, whose terms it inherits."""

    name: str
    unit: Unit | None
    low: Fraction | None
    high: Fraction | None
    terms: tuple[Term, ...]
    source: tuple[str, str] | None = None
    span: Span | None = None


@record
class FuzzyRule:
    """`premise => output is term`; the premise is built of `and`, `or`, `not` and `["is", input, term]`."""

    name: str
    premise: Expr
    output: str
    term: str
    span: Span | None = None


@record
class FuzzyController:
    """Inputs, outputs with their terms, the norms for `and` and `or`, and rules."""

    name: str
    inputs: tuple[FuzzyInput, ...]
    outputs: tuple[tuple[str, tuple[str, ...]], ...]
    logic: tuple[str, str]
    rules: tuple[FuzzyRule, ...]
    doc: str = ""
    span: Span | None = None
