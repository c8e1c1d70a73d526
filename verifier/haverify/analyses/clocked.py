"""Cells: the exact reached clock intervals of a clock-driven automaton, mode by mode, closed under flow and edges.

A cell is a box of entry values, entered and left only as its conditions on single variables allow; its states are
`e + c s` for `e` in the box and `0 <= s <= dwell`, inside the domain. What is explored contains every run (docs/core.md
section 5, "Cells are complete"); with several clocks, or after joining, it may contain more.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from itertools import product
from math import prod

from haverify.analyses.bounds import EVERYTHING, Box, Interval, narrow, point
from haverify.analyses.cell import Cell, Exit, moved
from haverify.analyses.clock_model import ClockEdge, ClockMode, ClockModel
from haverify.analyses.opening import certainly, due, outcome
from haverify.maths.bernstein import bounds as range_on
from haverify.maths.exact import significant
from haverify.maths.polynomial import Polynomial
from haverify.model.hybrid import Assign, Init, Range
from haverify.obligations.formula import negation
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import field, holder, replace

Q = Fraction
MOST_CELLS = 20_000
MOST_TIMED = 4_000  # cells that follow time as well: each turn of a cycle has its own
RECENT = 64  # timed cells of one group among which one that covers a new one is sought
SEPARATE = 12  # cells of one mode and discrete state before they are joined
MOST_CHOICES = 256
PATIENCE = 3  # joins of one cell before its moving ends are widened


@holder
class Cells:
    """All cells of an automaton up to a horizon (None: of all runs). `trouble` says why they are not
    complete, if so."""

    model: ClockModel
    time: Q | None
    jumps: int | None
    tracked: bool
    cells: list[Cell] = field(default_factory=list)
    trouble: tuple[str, str] | None = None
    never: dict[object, bool] = field(default_factory=dict)  # by premises: whether they never hold on a run
    _exits: dict[tuple[int, int], Exit | None] = field(default_factory=dict)
    _by_mode: dict[int, list[int]] | None = None

    def of_mode(self, mode: int) -> list[int]:
        """The positions of a mode's cells, in order."""
        if self._by_mode is None:
            self._by_mode = {}
            for i, c in enumerate(self.cells):
                self._by_mode.setdefault(c.mode, []).append(i)
        return self._by_mode.get(mode, [])

    def exit(self, cell: int, edge: int) -> Exit | None:
        """How the edge leaves the cell, None where it cannot or where the horizon's last jump was made."""
        if self.jumps is not None and self.cells[cell].jumps == self.jumps:
            return None
        if (cell, edge) not in self._exits:
            self._exits[cell, edge] = leave(self.model, self.cells[cell], self.model.edge(edge), self.limit)
        return self._exits[cell, edge]

    @property
    def limit(self) -> Q | None:
        """The greatest scaled time within the horizon."""
        return None if self.time is None or not self.tracked else self.time * self.model.rho_range[1]


def explore(model: ClockModel, time: Q | None = None, jumps: int | None = None) -> Cells:
    """The cells of all runs, or of those up to time `time` and `jumps` jumps.

    Time is followed exactly when `time` is given; then all modes must share one rate.
    """
    found = Cells(model, time, jumps, time is not None)
    search = _Search(found)
    for cell in starts(model, found.tracked, jumps is not None):
        search.add(cell)
    search.run()
    _forget_covered(found)
    found.trouble = found.trouble or left_window(found)
    return found


@holder
class _Search:
    found: Cells
    queue: list[int] = field(default_factory=list)
    groups: dict[object, list[int]] = field(default_factory=dict)

    def run(self) -> None:
        cells, position = self.found.cells, 0
        while position < len(self.queue):
            index = self.queue[position]
            position += 1
            most = MOST_TIMED if self.found.tracked else MOST_CELLS
            if position > 4 * most or len(cells) > most:
                self.found.trouble = ("budget", self._too_many(cells[index], most))
                return
            cell = cells[index]
            cell.dwell = longest(self.found.model, cell, self.found.limit)
            for k in self.found.model.leaving[cell.mode]:
                out = leave(self.found.model, cell, self.found.model.edge(k), self.found.limit)
                if out is not None and (self.found.jumps is None or (cell.jumps or 0) < self.found.jumps):
                    for entered in landed(cell, out, self.found.model):
                        self.add(entered, index, k)

    def _too_many(self, cell: Cell, most: int) -> str:
        """How far it went, the cells being explored in about the order of time."""
        sigma, time = cell.sigma, self.found.time
        if sigma is None or sigma.low is None or time is None:
            return f"more than {most} cells; fewer clocks or choices would do"
        way = f"{significant(sigma.low / self.found.model.rho_range[1])} s of {significant(time)} s"
        return f"runs were followed to {way}, for {most} cells; a shorter horizon would do"

    def add(self, cell: Cell, parent: int | None = None, edge: int = 0) -> None:
        """Make sure that some cell covers this one, and look at it again if it grew for that."""
        group = self.groups.setdefault(self._key(cell), [])
        cells = self.found.cells
        if any(_covers(cells[i], cell) for i in (group if cell.sigma is None else group[-RECENT:])):
            return
        if parent is not None:
            cell.parent, cell.depth = (parent, edge), cells[parent].depth + 1
        if len(group) < SEPARATE or cell.sigma is not None or cell.jumps is not None:
            group.append(len(cells))
            self.queue.append(len(cells))
            cells.append(cell)
            return
        _join(self.found.model, cells[group[-1]], cell)
        self.queue.append(group[-1])

    def _key(self, cell: Cell) -> object:
        return cell.mode, cell.jumps, tuple(cell.entry[v].low for v in self.found.model.discrete)


