"""Bounds that are table cells and stand the wrong way round."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from haverify.diagnostics.diagnostic import Edit
from haverify.lint._facts import Facts
from haverify.lint._formulas import formulas, ranges
from haverify.lint.empty_interval import empty_bounds
from haverify.model.expression import Expr
from haverify.model.spec import Cell
from haverify.repair.cells import name_of, slips_of, text_of
from haverify.repair.change import Change
from haverify.solvers.literals import number_of
from haverify.text.record import record
from haverify.text.source import Source


@record
class Backwards:
    """Two cells of which the first is a lower bound and larger than the second, the upper one."""

    low: Cell
    high: Cell

    def changes(self, sources: Mapping[str, Source]) -> Iterator[Change]:
        """The two exchanged, then slips in either that put them in order."""
        texts = text_of(self.low.span, sources), text_of(self.high.span, sources)
        yield Change(
            "bounds",
            (Edit(self.low.span, texts[1]), Edit(self.high.span, texts[0])),
            f"{self.low.column} and {name_of(self.high, sources)}",
            ((self.low.constant, self.high.number), (self.high.constant, self.low.number)),
        )
        for change in slips_of([self.low], sources):
            if change.numbers[0][1] <= self.high.number:
                yield change
        for change in slips_of([self.high], sources):
            if change.numbers[0][1] >= self.low.number:
                yield change


def backwards(facts: Facts) -> list[Backwards]:
    """All pairs of cells that bound something from below and from above and leave nothing between, once each."""
    cells = {c.constant: c for c in facts.spec.cells}
    found: dict[tuple[object, object], Backwards] = {}
    for low, high in _pairs(facts):
        a, b = (cells.get(e.name) if e.op == "const" else None for e in (low, high))
        if a is not None and b is not None and a.number > b.number:
            found.setdefault((a.span, b.span), Backwards(a, b))
    return list(found.values())


def _pairs(facts: Facts) -> Iterator[tuple[Expr, Expr]]:
    for interval, frame, _ in ranges(facts):
        low, high = number_of(interval.low, frame), number_of(interval.high, frame)
        if low is not None and high is not None and low > high:
            yield interval.low, interval.high
    for formula in formulas(facts):
        yield from ((b.low, b.high) for b in empty_bounds(formula))
