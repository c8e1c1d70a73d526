"""Tables with axes: functions of one or two arguments, interpolated or held."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from haverify.elaborate.calls import declared_type
from haverify.elaborate.csv import CsvRow, read_csv, shown_path
from haverify.elaborate.expressions import Env
from haverify.elaborate.scope import Scope, Symbol
from haverify.elaborate.tables import Reading, _column_shape, _header, _position, _Shape, cell_number, check_width
from haverify.model.tables import DataTable
from haverify.model.unit import Unit
from haverify.syntax import tree as t
from haverify.text.source import Source


class Data:
    """What a table with axes is while names are resolved: its columns are functions."""

    def __init__(self, table: DataTable, scope: Scope) -> None:
        self.table = table
        self.scope = scope


def read_axes(env: Env, made: list[Any], decl: t.Table, symbol: Symbol, source: Source) -> None:
    """Make `symbol` the function table of the file."""
    reading = Reading(
        env, made, decl, source, symbol.name, (), read_csv(source), shown_path(env.ctx, source, decl.path)
    )
    header = _header(reading)
    axes = tuple((line.name, _unit(env, line)) for line in reading.lines("axis"))
    if len(axes) > 2:
        env.ctx.fail("HA105", "a table has at most two axes", decl.span)
    positions = [_position(reading, header, line.name, line.span) for line in reading.lines("axis")]
    shape = _column_shape(reading, header)
    rows = tuple(_row(reading, positions, shape, row) for row in reading.rows[1:])
    _check_increasing(reading, rows, len(axes))
    words = reading.lines("interpolate")
    how = words[0].name if words else "linear"
    if how not in ("linear", "hold"):
        env.ctx.fail("HA105", f"interpolate is linear or hold, not '{how}'", words[0].span)
    columns = tuple((c.name, c.unit, c.tolerance) for c in shape.columns)
    table = DataTable(symbol.name, how, axes, columns, rows, decl.span, reading.file)
    made.append(table)
    symbol.kind, symbol.payload = "data", Data(table, _columns(table, shape))


def _unit(env: Env, line: t.TableLine) -> Unit | None:
    return declared_type(env, line.type)[1] if line.type else env.ctx.one


def _row(reading: Reading, positions: list[int], shape: _Shape, row: CsvRow) -> tuple[Fraction, ...]:
    check_width(reading, row, len(reading.columns), "the header")
    axes = [cell_number(reading, row, p, str(p + 1)) for p in positions]
    return (
        *axes,
        *(cell_number(reading, row, c.position, c.name) for c in shape.columns),
        *_halves(reading, shape, row),
    )


def _halves(reading: Reading, shape: _Shape, row: CsvRow) -> list[Fraction]:
    """The numbers of tolerance columns, which follow the columns."""
    names = [c.tolerance for c in shape.columns if isinstance(c.tolerance, str)]
    return [cell_number(reading, row, reading.columns[n], n) for n in names]


def _check_increasing(reading: Reading, rows: tuple[tuple[Fraction, ...], ...], axes: int) -> None:
    if not rows:
        reading.ctx.fail("HA210", f"{reading.file} has no row of numbers", reading.decl.path_span)
    for k in range(1, len(rows)):
        if rows[k][:axes] <= rows[k - 1][:axes]:
            told = f"{reading.file}, line {reading.rows[k + 1].line}: the axis does not increase"
            reading.ctx.fail("HA203", told, reading.decl.path_span)


def _columns(table: DataTable, shape: _Shape) -> Scope:
    scope = Scope(f"table {table.name}")
    for column in shape.columns:
        symbol = Symbol("column", column.name, table.span, unit=column.unit, payload=table)
        scope.names[column.name] = symbol
    return scope
