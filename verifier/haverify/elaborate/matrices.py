"""`matrix I by J: u`: a file of numbers without a header, one row per value of I, one column per value of J."""

from __future__ import annotations

from contextlib import suppress

from haverify.elaborate.calls import declared_type
from haverify.elaborate.context import Lost
from haverify.elaborate.csv import cell_span
from haverify.elaborate.expressions import Env, family_enum
from haverify.elaborate.scope import Symbol, Table
from haverify.elaborate.tables import Reading, cell_number, check_width, enter_cell
from haverify.model.spec import EnumType
from haverify.model.unit import Unit
from haverify.syntax import tree as t
from haverify.text.span import Span


def read_matrix(reading: Reading) -> Table:
    """The constants of a matrix, `T_r_c`."""
    line = reading.lines("matrix")[0]
    rows, columns = (_enum(reading.env, name, line.span) for name in (line.of, line.by))
    unit = declared_type(reading.env, line.type)[1] if line.type else reading.ctx.one
    table = Table(reading.core, (rows, columns), {}, is_matrix=True)
    if len(reading.rows) != len(rows.values):
        told = f"{reading.file} has {len(reading.rows)} rows, {rows.name} has {len(rows.values)} values"
        reading.ctx.fail("HA210", told, reading.decl.path_span)
    for k, value in enumerate(rows.values):
        _enter_row(reading, table, k, value, columns, unit)
    return table


def _enum(env: Env, name: str, span: Span) -> EnumType:
    node: t.Expr = t.Name(name.split(".")[0], span)
    for part in name.split(".")[1:]:
        node = t.Member(node, part, span)
    return family_enum(env, node)


def _enter_row(reading: Reading, table: Table, k: int, key: str, columns: EnumType, unit: Unit | None) -> None:
    row = reading.rows[k]
    with suppress(Lost):
        check_width(reading, row, len(columns.values), columns.name)
    for j, value in enumerate(columns.values[: len(row.cells)]):
        try:
            symbol = _cell(reading, k, j, (key, value), unit)
        except Lost:
            continue
        table.rows[(key, value)] = {"": symbol}


def _cell(reading: Reading, k: int, j: int, key: tuple[str, str], unit: Unit | None) -> Symbol:
    row = reading.rows[k]
    number = cell_number(reading, row, j, str(j + 1))
    span = cell_span(reading.source, row.cells[j])
    return enter_cell(reading, f"{reading.core}_{key[0]}_{key[1]}", number, unit, None, row.line, str(j + 1), span)
