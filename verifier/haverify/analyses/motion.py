"""Concrete motion of a clock-driven automaton: one state, one value per param, real time, exact numbers
(LANGUAGE S6-S9)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from functools import cached_property
from itertools import product

from haverify.analyses.bounds import Interval, image
from haverify.analyses.clock_model import CLOCK, ClockEdge, ClockModel
from haverify.analyses.clocked import start_box
from haverify.analyses.poly_range import pieces
from haverify.maths import sturm
from haverify.maths.polynomial import Polynomial, constant, variable
from haverify.model.expression import Expr
from haverify.model.hybrid import Init
from haverify.obligations.formula import Formula, compare, conjunction, holds, negation, transform
from haverify.text.record import field, holder, record

Q = Fraction
NOW = "t"
Values = Mapping[str, Q]
FAR = Q(1000)  # s; how far a dwell without any bound is looked at


@record
class State:
    """A mode, the values of its variables, the time (s) since the start and the number of jumps made."""

    mode: int
    values: Values
    time: Q
    jumps: int = 0


@record
class Stretch:
    """An interval of dwells (s) on which something holds; an end that is no rational is replaced by one inside."""

    low: Q
    high: Q
    low_closed: bool
    high_closed: bool

    def rationals(self) -> Iterator[Q]:
        """A few of its numbers, the ends first."""
        if self.low_closed:
            yield self.low
        if self.high_closed and self.high > self.low:
            yield self.high
        if self.low < self.high:
            yield (self.low + self.high) / 2


@holder
class Motion:
    """An automaton under fixed params."""

    model: ClockModel
    params: Values
    _rates: dict[int, Values] = field(default_factory=dict)
    _domains: dict[int, Formula] = field(default_factory=dict)
    _guards: dict[int, Formula] = field(default_factory=dict)

    def rate(self, mode: int) -> Values:
        """The speed of each variable, in its unit per s."""
        if mode not in self._rates:
            m = self.model.mode(mode)
            rho = m.rho.value(self.params)
            self._rates[mode] = {v: c * rho for v, c in m.slopes.items()}
        return self._rates[mode]

    def along(self, f: Formula, state: State) -> Formula:
        """A formula over the state as one over the dwell `t` (s)."""
        replaced = self.replaced(state)
        return transform(f, lambda p: p.fix(self.params).substitute(replaced))

    def replaced(self, state: State) -> dict[str, Polynomial]:
        """What each variable is after a dwell of `t`."""
        now = variable(NOW)
        rate = self.rate(state.mode)
        moved = {v: constant(x) + now.scaled(rate[v]) for v, x in state.values.items()}
        if self.model.rho is not None:
            moved[CLOCK] = (constant(state.time) + now).scaled(self.model.rho.value(self.params))
        return moved

    def at(self, state: State, dwell: Q) -> State:
        """The state after a dwell, no jump made."""
        rate = self.rate(state.mode)
        values = {v: x + rate[v] * dwell for v, x in state.values.items()}
        return State(state.mode, values, state.time + dwell, state.jumps)

    def known(self, state: State) -> dict[str, Q]:
        """The value of everything a formula can name at a state."""
        values = {**self.params, **state.values}
        if self.model.rho is not None:
            values[CLOCK] = state.time * self.model.rho.value(self.params)
        return values

    def domain(self, mode: int) -> Formula:
        """The closed domain for these params."""
        if mode not in self._domains:
            self._domains[mode] = transform(self.model.mode(mode).domain, lambda p: p.fix(self.params))
        return self._domains[mode]

    @cached_property
    def declared(self) -> Formula:
        """The declared ranges, and types: a run is followed while it is inside them (LANGUAGE S4)."""
        found: list[Formula] = []
        for v, window in self.model.windows.items():
            if window.low is not None:
                found.append(compare(">=", variable(v) - constant(window.low)))
            if window.high is not None:
                found.append(compare("<=", variable(v) - constant(window.high)))
        return conjunction(found)

    def enabled(self, k: int) -> Formula:
        """Guard, and an outcome in the target's domain where the reset leaves no choice, over the state before."""
        if k not in self._guards:
            edge = self.model.edge(k)
            assigned = {v: r.low for v, r in edge.resets.items() if not r.is_set}
            members = [edge.guard]
            if len(assigned) == len(edge.resets):
                target = self.model.mode(edge.target).domain
                members.append(transform(target, lambda p: p.substitute(assigned)))
            self._guards[k] = transform(conjunction(members), lambda p: p.fix(self.params))
        return self._guards[k]

    def stay(self, state: State, limit: Q | None) -> tuple[Q, bool] | None:
        """The longest dwell (s) and whether it is the end of the stay (else of the view); None where no
        state is allowed.

        The domain bounds it, an urgent edge that is due, or `limit`; what is beyond a declared range is not viewed.
        """
        view = FAR if limit is None else limit
        seen = stretches(self.along(self.declared, state), view)
        inside = stretches(self.along(self.domain(state.mode), state), view)
        if not seen or seen[0].low > 0 or not inside or inside[0].low > 0:
            return None
        end, ended = min(inside[0].high, seen[0].high), inside[0].high < view and inside[0].high <= seen[0].high
        for k in self.model.leaving[state.mode]:
            opened = self._opened(state, k, view) if self.model.edge(k).urgent else []
            if opened and opened[0].low <= end:  # where no outcome is seen there may be one: not followed further
                due = self._due_at(state, k, opened[0], view)
                end, ended = due, due == opened[0].low and self._leads_on(state, k, opened[0])
        return end, ended

    def _due_at(self, state: State, k: int, opened: Stretch, view: Q) -> Q:
        """The last rational (s) that is certainly no later than an edge's opening: no dwell goes beyond it."""
        waiting = stretches(negation(self.along(self.enabled(k), state)), view)
        return min(waiting[0].high, opened.low) if waiting and waiting[0].low == 0 else opened.low

    def due(self, state: State, k: int, view: Q) -> Q | None:
        """The first dwell at which an edge is enabled, or is at all times just after it."""
        found = self.openings(state, k, view)
        return found[0].low if found else None

    def openings(self, state: State, k: int, view: Q) -> list[Stretch]:
        """When an edge is enabled, the source's domain ignored."""
        return [s for s in self._opened(state, k, view) if self._leads_on(state, k, s)]

    def _opened(self, state: State, k: int, view: Q) -> list[Stretch]:
        """When an edge is enabled, if it is one that chooses values and some choice is possible."""
        return stretches(self.along(self.enabled(k), state), view)

    def _leads_on(self, state: State, k: int, opened: Stretch) -> bool:
        """Whether some choice is seen to be possible there; true of an edge that chooses nothing."""
        edge = self.model.edge(k)
        if not any(r.is_set for r in edge.resets.values()):
            return True
        return any(True for _ in self.outcomes(self.at(state, (opened.low + opened.high) / 2), edge))

    def outcomes(self, state: State, edge: ClockEdge) -> Iterator[tuple[State, dict[str, Q]]]:
        """Some states that an edge makes of a state, with the values chosen by set resets; all in the
        target's domain."""
        known = self.known(state)
        chosen = {v: r for v, r in edge.resets.items() if r.is_set}
        choices = [_some(r.low.value(known), r.high.value(known)) for r in chosen.values()]
        fixed = {v: r.low.value(known) for v, r in edge.resets.items() if not r.is_set}
        for picks in product(*choices):
            picked = dict(zip(chosen, picks, strict=True))
            after = State(edge.target, {**state.values, **fixed, **picked}, state.time, state.jumps + 1)
            if holds(self.domain(edge.target), after.values) and holds(self.declared, after.values):
                yield after, picked

    def starts(self) -> Iterator[State]:
        """Some admissible states to start from, those of the first init line first."""
        for init in self.model.automaton.init:
            modes = range(len(self.model.automaton.modes)) if init.mode is None else [self.model.index[init.mode]]
            for index in modes:
                yield from self._starts(init, index)

    def _starts(self, init: Init, index: int) -> Iterator[State]:
        box = start_box(self.model, init, index)
        if box is None:
            return
        scope = self.model.scope(index)
        where = transform(scope.formula(init.where), lambda p: p.fix(self.params))
        assigned: dict[str, Interval] = {}
        for a in init.assigns:
            if isinstance(a.to, Expr) and not scope.is_truth(a.to):
                assigned[a.var] = image(scope.polynomial(a.to).fix(self.params), {}, {})
        box = {**box, **assigned}
        choices = [_within(x) for x in box.values()]
        for picks in product(*choices):
            values = dict(zip(box, picks, strict=True))
            allowed = holds(where, values) and holds(self.domain(index), values)
            if allowed and holds(self.declared, values):
                yield State(index, values, Q(0))


