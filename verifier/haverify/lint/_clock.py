"""What the exact analyses know of clock-driven automata, as far as rules need it."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from functools import cached_property

from haverify.analyses.bounds import Interval
from haverify.analyses.cell import moved
from haverify.analyses.clock_model import ClockModel, clock_model
from haverify.analyses.clocked import Cells, explore
from haverify.analyses.motion import Motion
from haverify.lint._facts import Facts
from haverify.lint._walk import stuck_states
from haverify.maths import bernstein
from haverify.maths.polynomial import Polynomial
from haverify.maths.sturm import extremes
from haverify.maths.univariate import integers
from haverify.model.expression import Expr
from haverify.model.hybrid import HybridAutomaton, Mode
from haverify.obligations.translate import OutsideFragmentError
from haverify.solvers.literals import TooManyCasesError, terms
from haverify.text.record import record

Q = Fraction


@record
class Lock:
    """A state that a run reaches, where the flow leaves the domain of the mode and no edge is enabled."""

    mode: Mode
    values: dict[str, Q]


def model_of(facts: Facts, automaton: HybridAutomaton) -> ClockModel | None:
    """The automaton as a clock-driven one, None where it is none."""

    def compute() -> ClockModel | None:
        try:
            return clock_model(facts.spec, automaton)
        except OutsideFragmentError:
            return None

    return facts.remembered(("clock", automaton.name), compute)


def explored(facts: Facts, automaton: HybridAutomaton) -> Cells | None:
    """The cells as far as they were explored, with what troubles them; None where there are none."""

    def compute() -> Cells | None:
        model = model_of(facts, automaton)
        try:
            return explore(model) if model is not None else None
        except OutsideFragmentError:
            return None

    return facts.remembered(("cells", automaton.name), compute)


def cells_of(facts: Facts, automaton: HybridAutomaton) -> Cells | None:
    """The cells that contain all runs, None where they are not known."""
    found = explored(facts, automaton)
    return found if found is not None and found.trouble is None else None


def dwelling(cells: Cells, mode: int, variable: str) -> Interval | None:
    """The values a variable takes in a mode, None where it is never entered."""
    found: Interval | None = None
    allowed = (cells.model.mode(mode).allowed or {}).get(variable, Interval())
    for k in cells.of_mode(mode):
        cell = cells.cells[k]
        here = moved(cell.entry[variable], cells.model.mode(mode).slopes[variable], Q(0), cell.dwell).meet(allowed)
        found = here if found is None else found.hull(here)
    return found


def polynomial(facts: Facts, automaton: HybridAutomaton, mode: Mode, e: Expr) -> Polynomial | None:
    """An expression in a mode as one polynomial, None where it has cases."""
    try:
        found = terms(e, facts.frame(automaton, mode))
    except TooManyCasesError:
        return None
    return found[0][1] if len(found) == 1 and not found[0][0] else None


@record
class Curve:
    """An output as a polynomial of one variable, on the values that the variable takes in a mode."""

    poly: Polynomial
    variable: str
    over: Interval

    @cached_property
    def ends(self) -> tuple[Q, Q]:
        """The values at both ends."""
        assert self.over.low is not None and self.over.high is not None
        low, high = self.poly.value({self.variable: self.over.low}), self.poly.value({self.variable: self.over.high})
        return min(low, high), max(low, high)

    def bounds(self) -> tuple[Q, Q]:
        """Numbers below and above all values, found cheaply."""
        assert self.over.low is not None and self.over.high is not None
        return bernstein.bounds(self.poly, {self.variable: (self.over.low, self.over.high)})

    def extremes(self) -> tuple[Q, Q]:
        """The least and greatest value: exact, or rationals just outside where they are none."""
        assert self.over.low is not None and self.over.high is not None
        whole, scale = integers(self.poly.univariate())
        least, greatest = extremes(whole, self.over.low, self.over.high)
        return least.low * scale, greatest.high * scale


def curve(facts: Facts, automaton: HybridAutomaton, mode: Mode, e: Expr) -> Curve | None:
    """An expression as a curve over the clock values of a mode that runs enter; None where it is none."""
    cells = cells_of(facts, automaton)
    p = polynomial(facts, automaton, mode, e) if cells is not None else None
    if cells is None or p is None or len(p.variables) != 1 or p.variables[0] not in facts.scope(automaton).vars:
        return None
    place = cells.model.index[mode.name], p.variables[0]
    over = facts.remembered(("dwelling", automaton.name, *place), lambda: dwelling(cells, *place))
    is_bounded = over is not None and over.low is not None and over.high is not None and not over.is_empty
    if over is None or not is_bounded:
        return None
    found = Curve(p, p.variables[0], over)
    return facts.remembered(found, lambda: found)  # what it keeps serves copies of an automaton too


def locks(facts: Facts, automaton: HybridAutomaton) -> Iterator[Lock]:
    """Time-locks on concrete runs, for the least values of the params. Exact where one is found."""
    model = model_of(facts, automaton)
    if model is None:
        return
    try:
        for state in stuck_states(Motion(model, {n: low for n, (low, _) in model.params.items()})):
            yield Lock(automaton.modes[state.mode], dict(state.values))
    except OutsideFragmentError:
        return
