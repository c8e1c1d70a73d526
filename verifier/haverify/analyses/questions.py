"""One part of a claim on one cell: which formula has to hold on which box, under which premises."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from functools import cached_property

from haverify.analyses.bounds import Interval, narrow
from haverify.analyses.cell import Cell, Exit
from haverify.analyses.clock_model import CLOCK, ClockModel
from haverify.analyses.clocked import Cells
from haverify.analyses.placement import Placement, place
from haverify.analyses.poly_range import ENOUGH, Ranges
from haverify.maths.polynomial import variable
from haverify.model.claim import Claim, Goal
from haverify.model.expression import Expr
from haverify.obligations.constants import Values, rounded
from haverify.obligations.formula import Formula, Literal, compare, conjunction, disjunction, literals, negation
from haverify.obligations.horizon import implied_end
from haverify.obligations.parts import Part
from haverify.obligations.spread import spread
from haverify.obligations.translate import OutsideFragmentError, Scope
from haverify.text.record import field, holder, record, replace

Q = Fraction
FEW = 8


@holder
class Setting:
    """A goal of a claim on an automaton: its horizon and assumptions, and what was computed for it before.

    `model` may have symbolic constants; `extra` gives their ranges.
    """

    model: ClockModel
    claim: Claim
    goal: Goal
    ranges: Ranges
    extra: Mapping[str, tuple[Q, Q]] = field(default_factory=dict)
    hash: str | None = None  # of the goal, once it is known
    units: int = ENOUGH  # the work allowed for it

    def scaled(self, usual: int) -> int:
        """A limit for the work allowed, where `usual` is that for the usual amount; never less than a few."""
        return max(FEW, usual * self.units // ENOUGH)

    def time_limit(self) -> Q | None:
        """The last instant that the goal speaks of, in s; None for all time."""
        ends = [self._number(e) for e in (self.claim.time, self.goal.within) if e is not None]
        if self.goal.window is not None:
            ends.append(self._number(self.goal.window[1]))
        if self.implied is not None:
            ends.append(self.implied)
        return min(ends) if ends else None

    @cached_property
    def implied(self) -> Q | None:
        """The last instant at which what is claimed can be false by its own premises."""
        if self.goal.kind not in ("always", "can_reach"):
            return None
        e = self.goal.condition
        return implied_end(e if self.goal.kind == "always" else Expr("not", (e,)), self._known_number)

    def _known_number(self, e: Expr) -> Q | None:
        try:
            return self._number(e)
        except OutsideFragmentError:
            return None

    def has_instants(self) -> bool:
        """Whether the window and the horizon leave any instant to speak of."""
        first = self._number(self.goal.window[0]) if self.goal.window is not None else Q(0)
        last = self.time_limit()
        return last is None or last >= max(first, Q(0))

    def _number(self, e: Expr) -> Q:
        return self.model.values.number(e)

    def assumptions(self, scope: Scope) -> Formula:
        """Everything that is assumed, at an instant."""
        assumed = (*self.model.spec.assumptions, *self.claim.assume)
        return conjunction(scope.formula(a) for a in assumed)

    def timing(self, mode: int | None = None) -> Formula:
        """The instants that the goal speaks of, as a condition on `sigma`; True for all.

        A run that has ended in a terminal `mode` is frozen while time goes on (LANGUAGE S12): there, no instant is too
        early.
        """
        members: list[Formula] = []
        ends = mode is not None and self.model.automaton.modes[mode].terminal
        if self.goal.window is not None and not ends:
            members.append(self._time(">=", self.goal.window[0]))
        if self.goal.window is not None:
            members.append(self._time("<=", self.goal.window[1]))
        for e in (self.claim.time, self.goal.within):
            if e is not None and self.model.rho is not None:
                members.append(self._time("<=", e))
        return conjunction(members)

    def _time(self, op: str, bound: Expr) -> Formula:
        if self.model.rho is None:
            raise OutsideFragmentError("the claim speaks of time, but the modes do not share one rate")
        return compare(op, variable(CLOCK) - self.model.rho.scaled(self._number(bound)))


@record
class Question:
    """`premise` implies `body` on the box of the placement, in the variables of the state (not yet placed)."""

    body: Formula
    premise: Formula
    extra_premise: bool  # whether more is assumed than what bounds the box
    placement: Placement

    def goal(self) -> Formula:
        """The whole formula, placed."""
        return self.placement.place(disjunction([negation(self.premise), self.body]))


def questions(setting: Setting, part: Part, cells: Cells) -> Iterator[tuple[int, Question]]:
    """The cells that a dwell or jump part concerns, in order, each with its question."""
    if part.kind == "dwell":
        yield from _dwelling(setting, part, cells)
    else:
        yield from _landing(setting, part, cells)


def _dwelling(setting: Setting, part: Part, cells: Cells) -> Iterator[tuple[int, Question]]:
    model = setting.model
    index = model.index[part.mode]
    members = cells.of_mode(index)
    if not members:
        return
    scope = model.timed_scope(index)
    body = conjunction(scope.formula(spread(r)) for r in part.residuals)
    more = conjunction([setting.assumptions(scope), setting.timing(index) if cells.tracked else True])
    premise = conjunction([model.mode(index).domain, more])
    for i in members:
        placement = narrowed(place(model, cells.cells[i], None, setting.extra), more)
        yield i, Question(body, premise, _more(more, cells.cells[i], model.params), placement)


def _landing(setting: Setting, part: Part, cells: Cells) -> Iterator[tuple[int, Question]]:
    model = setting.model
    assert part.edge is not None, "a jump part has an edge"
    edge = model.edge(part.edge)
    found = [(i, out) for i in cells.of_mode(edge.source) if (out := cells.exit(i, part.edge)) is not None]
    if not found:
        return
    landing = model.landing(part.edge)
    body = conjunction(landing.formula(spread(r)) for r in part.residuals)
    assert landing.landing is not None, "the scope of a jump"
    arrived = landing.landing.carried_truth(model.mode(edge.target).domain)
    more = conjunction([setting.assumptions(landing), setting.timing(edge.target) if cells.tracked else True])
    guard = edge.guard if not edge.urgent else True
    premise = conjunction([guard, model.mode(edge.source).domain, arrived, more])
    for i, out in found:
        placement = narrowed(place(model, cells.cells[i], out, setting.extra), more)
        yield i, Question(body, premise, _more(more, cells.cells[i], model.params), placement)


def _more(more: Formula, cell: Cell, params: Mapping[str, tuple[Q, Q]]) -> bool:
    """Whether the box alone says less than is assumed; bounds on single params are in the box."""
    inside = all(len(p.variables) == 1 and p.variables[0] in params and p.degree(p.variables[0]) == 1
                 for p in (leaf.polynomial for leaf in literals(more)))  # fmt: skip
    plain = inside and (isinstance(more, (bool, Literal)) or more.is_and)
    return not plain or any(not x.is_point for x in cell.entry.values())


def narrowed(placement: Placement, more: Formula) -> Placement:
    """The params' box cut to what is assumed of each of them alone."""
    if more is True:
        return placement
    box = {v: Interval(*ends) for v, ends in placement.box.items()}
    cut = narrow(more, {v: x for v, x in box.items() if v not in placement.replaced and v != placement.axis}, {})
    if cut is None:
        return placement
    ends = {v: (x.low, x.high) for v, x in cut.items() if x.low is not None and x.high is not None}
    return replace(placement, box={**placement.box, **ends})


def symbolic_model(model: ClockModel, names: frozenset[str]) -> ClockModel:
    """The same automaton with some constants left as variables."""
    values = Values(model.values.constants, model.values.positions, names)
    return ClockModel(model.spec, model.automaton, values, model.params)


def rounding_box(model: ClockModel) -> dict[str, tuple[Q, Q]]:
    """The boxes of all constants with limited digits."""
    return rounded(model.values)


def exits_of(cells: Cells, cell: int) -> list[Exit]:
    """The exits of a cell, in order of the edges."""
    found = [cells.exit(cell, k) for k in cells.model.leaving[cells.cells[cell].mode]]
    return [x for x in found if x is not None]
