"""Data behind functions: interpolated tables and networks. (Polynomial and keyed tables become constants.)"""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

from haverify.text.record import record
from haverify.text.span import Span

if TYPE_CHECKING:
    from haverify.model.unit import Unit


@record
class DataTable:
    """A function of one or two axes, `interpolate` linear or hold; `rows` hold the axes' values, then the columns'."""

    name: str
    interpolate: str
    axes: tuple[tuple[str, Unit | None], ...]
    columns: tuple[tuple[str, Unit | None, Fraction | str | None], ...]  # name, unit, half-width (a number or a column)
    rows: tuple[tuple[Fraction, ...], ...]  # behind the columns' numbers those of columns that are half-widths
    span: Span | None = None
    file: str = ""  # relative to the spec; no part of the core


@record
class Network:
    """A neural network in a file; inputs and outputs with their units, in order."""

    name: str
    file: str
    sha256: str | None
    inputs: tuple[tuple[str, Unit | None], ...]
    outputs: tuple[tuple[str, Unit | None], ...]
    span: Span | None = None
