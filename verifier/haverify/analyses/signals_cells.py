"""All runs at once: ways through the cells, and the truth of every atom along each cell, with proofs."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import Any

from haverify.analyses.always import tree_for
from haverify.analyses.bounds import Box, Interval, point
from haverify.analyses.cell import Cell, Exit
from haverify.analyses.clock_model import reads_time
from haverify.analyses.clocked import Cells, start_box
from haverify.analyses.opening import certainly
from haverify.analyses.placement import Placement, Tree, place, written
from haverify.analyses.poly_range import Work
from haverify.analyses.questions import Question, Setting, narrowed
from haverify.analyses.signals_formula import Formula as Stl
from haverify.analyses.signals_pieces import Item, divided, exact, merged, spans_of
from haverify.analyses.signals_value import ZERO, Cut, Dwell, Signal, Spans, Timeline, at_start, common, joined
from haverify.analyses.stuck import never_stuck, states
from haverify.model.expression import Expr, nodes
from haverify.obligations.denial import denial
from haverify.obligations.formula import Formula, conjunction, variables
from haverify.obligations.residual import Situation, residual
from haverify.obligations.spread import spread
from haverify.obligations.translate import Scope
from haverify.text.record import field, holder, record

Q = Fraction
Json = Any
MOST_PATHS = 200
AT_ONCE = 40  # jumps at one instant
MOST_DWELLS = 3_000  # of all ways together
EVENTS = frozenset({"jump", "jumped", "pre"})


@record
class Visit:
    """A cell on a way, the cell and edge from which it is entered, and how long the stay lasts."""

    cell: int
    entered: tuple[int, int] | None
    low: Q
    high: Q


@record
class Way:
    """The cells that some runs go through; `lost` where nothing is known of what follows."""

    visits: tuple[Visit, ...]
    lost: bool


class TooManyError(Exception):
    """There are more ways than are followed; the message says how many."""


@holder
class Reading:
    """The atoms of a formula on the cells of all runs up to its horizon."""

    setting: Setting
    cells: Cells
    stl: Stl
    atoms: tuple[tuple[Expr, Expr], ...]  # each as it reads where more makes the whole truer, and where less does
    work: Work
    known: dict[object, list[Item]] = field(default_factory=dict)
    landings: dict[tuple[int, int, Expr], tuple[bool, Tree] | None] = field(default_factory=dict)

    @property
    def rate(self) -> tuple[Q, Q]:
        """The bounds of the clocks' rate."""
        return self.cells.model.rho_range

    def items(self, i: int, atom: Expr) -> list[Item]:
        """The truth of an atom along the stay in a cell, no jump being just made."""
        cell = self.cells.cells[i]
        key = (i, atom)
        if key not in self.known:
            alike = (atom, cell.mode, *((x.low, x.high) for x in cell.entry.values()), self.length(i))
            shared = key if self._timed(atom) else alike
            if shared not in self.known:
                self.known[shared] = self._items(cell, self.length(i), atom)
            self.known[key] = self.known[shared]
        return self.known[key]

    def _timed(self, atom: Expr) -> bool:
        read = (atom, *self.setting.claim.assume, *self.setting.model.spec.assumptions)
        return any(reads_time(e, self.setting.model.timed_lets) for e in read)

    def length(self, i: int) -> Q:
        """How long a stay in a cell is looked at, in scaled time."""
        cell = self.cells.cells[i]
        assert cell.sigma is not None and cell.sigma.low is not None, "time is followed"
        left = max(Q(0), self.reach - cell.sigma.low)
        return left if cell.dwell is None else min(cell.dwell, left)

    @property
    def reach(self) -> Q:
        """The scaled horizon."""
        return self.stl.horizon * self.rate[1]

    def _items(self, cell: Cell, last: Q, atom: Expr) -> list[Item]:
        model = self.setting.model
        scope = model.timed_scope(cell.mode)
        at = Situation(model.automaton.modes[cell.mode].name)
        yes, no = _sides(scope, residual(atom, at))
        more = self.setting.assumptions(scope)
        placement = narrowed(place(model, cell, None, self.setting.extra), more)
        f, g = placement.place(yes), placement.place(no)
        if variables(f) | variables(g) <= {placement.axis, "pi"}:
            return exact(f, g, placement, last, self.setting.ranges)
        premise = conjunction([model.mode(cell.mode).domain, more])

        def attempt(low: Q, high: Q) -> tuple[bool, Tree] | None:
            return self._decide(yes, no, premise, _share(placement, low, high))

        return merged(divided(Q(0), last, attempt))

    def _decide(self, yes: Formula, no: Formula, premise: Formula, p: Placement) -> tuple[bool, Tree] | None:
        for body, value in ((yes, True), (no, False)):
            tree = tree_for(Question(body, premise, True, p), self.setting.ranges, self.work)
            if tree is not None:
                return value, written(tree)
        return None

    def landing(self, i: int, k: int, atom: Expr) -> tuple[bool, Tree] | None:
        """The truth of an atom just after edge k was taken out of cell i, with its proof, if it is certain."""
        key = (i, k, atom)
        if key not in self.landings:
            out = self.cells.exit(i, k)
            assert out is not None, "asked for only where the edge leaves the cell"
            self.landings[key] = self._landing(self.cells.cells[i], out, atom)
        return self.landings[key]

    def _landing(self, cell: Cell, out: Exit, atom: Expr) -> tuple[bool, Tree] | None:
        model = self.setting.model
        edge, written = model.edge(out.edge), model.automaton.edges[out.edge]
        scope = model.landing(out.edge)
        yes, no = _sides(scope, residual(atom, Situation(written.target, written.source, written.name)))
        assert scope.landing is not None, "the scope of a jump"
        arrived = scope.landing.carried_truth(model.mode(edge.target).domain)
        guard = True if edge.urgent else edge.guard
        more = self.setting.assumptions(scope)
        premise = conjunction([guard, model.mode(edge.source).domain, arrived, more])
        return self._decide(yes, no, premise, narrowed(place(model, cell, out, self.setting.extra), more))

    def signal(self, way: Way, atom: Expr) -> Signal:
        """Where an atom holds on a way."""
        found = [self._visited(v, atom) for v in way.visits]
        if way.lost:
            found.append(((), ((ZERO, (self.reach + 1, 1)),)))
        return Signal(tuple(must for must, _ in found), tuple(may for _, may in found))

    def _visited(self, visit: Visit, atom: Expr) -> tuple[Spans, Spans]:
        """Where an atom holds in a cell: what the stay says, but at the first instant what the jump into it says."""
        must, may = spans_of(self.items(visit.cell, atom))
        if visit.entered is not None and any(n.op in EVENTS for n in nodes(atom)):
            landed = self.landing(*visit.entered, atom)
            first: tuple[Cut, Cut] = (ZERO, (Q(0), 1))
            later: Spans = ((first[1], (self.length(visit.cell), 1)),)
            must = joined((*common(must, later), *([first] if landed is not None and landed[0] else [])))
            may = joined((*common(may, later), *([first] if landed is None or landed[0] else [])))
        whole: Spans = ((ZERO, (visit.high, 1)),)
        return common(must, whole), common(may, whole)

    def timeline(self, way: Way) -> Timeline:
        """The dwells of a way."""
        dwells = []
        for v in way.visits:
            sigma = self.cells.cells[v.cell].sigma
            assert sigma is not None and sigma.low is not None and sigma.high is not None, "time is followed"
            dwells.append(Dwell(v.low, v.high, (sigma.low, sigma.high)))
        if way.lost:
            last = dwells[-1]
            clock = (last.clock[0] + last.low, last.clock[1] + last.high)
            dwells.append(Dwell(self.reach + 1, self.reach + 1, clock))
        return Timeline(tuple(dwells))

    def holds(self, way: Way) -> bool | None:
        """The truth of the whole formula at the start of all runs that go this way."""
        signals: dict[tuple[int, bool], Signal] = {}

        def atom(n: int, up: bool) -> Signal:
            if (n, up) not in signals:
                signals[n, up] = self.signal(way, self.atoms[n][0 if up else 1])
            return signals[n, up]

        return at_start(self.stl.value(self.timeline(way), self.rate, atom))