def _within(x: Interval) -> tuple[Q, ...]:
    low = x.low if x.low is not None else (x.high or Q(0)) - 1 if x.high is not None else Q(0)
    high = x.high if x.high is not None else low + 1
    return _some(low, high)


def _some(low: Q, high: Q) -> tuple[Q, ...]:
    if low > high:
        return ()
    return (low,) if low == high else (low, high, (low + high) / 2)


def stretches(f: Formula, view: Q) -> list[Stretch]:
    """The maximal intervals of [0, view] on which a formula in `t` holds, in order.

    Ends that are no rationals are replaced by rationals inside, so what is returned is never too much.
    """
    if isinstance(f, bool):
        return [Stretch(Q(0), view, True, True)] if f else []
    elements = pieces(f, (Q(0), view))
    found: list[Stretch] = []
    first = 0
    while first < len(elements):
        last = first
        while last < len(elements) and elements[last][1]:
            last += 1
        if last > first:
            low, low_closed = _low_end(elements, first)
            high, high_closed = _high_end(elements, last - 1, view)
            if low < high or (low == high and low_closed and high_closed):
                found.append(Stretch(low, high, low_closed, high_closed))
        first = last + 1
    return found


def _low_end(elements: list[tuple[sturm.Piece, bool]], i: int) -> tuple[Q, bool]:
    piece = elements[i][0]
    if piece.is_root:
        return piece.place.high, True
    if i == 0:
        return Q(0), True
    before = elements[i - 1][0].place
    return before.high, before.low < before.high


def _high_end(elements: list[tuple[sturm.Piece, bool]], i: int, view: Q) -> tuple[Q, bool]:
    piece = elements[i][0]
    if piece.is_root:
        return piece.place.low, True
    if i + 1 == len(elements):
        return view, True
    after = elements[i + 1][0].place
    return after.low, after.low < after.high
