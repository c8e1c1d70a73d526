"""What the exact analyses know of clock-driven automata, as far as rules need it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

from haverify.analyses.bounds import Interval
from haverify.analyses.clock_model import ClockModel, clock_model
from haverify.analyses.clocked import Cells, explore, moved
from haverify.analyses.motion import Motion
from haverify.lint._facts import Facts
from haverify.lint._walk import stuck_states
from haverify.maths.polynomial import Polynomial
from haverify.maths.sturm import extremes
from haverify.maths.univariate import integers
from haverify.model.expression import Expr
from haverify.model.hybrid import HybridAutomaton, Mode
from haverify.obligations.translate import OutsideFragmentError
from haverify.solvers.literals import TooManyCasesError, terms

Q = Fraction


@dataclass(frozen=True)
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


def cells_of(facts: Facts, automaton: HybridAutomaton) -> Cells | None:
    """The cells that contain all runs, None where they are not known."""

    def compute() -> Cells | None:
        model = model_of(facts, automaton)
        try:
            found = explore(model) if model is not None else None
        except OutsideFragmentError:
            return None
        return found if found is not None and found.trouble is None else None

    return facts.remembered(("cells", automaton.name), compute)


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


def span_of(p: Polynomial, over: Interval) -> tuple[Q, Q] | None:
    """Rationals around the exact least and greatest value of a polynomial in one variable on a bounded interval."""
    if over.low is None or over.high is None or over.is_empty:
        return None
    least, greatest = extremes(integers_of(p), over.low, over.high)
    scale = integers(p.univariate())[1]
    return least.low * scale, greatest.high * scale


def integers_of(p: Polynomial) -> tuple[int, ...]:
    """The polynomial's integer multiple."""
    return integers(p.univariate())[0]


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