def _sides(scope: Scope, e: Expr) -> tuple[Formula, Formula]:
    """What makes a condition true and what makes it false, everything being defined."""
    return scope.formula(spread(e)), scope.formula(spread(denial(e)))


def _share(p: Placement, low: Q, high: Q) -> Placement:
    """The placement on a part of the dwell."""
    if p.axis is None:
        return p
    ends = sorted((p.origin + p.slope * low, p.origin + p.slope * high))
    return Placement({**p.box, p.axis: (ends[0], ends[1])}, p.replaced, p.axis, p.origin, p.slope, p.bounded)


def ways(reading: Reading) -> Iterator[Way]:
    """All ways of runs through the cells, up to the horizon.

    Raises
    ------
    TooManyError    where they are too many
    """
    spent, count = 0, 0
    pending: list[tuple[int, tuple[int, int] | None, tuple[Visit, ...]]] = []
    pending += [(i, None, ()) for i in reversed(first_cells(reading.cells))]
    while pending:
        i, entered, before = pending.pop()
        for way in _ends(reading, i, entered, before):
            count += 1
            spent += len(way.visits)
            yield way
        if spent > MOST_DWELLS or len(before) > MOST_DWELLS or count > MOST_PATHS:
            raise TooManyError(f"runs go more than {count} ways through {len(before)} dwells or more")
        if len(before) >= AT_ONCE and not any(v.low for v in before[-AT_ONCE:]):
            raise TooManyError(f"runs may make {AT_ONCE} jumps, or ever more, in no time")
        pending += reversed([(j, (i, k), (*before, Visit(i, entered, low, high)))
                             for k, low, high, j in onward(reading, i)])  # fmt: skip


