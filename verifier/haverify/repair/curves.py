"""Outputs that table rows define, as curves over the clock values of a mode, under other numbers in the cells too."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from functools import cached_property

from haverify.lint._clock import Curve, cells_of, curve
from haverify.lint._facts import Facts
from haverify.model.expression import Expr, nodes, number, rebuild
from haverify.model.hybrid import Edge, HybridAutomaton, Mode, Output
from haverify.model.spec import Cell
from haverify.model.unit import Unit
from haverify.text.record import field, holder, record

Q = Fraction
Numbers = Mapping[str, Q]
Key = tuple[str, str, str]  # automaton, mode, output
Line = tuple[str, int]  # file, row

AS_WRITTEN: Numbers = {}


@record
class Row:
    """An output in a mode, as an expression without other outputs, and the table cells it reads."""

    automaton: HybridAutomaton
    mode: Mode
    output: str
    unit: Unit | None
    expr: Expr
    cells: tuple[Cell, ...]

    @property
    def key(self) -> Key:
        return (self.automaton.name, self.mode.name, self.output)

    @property
    def lines(self) -> frozenset[Line]:
        """The lines of tables it reads."""
        return frozenset((c.span.path, c.row) for c in self.cells)


@record
class Joint:
    """An edge at which an output goes from one curve to another, at known values of the clock."""

    edge: Edge
    before: Key
    after: Key
    at: tuple[Q, Q]  # the clock before and after

    @property
    def where(self) -> str:
        """The edge as claims' parts name it."""
        return f"{self.edge.source} -> {self.edge.target}"

    @property
    def has_reset(self) -> bool:
        return self.at[0] != self.at[1]