def _covers(old: Cell, new: Cell) -> bool:
    if old.sigma is not None and new.sigma is not None and not old.sigma.contains(new.sigma):
        return False
    return all(old.entry[v].contains(x) for v, x in new.entry.items())


def _join(model: ClockModel, old: Cell, new: Cell) -> None:
    """Grow `old` around `new`; after a few times each end that still moves goes to the domain's or to infinity."""
    old.joins += 1
    allowed = model.mode(old.mode).allowed or {}
    for v, x in new.entry.items():
        hull = old.entry[v].hull(x)
        if old.joins > PATIENCE:
            limit = allowed.get(v, EVERYTHING)
            low = hull.low if hull.low == old.entry[v].low else limit.low
            high = hull.high if hull.high == old.entry[v].high else limit.high
            hull = Interval(low, high)
        old.entry[v] = hull


def _forget_covered(found: Cells) -> None:
    """Drop cells that a joined one covers; their successors are covered by the other's."""
    joined = [j for j, c in enumerate(found.cells) if c.joins]
    kept = [i for i, c in enumerate(found.cells) if c.joins or not any(_hides(found.cells[j], c) for j in joined)]
    position = {old: new for new, old in enumerate(kept)}
    found.cells = [found.cells[i] for i in kept]
    for cell in found.cells:
        if cell.parent is not None:
            cell.parent = (position[cell.parent[0]], cell.parent[1]) if cell.parent[0] in position else None


def _hides(old: Cell, new: Cell) -> bool:
    return old.mode == new.mode and old.jumps == new.jumps and _covers(old, new)


def starts(model: ClockModel, tracked: bool, counted: bool) -> Iterator[Cell]:
    """One cell for each init line and mode it allows."""
    for init in model.automaton.init:
        modes = range(len(model.automaton.modes)) if init.mode is None else [model.index[init.mode]]
        for index in modes:
            entry = start_box(model, init, index)
            if entry is not None:
                cell = Cell(index, entry, point(Q(0)) if tracked else None, 0 if counted else None)
                yield from separated(model, cell)


def separated(model: ClockModel, cell: Cell) -> Iterator[Cell]:
    """The cell, once for each choice of values of its discrete variables; whole where these are too many."""
    choices = [[point(x) for x in values if cell.entry[v].contains(point(x))] for v, values in model.discrete.items()]
    if all(cell.entry[v].is_point for v in model.discrete) or prod(map(len, choices)) > MOST_CHOICES:
        yield cell
        return
    for picks in product(*choices):
        yield replace(cell, entry={**cell.entry, **dict(zip(model.discrete, picks, strict=True))})


def start_box(model: ClockModel, init: Init, index: int, strict: bool = False) -> Box | None:
    """The closed box of the states that an init line allows in a mode, None where there is none.

    The declared range stands in where neither the line nor the domain bounds a variable.
    """
    mode, scope = model.mode(index), model.scope(index)
    box: Box | None = dict.fromkeys(model.windows, EVERYTHING)
    for a in init.assigns:
        box = {**(box or {}), a.var: _assigned(model, a, index)}
    for f in (scope.formula(init.where), mode.domain):
        box = None if box is None else narrow(f, box, model.params, strict)
    if box is None or any(x.is_empty for x in box.values()):
        return None
    return {v: _filled(x.closed, model.windows[v]) for v, x in box.items()}


def _filled(x: Interval, window: Interval) -> Interval:
    return Interval(window.low if x.low is None else x.low, window.high if x.high is None else x.high)


def _assigned(model: ClockModel, a: Assign, index: int) -> Interval:
    """The values that an assignment of an init line gives; its right side reads constants and params."""
    scope = model.scope(index)
    if isinstance(a.to, Range):
        low, high = scope.polynomial(a.to.low), scope.polynomial(a.to.high)
        return Interval(_constant_range(model, low).low, _constant_range(model, high).high)
    if scope.is_truth(a.to):
        return point(Q(int(scope.formula(a.to) is True)))
    return _constant_range(model, scope.polynomial(a.to))


