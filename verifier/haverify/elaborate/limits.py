"""Bounds on what few lines of text may grow into."""

from __future__ import annotations

from haverify.elaborate.context import Context
from haverify.model.expression import Expr, operands
from haverify.syntax import tree as t
from haverify.text.span import Span

MOST_NODES = 20_000
DEEPEST = 150
MOST_CASES = 100
MOST_BINDINGS = 100_000
MOST_JUMPS = 1_000_000
MOST_DIGITS = 50
LONGEST_NAME = 100
"""Letters of a claim's name, which names files."""


def whole(ctx: Context, number: t.Number, what: str, low: int, high: int) -> int:
    """The integer that is written; HA105 for any other number, or one outside of `low..high`."""
    if number.value.denominator != 1 or not low <= number.value <= high:
        ctx.fail("HA105", f"{what} is an integer from {low} to {high}", number.span)
    return int(number.value)


def check_size(ctx: Context, e: Expr, span: Span) -> None:
    """HA105 where a function call, written out, has too many nodes or is nested too deeply."""
    size, depth = _measure(e, {})
    if size > MOST_NODES or depth > DEEPEST:
        what = f"more than {MOST_NODES} nodes" if size > MOST_NODES else f"more than {DEEPEST} levels"
        ctx.fail("HA105", f"this call, written out, has {what}", span)


def _measure(e: Expr, known: dict[int, tuple[int, int]]) -> tuple[int, int]:
    """Size and depth of an expression as a tree; shared parts are measured once."""
    found = known.get(id(e))
    if found is None:
        parts = [_measure(c, known) for c in operands(e)]
        found = 1 + sum(s for s, _ in parts), 1 + max((d for _, d in parts), default=0)
        known[id(e)] = found
    return found


def spend(ctx: Context, count: int, span: Span) -> None:
    """Count the cases of quantifiers and sums; HA105 when a claim, or all the rest, has too many of them."""
    ctx.bindings += count
    if ctx.bindings > MOST_BINDINGS:
        ctx.bindings = 0
        ctx.fail("HA105", f"quantifiers and sums, written out, have more than {MOST_BINDINGS} cases", span)


def check_cases(ctx: Context, count: int, span: Span) -> None:
    """HA105 where an index that the run decides has too many values."""
    if count > MOST_CASES:
        ctx.fail("HA105", f"an index that the run decides may have at most {MOST_CASES} values, not {count}", span)
