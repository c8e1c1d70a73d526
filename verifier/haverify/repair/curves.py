"""Outputs that table rows define, as curves over the clock values of a mode, under other numbers in the cells too."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from functools import cached_property

from haverify.lint._clock import Curve, cells_of, curve, polynomial
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
Own = tuple[tuple[str, Q], ...]  # other numbers for constants that a row reads

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
    """The rows and joints of all clock-driven automata of a spec."""

    facts: Facts
    _curves: dict[tuple[Key, Own], Curve] = field(default_factory=dict)
    _ranges: dict[tuple[Key, Own], tuple[Q, Q]] = field(default_factory=dict)

    @cached_property
    def rows(self) -> dict[Key, Row]:
        """The outputs that are polynomials of one clock in a mode that runs enter."""
        by_name = {c.constant: c for c in self.facts.spec.cells}
        found: dict[Key, Row] = {}
        for automaton in self.facts.spec.automata if by_name else ():
            if cells_of(self.facts, automaton) is not None:
                for row in _rows(self.facts, automaton, by_name):
                    written = curve(self.facts, automaton, row.mode, row.expr)
                    if written is not None:
                        found[row.key] = row
                        self._curves[row.key, ()] = written
        return found

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

    def own(self, key: Key, numbers: Numbers) -> Own:
        """Those of the numbers that a row reads."""
        return tuple((c.constant, numbers[c.constant]) for c in self.rows[key].cells if c.constant in numbers)

    def range(self, key: Key, numbers: Numbers = AS_WRITTEN) -> tuple[Q, Q]:
        """The least and greatest value of an output in its mode."""
        own = self.own(key, numbers)
        if (key, own) not in self._ranges:
            self._ranges[key, own] = self._curve(key, own).extremes()
        return self._ranges[key, own]

    def ends(self, key: Key, numbers: Numbers = AS_WRITTEN) -> tuple[Q, Q]:
        """The values at both ends of the mode's clock values, the smaller one first."""
        return self._curve(key, self.own(key, numbers)).ends

    def move(self, key: Key, numbers: Numbers = AS_WRITTEN) -> Q:
        """How far an output goes within its mode."""
        low, high = self.range(key, numbers)
        return high - low

    def step(self, joint: Joint, numbers: Numbers = AS_WRITTEN) -> Q:
        """How far an output goes at an edge."""
        return self._value(joint.after, joint.at[1], numbers) - self._value(joint.before, joint.at[0], numbers)

    def _value(self, key: Key, at: Q, numbers: Numbers) -> Q:
        found = self._curve(key, self.own(key, numbers))
        return found.poly.value({found.variable: at})

    def _curve(self, key: Key, own: Own) -> Curve:
        if (key, own) not in self._curves:
            row, written = self.rows[key], self._curves[key, ()]
            poly = polynomial(self.facts, row.automaton, row.mode, _with(row.expr, dict(own)))
            assert poly is not None, "a number for a cell adds no cases"
            self._curves[key, own] = Curve(poly, written.variable, written.over)
        return self._curves[key, own]

    def _instants(self, automaton: HybridAutomaton, index: int, before: Key, after: Key) -> tuple[Q, Q] | None:
        """The only values that the clock has when the edge is taken, None where there are several or none."""
        cells = cells_of(self.facts, automaton)
        clocks = {self._curve(k, ()).variable for k in (before, after)}
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
