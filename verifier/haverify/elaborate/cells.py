"""Cells of cellular automata: two enumerations whose codes are put side by side."""

from __future__ import annotations

from haverify.elaborate.context import Context
from haverify.maths.exact import parse_decimal
from haverify.model.spec import EnumType
from haverify.syntax import tree as t
from haverify.text.record import record
from haverify.text.span import Span


@record
class CellSet:
    """The cells `first ++ second`, each named by the bits of both codes."""

    name: str
    first: EnumType
    second: EnumType
    words: tuple[str, str]  # what the enumerations are called where the cells are declared

    @property
    def parts(self) -> dict[str, str]:
        """The enumeration of each part, by the name of the part: what the enumeration is called, in small letters."""
        return dict(zip((w.lower() for w in self.words), (self.first.name, self.second.name), strict=True))


def codes(enum: EnumType) -> dict[str, str]:
    """The bits of each value: as written, numbers in binary, positions where nothing is written."""
    given = dict(zip(enum.values, enum.codes, strict=True))
    numbers = {v: _number(c, k) for k, (v, c) in enumerate(given.items())}
    written = [len(c) - 2 for c in given.values() if c is not None and c.startswith("0b")]
    width = max(written or [max(numbers.values()).bit_length() or 1])
    return {v: format(n, "b").rjust(width, "0") for v, n in numbers.items()}


def _number(code: str | None, position: int) -> int:
    if code is None:
        return position
    if code.startswith("0b"):
        return int(code[2:], 2)
    value = parse_decimal(code) if "." not in code else None
    return int(value) if value is not None and value.denominator == 1 else position


def bits_of(ctx: Context, cells: CellSet, node: t.Expr) -> str:
    """The bits of a cell written as `0b0111` or as a pair; HA504 where it is none of the set."""
    first, second = codes(cells.first), codes(cells.second)
    if isinstance(node, t.Bits):
        return _checked(ctx, cells, node.digits.removeprefix("0b"), first, second, node.span)
    if isinstance(node, t.Pair):
        return _part(ctx, cells.first, first, node.left) + _part(ctx, cells.second, second, node.right)
    return ctx.fail("HA105", f"a cell of {cells.name} is written as bits or as a pair", node.span)


def _checked(ctx: Context, cells: CellSet, bits: str, first: dict[str, str], second: dict[str, str], span: Span) -> str:
    k, width = len(next(iter(first.values()))), len(next(iter(first.values()))) + len(next(iter(second.values())))
    if len(bits) != width:
        ctx.fail("HA504", f"0b{bits} has {len(bits)} bits, {cells.name} has {width}", span)
    if bits[:k] not in first.values() or bits[k:] not in second.values():
        ctx.fail("HA504", f"0b{bits} is no {cells.name}", span)
    return bits


def _part(ctx: Context, enum: EnumType, known: dict[str, str], node: t.Expr) -> str:
    word = node.id if isinstance(node, t.Name) else ""
    if word not in known:
        ctx.unknown("value", word, enum.name, node.span, known)
    ctx.used_values.add((enum.name, word))
    return known[word]