def _constant_range(model: ClockModel, p: Polynomial) -> Interval:
    if not all(v in model.params for v in p.variables):
        raise OutsideFragmentError("a start is computed from other variables")
    return Interval(*range_on(p, model.params))


def longest(model: ClockModel, cell: Cell, limit: Q | None) -> Q | None:
    """The longest scaled dwell in a cell, None where a run may stay for ever."""
    mode = model.mode(cell.mode)
    ends = [] if limit is None or cell.sigma is None or cell.sigma.low is None else [limit - cell.sigma.low]
    for v, c in mode.slopes.items():
        end = _until(cell.entry[v], c, (mode.allowed or {}).get(v, EVERYTHING))
        if end is not None:
            ends.append(end)
    for k in model.leaving[cell.mode]:
        edge = model.edge(k)
        if edge.urgent:
            opened = due(model, cell, edge)
            if opened is not None:
                ends.append(opened.last)
    return max(Q(0), min(ends)) if ends else None


def _until(entry: Interval, slope: Q, allowed: Interval) -> Q | None:
    """How long `e + slope * s` can stay inside `allowed`."""
    if slope > 0 and allowed.high is not None and entry.low is not None:
        return (allowed.high - entry.low) / slope
    if slope < 0 and allowed.low is not None and entry.high is not None:
        return (allowed.low - entry.high) / slope
    return None


def leave(model: ClockModel, cell: Cell, edge: ClockEdge, limit: Q | None, strict: bool = False) -> Exit | None:
    """How an edge leaves a cell: guard and both domains taken variable by variable, None where that leaves nothing.

    Certificates read guards as closed; `strict` reads that of an edge that is not urgent as it is written.
    """
    mode = model.mode(cell.mode)
    if mode.allowed is None or model.mode(edge.target).allowed is None:
        return None
    reach = {v: moved(x, mode.slopes[v], Q(0), cell.dwell).meet(mode.allowed[v]) for v, x in cell.entry.items()}
    if any(x.is_empty for x in reach.values()):
        return None
    gate = narrow(edge.guard, reach, model.params, strict and not edge.urgent)
    if gate is None:
        return None
    during = _during(mode, cell, gate)
    if during is None or (
        limit is not None and cell.sigma is not None and (cell.sigma.low or Q(0)) + during[0] > limit
    ):
        return None
    before = {v: moved(x, mode.slopes[v], *during).meet(gate[v]).closed for v, x in cell.entry.items()}
    if any(x.is_empty for x in before.values()):
        return None
    if not edge.urgent and certainly(model, negation(edge.guard), before):
        return None
    after = narrow(model.mode(edge.target).domain, outcome(model, edge, before), model.params)
    if after is None:
        return None
    sigma = None if cell.sigma is None else moved(cell.sigma, Q(1), *during)
    if sigma is not None and limit is not None and sigma.high is not None:
        sigma = sigma.meet(Interval(None, limit))
    return Exit(edge.index, during, before, {v: x.closed for v, x in after.items()}, sigma)


def _during(mode: ClockMode, cell: Cell, gate: Box) -> tuple[Q, Q | None] | None:
    """The scaled dwells at which some entry is inside the gate in every variable."""
    whole = Interval(Q(0), cell.dwell)
    for v, c in mode.slopes.items():
        if c:
            whole = whole.meet(_dwells(cell.entry[v], c, gate[v]))
    return None if whole.is_empty else (whole.low or Q(0), whole.high)


def _dwells(entry: Interval, c: Q, gate: Interval) -> Interval:
    if c > 0:
        low = None if gate.low is None or entry.high is None else (gate.low - entry.high) / c
        high = None if gate.high is None or entry.low is None else (gate.high - entry.low) / c
        return Interval(low, high, gate.open_low, gate.open_high)
    low = None if gate.high is None or entry.low is None else (gate.high - entry.low) / c
    high = None if gate.low is None or entry.high is None else (gate.low - entry.high) / c
    return Interval(low, high, gate.open_high, gate.open_low)


def landed(cell: Cell, out: Exit, model: ClockModel) -> Iterator[Cell]:
    """The cells that an exit enters, one for each choice of discrete values."""
    jumps = None if cell.jumps is None else cell.jumps + 1
    return separated(model, Cell(model.edge(out.edge).target, dict(out.after), out.sigma, jumps))


def left_window(found: Cells) -> tuple[str, str] | None:
    model = found.model
    for cell in found.cells:
        mode = model.mode(cell.mode)
        for v, window in model.windows.items():
            states = moved(cell.entry[v], mode.slopes[v], Q(0), cell.dwell).meet(
                (mode.allowed or {}).get(v, EVERYTHING)
            )
            if not window.contains(states):
                end = "without bound" if states.high is None else f"to {states.high}"
                return "window", f"`{v}` may leave its declared range in mode {mode.name} (it runs {end})"
    return None