@holder
class Curves:
    """The rows and joints of all clock-driven automata of a spec; `memory` keeps what was computed."""

    facts: Facts
    memory: dict[object, tuple[Q, Q] | None] = field(default_factory=dict)

    @cached_property
    def rows(self) -> dict[Key, Row]:
        """The outputs that are polynomials of one clock in a mode that runs enter."""
        by_name = {c.constant: c for c in self.facts.spec.cells}
        found: dict[Key, Row] = {}
        for automaton in self.facts.spec.automata if by_name else ():
            if cells_of(self.facts, automaton) is not None:
                for row in _rows(self.facts, automaton, by_name):
                    found[row.key] = row
        return {k: r for k, r in found.items() if curve(self.facts, r.automaton, r.mode, r.expr) is not None}

    @cached_property
    def joints(self) -> list[Joint]:
        """The edges between rows, those of which at least one reads a table."""
        found = []
        for automaton in self.facts.spec.automata:
            outputs = dict.fromkeys(k[2] for k in self.rows if k[0] == automaton.name)
            for index, edge in enumerate(automaton.edges if outputs else ()):
                for output in outputs:
                    before, after = ((automaton.name, m, output) for m in (edge.source, edge.target))
                    if before in self.rows and after in self.rows:
                        at = self._instants(automaton, index, before, after)
                        found += [Joint(edge, before, after, at)] if at is not None else []
        return [j for j in found if self.rows[j.before].cells or self.rows[j.after].cells]

    @cached_property
    def readers(self) -> dict[str, list[Key]]:
        """The rows that read a cell, by its constant."""
        found: dict[str, list[Key]] = {}
        for key, row in self.rows.items():
            for c in row.cells:
                found.setdefault(c.constant, []).append(key)
        return found

    @cached_property
    def joints_of(self) -> dict[Key, list[Joint]]:
        """The joints at a row."""
        found: dict[Key, list[Joint]] = {}
        for j in self.joints:
            for key in dict.fromkeys((j.before, j.after)):
                found.setdefault(key, []).append(j)
        return found

    def own(self, key: Key, numbers: Numbers) -> tuple[tuple[str, Q], ...]:
        """Those of the numbers that a row reads."""
        return tuple((c.constant, numbers[c.constant]) for c in self.rows[key].cells if c.constant in numbers)

    def range(self, key: Key, numbers: Numbers = AS_WRITTEN) -> tuple[Q, Q]:
        """The least and greatest value of an output in its mode."""
        own = self.own(key, numbers)
        known = self.memory.get((key, own))
        if known is None:
            known = self.memory[key, own] = self._curve(key, own).extremes()
        return known

    def move(self, key: Key, numbers: Numbers = AS_WRITTEN) -> Q:
        """How far an output goes within its mode."""
        low, high = self.range(key, numbers)
        return high - low

    def step(self, joint: Joint, numbers: Numbers = AS_WRITTEN) -> Q:
        """How far an output goes at an edge."""
        return self._value(joint.after, joint.at[1], numbers) - self._value(joint.before, joint.at[0], numbers)

    def _value(self, key: Key, at: Q, numbers: Numbers) -> Q:
        own = self.own(key, numbers)
        known = self.memory.get((key, own, at))
        if known is None:
            found = self._curve(key, own)
            value = found.poly.value({found.variable: at})
            known = self.memory[key, own, at] = (value, value)
        return known[0]

    def _curve(self, key: Key, own: tuple[tuple[str, Q], ...]) -> Curve:
        row = self.rows[key]
        changed = _with(row.expr, dict(own)) if own else row.expr
        found = curve(self.facts, row.automaton, row.mode, changed)
        if found is None:  # constant under these numbers: no variable is left
            return _flat(self.facts, row, changed)
        return found

    def _instants(self, automaton: HybridAutomaton, index: int, before: Key, after: Key) -> tuple[Q, Q] | None:
        """The only values that the clock has when the edge is taken, None where there are several or none."""
        cells = cells_of(self.facts, automaton)
        clocks = {self._clock(before), self._clock(after)}
        if cells is None or len(clocks) != 1:
            return None
        (clock,) = clocks
        source = cells.model.index[automaton.edges[index].source]
        exits = [x for c in cells.of_mode(source) if (x := cells.exit(c, index)) is not None]
        ends = {(b.low, b.high, a.low, a.high) for x in exits for b, a in [(x.before[clock], x.after[clock])]}
        if len(ends) != 1:
            return None
        low, high, then_low, then_high = ends.pop()
        return (
            (low, then_low)
            if low is not None and low == high and then_low is not None and then_low == then_high
            else None
        )

    def _clock(self, key: Key) -> str:
        row = self.rows[key]
        found = curve(self.facts, row.automaton, row.mode, row.expr)
        return found.variable if found is not None else ""


def _rows(facts: Facts, automaton: HybridAutomaton, by_name: Mapping[str, Cell]) -> Iterator[Row]:
    for mode in automaton.modes:
        outputs: dict[str, Output] = {o.name: o for o in (*automaton.lets, *mode.lets) if o.type == "real"}
        for output in outputs.values():
            expr = _closed(outputs, output.expr)
            names = dict.fromkeys(n.name for n in nodes(expr) if n.op == "const" and n.name in by_name)
            yield Row(automaton, mode, output.name, output.unit, expr, tuple(by_name[n] for n in names))


def _closed(outputs: Mapping[str, Output], e: Expr) -> Expr:
    """An expression with other outputs written out; these are not cyclic."""
    if e.op == "let" and e.name in outputs:
        return _closed(outputs, outputs[e.name].expr)
    return rebuild(e, lambda child: _closed(outputs, child))


def _with(e: Expr, numbers: Numbers) -> Expr:
    if e.op == "const" and e.name in numbers:
        return number(numbers[e.name], e.unit, e.span)
    return rebuild(e, lambda child: _with(child, numbers))


def _flat(facts: Facts, row: Row, e: Expr) -> Curve:
    """A curve without a variable in it, over the clock values of the row as it is written."""
    from haverify.lint._clock import polynomial

    written = curve(facts, row.automaton, row.mode, row.expr)
    poly = polynomial(facts, row.automaton, row.mode, e)
    assert written is not None and poly is not None, "a row has a curve, and a number for a cell adds no cases"
    return Curve(poly, written.variable, written.over)