def _ends(reading: Reading, i: int, entered: tuple[int, int] | None, before: tuple[Visit, ...]) -> Iterator[Way]:
    """The ways that end in a cell: where the horizon passes, or where a run may have no way on."""
    cells, cell, length = reading.cells, reading.cells.cells[i], reading.length(i)
    assert cell.sigma is not None and cell.sigma.high is not None, "time is followed"
    horizon = reading.stl.horizon
    if cell.dwell is None or cell.sigma.high + cell.dwell > horizon * reading.rate[0]:
        yield Way((*before, Visit(i, entered, length, length)), False)
    if _may_end(reading, cell) or not never_stuck(cells, i, cells.time):
        kept = not cells.model.mode(cell.mode).terminal and certainly(
            cells.model, cells.model.mode(cell.mode).domain, states(cells, i)
        )
        yield Way((*before, Visit(i, entered, length if kept else Q(0), length)), True)


def _may_end(reading: Reading, cell: Cell) -> bool:
    """Whether a run may stop there in a state that the cell does not keep until the horizon (LANGUAGE S12)."""
    mode = reading.cells.model.mode(cell.mode)
    assert cell.sigma is not None and cell.sigma.low is not None, "time is followed"
    short = cell.dwell is not None and cell.sigma.low + cell.dwell <= reading.reach
    return mode.terminal and (short or any(mode.slopes.values()))


def onward(reading: Reading, i: int) -> Iterator[tuple[int, Q, Q, int]]:
    """The edges that leave a cell within the horizon: after which stays, and for which cells."""
    cells = reading.cells
    cell = cells.cells[i]
    assert cell.sigma is not None and cell.sigma.low is not None, "time is followed"
    for k in cells.model.leaving[cell.mode]:
        out = cells.exit(i, k)
        if out is None or cell.sigma.low + out.dwell[0] > reading.reach:
            continue
        length, (low, high) = reading.length(i), out.dwell
        sigma = out.sigma if out.sigma is not None else Interval()
        for j in located(cells, cells.model.edge(k).target, out.after, sigma):
            yield k, low, length if high is None else min(high, length), j


def first_cells(cells: Cells) -> list[int]:
    """The cells in which runs start."""
    found: dict[int, None] = {}
    model = cells.model
    for init in model.automaton.init:
        for mode in range(len(model.automaton.modes)) if init.mode is None else [model.index[init.mode]]:
            box = start_box(model, init, mode)
            if box is not None:
                found.update(dict.fromkeys(located(cells, mode, box, point(Q(0)))))
    return list(found)


def located(cells: Cells, mode: int, box: Box, sigma: Interval) -> list[int]:
    """The one cell that contains a box, else all that touch it."""
    members = cells.of_mode(mode)
    for i in members:
        c = cells.cells[i]
        if (c.sigma or sigma).contains(sigma) and all(c.entry[v].contains(x) for v, x in box.items()):
            return [i]
    return [i for i in members if _touches(cells.cells[i], box, sigma)]


def _touches(c: Cell, box: Box, sigma: Interval) -> bool:
    apart = any(c.entry[v].closed.meet(x.closed).is_empty for v, x in box.items())
    return not apart and not (c.sigma or sigma).meet(sigma).is_empty
