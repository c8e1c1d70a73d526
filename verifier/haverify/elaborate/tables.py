"""Tables: a constant for each number of a keyed file, a data table for a file with axes."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from fractions import Fraction
from functools import cached_property
from itertools import islice, zip_longest
from typing import Any, NoReturn

from haverify.diagnostics.diagnostic import Edit, Fix
from haverify.elaborate.calls import declared_type
from haverify.elaborate.context import Context, Lost
from haverify.elaborate.csv import COMMAS, CsvCell, CsvRow, cell_span, clipped, read_csv, shown_path
from haverify.elaborate.declare import Entries
from haverify.elaborate.expressions import Env, of_type
from haverify.elaborate.limits import MOST_DIGITS, whole
from haverify.elaborate.scope import Symbol, Table
from haverify.elaborate.spelling import nearest
from haverify.maths.exact import is_decimal, parse_decimal, rounding_half
from haverify.model.expression import Expr, number
from haverify.model.hybrid import Constant, Param, Range
from haverify.model.spec import Cell, EnumType
from haverify.model.unit import Unit, power
from haverify.syntax import tree as t
from haverify.text.record import field, holder, record
from haverify.text.source import Source
from haverify.text.span import Span

MOST_SHOWN = 10
"""Findings in the rows of one table, and names of columns in a message."""


@holder
class Reading:
    """A table being read: its lines by kind and the rows of its file."""

    env: Env
    made: list[Any]
    decl: t.Table
    source: Source
    core: str
    keys: tuple[EnumType, ...]
    rows: list[CsvRow]
    file: str
    columns: dict[str, int] = field(default_factory=dict)
    bad_rows: bool = False
    wrong_keys: int = 0

    @cached_property
    def values(self) -> list[frozenset[str]]:
        """The values of each key."""
        return [frozenset(enum.values) for enum in self.keys]

    @property
    def ctx(self) -> Context:
        return self.env.ctx

    def lines(self, kind: str) -> list[t.TableLine]:
        """The lines of the table of one kind."""
        return [line for line in self.decl.lines if line.kind == kind]


def enter_table(entries: Entries, decl: t.Table, path: str) -> None:
    """Enter a table under its name; a fault in the file makes the row, or the table, one without meaning."""
    env = entries.env
    symbol = Symbol("table", entries.name_of(decl.name), decl.span, state="pending")

    def make() -> None:
        made: list[Any] = []
        entries.models[symbol] = made
        _read(env, made, decl, symbol, path)

    symbol.make = make
    if env.ctx.define(env.scope.names, decl.name, symbol, "table"):
        entries.symbols.append(symbol)


def _read(env: Env, made: list[Any], decl: t.Table, symbol: Symbol, path: str) -> None:
    source = env.ctx.files.data.get((path, decl.path))
    if source is None:
        raise Lost
    _check_hash(env.ctx, decl, source)
    if any(line.kind == "axis" for line in decl.lines):
        from haverify.elaborate.axes import read_axes

        read_axes(env, made, decl, symbol, source)
        return
    keys = tuple(_enum(env, line.of, line.span) for line in decl.lines if line.kind == "key")
    reading = Reading(
        env, made, decl, source, symbol.name, keys, read_csv(source), shown_path(env.ctx, source, decl.path)
    )
    if reading.lines("matrix"):
        from haverify.elaborate.matrices import read_matrix

        symbol.payload = read_matrix(reading)
        return
    symbol.payload = _keyed(reading)


def _enum(env: Env, name: str, span: Span) -> EnumType:
    symbol = env.scope.lookup(name)
    if symbol is None or symbol.kind != "enum":
        env.ctx.unknown("enumeration", name, "", span, env.ctx.enums)
    enum: EnumType = env.ctx.use(symbol, span).payload
    env.ctx.used_enums.add(enum.name)
    return enum


def _check_hash(ctx: Context, decl: t.Table, source: Source) -> None:
    for line in decl.lines:
        if line.kind == "sha256" and line.text != source.sha256:
            fix = Fix("update the hash", (Edit(line.span, f'sha256 "{source.sha256}"'),), safe=True)
            ctx.report("HA215", f"{decl.path} does not match its sha256", line.span, fix=fix,
                       notes=(f"the file's hash is {source.sha256}",))  # fmt: skip


# ---- keyed tables ---------------------------------------------------------------


def _keyed(reading: Reading) -> Table:
    header = _header(reading)
    poly = reading.lines("poly")
    table = Table(reading.core, reading.keys, {}, {} if poly else None)
    table.columns = tuple(line.name for line in reading.lines("column"))
    if poly:
        _, table.argument = declared_type(reading.env, poly[0].type) if poly[0].type else ("", reading.ctx.one)
        table.result = _result_unit(reading, poly[0])
    shape = _poly_shape(reading, header, poly[0]) if poly else _column_shape(reading, header)
    before = len(reading.ctx.diagnostics)
    for row in reading.rows[1:]:
        _enter_row(reading, table, shape, row)
    _cap(reading, before)
    _check_missing(reading, table)
    return table


def _result_unit(reading: Reading, line: t.TableLine) -> Unit | None:
    return reading.ctx.unit(line.result, line.span)


def _header(reading: Reading) -> dict[str, int]:
    if not reading.rows:
        reading.ctx.fail(
            "HA210", f"{reading.file} is empty: a header and a row per key are needed", reading.decl.path_span
        )
    _check_likeness(reading, [cell.text for cell in reading.rows[0].cells])
    found: dict[str, int] = {}
    for k, cell in enumerate(reading.rows[0].cells):
        if cell.text in found:
            reading.ctx.fail("HA210", f"column '{cell.text}' occurs twice", cell_span(reading.source, cell))
        found[cell.text] = k
    reading.columns = found
    return found


def _check_likeness(reading: Reading, names: list[str]) -> None:
    """HA210 where the first line has none of the columns, so that no other finding shows lines of what is no table."""
    lines = [line for kind in ("key", "axis", "column", "poly") for line in reading.lines(kind)]
    if lines and not any(line.name in names for line in lines):
        _no_column(reading, names, lines[0].name, lines[0].span)


def _no_column(reading: Reading, names: Iterable[str], name: str, span: Span) -> NoReturn:
    shown = [clipped(n) for n in names]
    near = nearest(name, shown)
    hint = f"; did you mean '{near}'?" if near else f"; it has {', '.join(shown[:MOST_SHOWN])}"
    advice = COMMAS if len(shown) == 1 and any(";" in n for n in names) else None
    reading.ctx.fail("HA210", f"{reading.file} has no column '{name}'{hint}", span, help=advice)


def _cap(reading: Reading, before: int) -> None:
    """Of many findings in the rows of a table, the first and their number."""
    found = reading.ctx.diagnostics
    more = len(found) - before - MOST_SHOWN
    if more > 0:
        del found[before + MOST_SHOWN :]
        told = f"{reading.file}: {more} more findings in its rows are not shown"
        reading.ctx.report("HA210", told, reading.decl.path_span)


def _position(reading: Reading, header: dict[str, int], name: str, span: Span) -> int:
    if name in header:
        return header[name]
    _no_column(reading, header, name, span)


@record
class _Column:
    """A column to read: `exponent` in a polynomial, `half` of its numbers, `tolerance` a number or a column."""

    name: str
    position: int
    unit: Unit | None
    exponent: int | None = None
    digits: int | None = None
    tolerance: Fraction | str | None = None


@record
class _Shape:
    keys: tuple[int, ...]
    columns: tuple[_Column, ...]
    order: str = ""
    added: tuple[_Column, ...] = ()


def _key_positions(reading: Reading, header: dict[str, int]) -> tuple[int, ...]:
    return tuple(_position(reading, header, line.name, line.span) for line in reading.lines("key"))


def _poly_shape(reading: Reading, header: dict[str, int], line: t.TableLine) -> _Shape:
    first, last = (_position(reading, header, n, line.span) for n in (line.name, line.last))
    if last < first:
        reading.ctx.fail("HA210", f"column '{line.last}' is left of '{line.name}'", line.span)
    _check_numbered(reading, list(header)[first : last + 1], line)
    digits = [
        whole(reading.ctx, d.number, "a number of digits", 1, MOST_DIGITS)
        for d in reading.lines("digits") if d.number is not None
    ]  # fmt: skip
    names = list(header)
    columns = tuple(_Column(names[k], k, None, digits=digits[0] if digits else None) for k in range(first, last + 1))
    result = _result_unit(reading, line)
    added = tuple(_Column(a.name, _position(reading, header, a.name, a.span), result) for a in reading.lines("add"))
    return _Shape(_key_positions(reading, header), columns, line.order, added)


def _check_numbered(reading: Reading, names: list[str], line: t.TableLine) -> None:
    """HA210 where `p1..p5` has a gap or another column within; other first and last names take what is between."""
    a, b = (re.fullmatch(r"(.*?)(0|[1-9][0-9]{0,5})", n, re.ASCII) for n in (line.name, line.last))
    if a is None or b is None or a[1] != b[1]:
        return
    step = 1 if int(a[2]) <= int(b[2]) else -1
    wanted = [f"{a[1]}{k}" for k in islice(range(int(a[2]), int(b[2]) + step, step), len(names) + 1)]
    asked = f"`{line.name}..{line.last}`"
    missing = next((n for n in wanted if n not in names), None)
    if missing is not None:
        what = f"has no column '{missing}', which {asked} asks for"
        if missing in reading.columns:
            what = f"has column '{missing}' outside of {asked}"
        reading.ctx.fail("HA210", f"{reading.file} {what}", line.span)
    if names != wanted:
        odd = next(n for n, w in zip_longest(names, wanted) if n != w)
        reading.ctx.fail("HA210", f"{reading.file} has column '{clipped(odd)}' within {asked}", line.span)


def _column_shape(reading: Reading, header: dict[str, int]) -> _Shape:
    columns = []
    for line in reading.lines("column"):
        unit = declared_type(reading.env, line.type)[1] if line.type else reading.ctx.one
        tolerance = _tolerance(reading, header, line, unit)
        columns.append(_Column(line.name, _position(reading, header, line.name, line.span), unit, tolerance=tolerance))
    return _Shape(_key_positions(reading, header), tuple(columns))


def _tolerance(reading: Reading, header: dict[str, int], line: t.TableLine, unit: Unit | None) -> Fraction | str | None:
    if line.tolerance is None:
        return None
    if isinstance(line.tolerance, t.Name) and line.tolerance.id in header:
        return line.tolerance.id
    e = of_type(reading.env, line.tolerance, "real", unit, f"the tolerance of {line.name}")
    value = e.args[0] if e.op == "num" else None
    if not isinstance(value, Fraction):
        reading.ctx.fail("HA105", "a tolerance is a number or a column", line.tolerance.span)
    return value


# ---- rows -----------------------------------------------------------------------


def _enter_row(reading: Reading, table: Table, shape: _Shape, row: CsvRow) -> None:
    key = _key(reading, shape, row)
    if key is None:
        reading.bad_rows = True
        return
    if key in table.rows:
        spans = _row_span(reading, row)
        reading.ctx.report("HA210", f"{reading.file}: row {', '.join(key)} occurs twice", spans)
        table.rows[key] = {}
        return
    try:
        table.rows[key] = _cells(reading, table, shape, row, key)
    except Lost:
        table.rows[key] = _LOST_ROW


_LOST_ROW: dict[str, Symbol] = {}


def _row_span(reading: Reading, row: CsvRow) -> Span:
    return Span(reading.source.path, row.cells[0].start, row.cells[-1].end)


def _key(reading: Reading, shape: _Shape, row: CsvRow) -> tuple[str, ...] | None:
    found = []
    for position, enum, known in zip(shape.keys, reading.keys, reading.values, strict=True):
        if position >= len(row.cells):
            reading.ctx.report("HA210", f"{reading.file}: this row has no {enum.name}", _row_span(reading, row))
            return None
        cell = row.cells[position]
        if cell.text not in known:
            _wrong_key(reading, enum, cell)
            return None
        found.append(cell.text)
    return tuple(found)


def _wrong_key(reading: Reading, enum: EnumType, cell: CsvCell) -> None:
    reading.wrong_keys += 1
    near = nearest(cell.text, enum.values) if reading.wrong_keys <= MOST_SHOWN else None
    span = cell_span(reading.source, cell)
    hint = f"; did you mean {near}?" if near else ""
    fix = Fix(f"write {near}", (Edit(span, near),)) if near else None
    reading.ctx.report("HA211", f"'{cell.text}' is not a {enum.name}{hint}", span, fix=fix)


def _cells(reading: Reading, table: Table, shape: _Shape, row: CsvRow, key: tuple[str, ...]) -> dict[str, Symbol]:
    check_width(reading, row, len(reading.columns), "the header")
    columns = _poly_columns(reading, shape, row, table) if table.poly is not None else shape.columns
    if table.poly is not None:
        powers = tuple((c.name, c.exponent or 0) for c in columns)
        table.poly[key] = powers + tuple((c.name, 0) for c in shape.added)
        columns = (*columns, *shape.added)
    return {c.name: _cell_symbol(reading, row, c, key) for c in columns}


def check_width(reading: Reading, row: CsvRow, width: int, what: str) -> None:
    """HA210 for a row that has more or fewer cells than `what`, which has `width`."""
    count = len(row.cells)
    if count == width:
        return
    place = cell_span(reading.source, row.cells[width]) if count > width else _place(reading, row, count)
    advice = "an empty cell at the end needs its comma" if count < width else None
    told = f"{reading.file}: this row has {count} cell{'s' if count != 1 else ''}, {what} has {width}"
    reading.ctx.fail("HA210", told, place, help=advice)


def _poly_columns(reading: Reading, shape: _Shape, row: CsvRow, table: Table) -> tuple[_Column, ...]:
    """The filled coefficient columns with their exponents; trailing empty cells lower the degree."""
    filled = 0
    for k, column in enumerate(shape.columns):
        if not _text(row, column.position):
            continue
        if filled < k:
            gap = shape.columns[filled]
            place = _place(reading, row, gap.position)
            reading.ctx.fail(
                "HA210", f"{reading.file}: cell '{gap.name}' is empty before the filled '{column.name}'", place
            )
        filled += 1
    if filled == 0:
        reading.ctx.fail("HA210", f"{reading.file}: this row has no coefficient", _row_span(reading, row))
    return tuple(_power_column(c, k, filled, shape.order, table) for k, c in enumerate(shape.columns[:filled]))


def _power_column(c: _Column, k: int, filled: int, order: str, table: Table) -> _Column:
    exponent = filled - 1 - k if order == "descending" else k
    unit = None
    if table.result is not None and table.argument is not None:
        unit = table.result / power(table.argument, exponent)
    return _Column(c.name, c.position, unit, exponent, c.digits)


def _text(row: CsvRow, position: int) -> str:
    return row.cells[position].text if position < len(row.cells) else ""


def _place(reading: Reading, row: CsvRow, position: int) -> Span:
    if position < len(row.cells):
        return cell_span(reading.source, row.cells[position])
    end = row.cells[-1].end
    return Span(reading.source.path, end, end)


def _cell_symbol(reading: Reading, row: CsvRow, column: _Column, key: tuple[str, ...]) -> Symbol:
    value = cell_number(reading, row, column.position, column.name)
    span = _place(reading, row, column.position)
    name = "_".join((reading.core, *key, column.name))
    half = rounding_half(value, column.digits) if column.digits is not None else None
    symbol = enter_cell(reading, name, value, column.unit, half, row.line, column.name, span)
    if column.tolerance is None:
        return symbol
    return _measured(reading, row, column, symbol, value, key)


def cell_number(reading: Reading, row: CsvRow, position: int, column: str) -> Fraction:
    """The number in a cell; HA210 where there is none."""
    text = _text(row, position)
    value = parse_decimal(text)
    if value is not None:
        return value
    place = _place(reading, row, position)
    if not text:
        reading.ctx.fail("HA210", f"{reading.file}: cell '{column}' of line {row.line} is missing", place)
    wrong = "too large or too small to be meant" if is_decimal(text) else "not a number"
    told = f"{reading.file}: '{clipped(text)}' in column '{column}' is {wrong}"
    return reading.ctx.fail("HA210", told, place, help=COMMAS if ";" in text else None)


def enter_cell(
    reading: Reading, name: str, value: Fraction, unit: Unit | None, half: Fraction | None, line: int, column: str,
    span: Span,
) -> Symbol:  # fmt: skip
    """The constant that stands for a cell."""
    name = reading.ctx.fresh(name)
    symbol = Symbol("const", name, span, unit=unit, used=True)
    e = number(value, unit, span)
    reading.ctx.constant_values[name] = e
    reading.ctx.cells.append(Cell(reading.file, line, column, value, name, span))
    reading.made.append(Constant(name, "real", unit, e, half, span))
    return symbol


def _measured(
    reading: Reading, row: CsvRow, column: _Column, symbol: Symbol, value: Fraction, key: tuple[str, ...]
) -> Symbol:
    """The param of a cell with a tolerance: any value within it, one per run."""
    half = column.tolerance
    if isinstance(half, str):
        half = cell_number(reading, row, reading.columns[half], half)
    assert isinstance(half, Fraction)
    name = reading.ctx.fresh(symbol.name + "_true")
    span, unit = symbol.span, symbol.unit
    found = Symbol("param", name, span, unit=unit, used=True)
    bounds = Range(number(value - half, unit, span), number(value + half, unit, span))
    default = Expr("const", (symbol.name,), unit, span)
    reading.made.append(Param(name, unit, bounds, default, span))
    return found


def _check_missing(reading: Reading, table: Table) -> None:
    missing = [k for k in _products(reading.keys) if k not in table.rows]
    if missing and not reading.bad_rows:
        names = "; ".join(", ".join(k) for k in missing[:8]) + ("; ..." if len(missing) > 8 else "")
        keys = " and ".join(e.name for e in reading.keys)
        reading.ctx.report("HA210", f"{reading.file}: no row for {keys} {names}", reading.decl.path_span)
    for key in missing:
        table.rows[key] = _LOST_ROW


def _products(keys: Sequence[EnumType]) -> list[tuple[str, ...]]:
    found: list[tuple[str, ...]] = [()]
    for enum in keys:
        found = [(*f, v) for f in found for v in enum.values]
    return found
