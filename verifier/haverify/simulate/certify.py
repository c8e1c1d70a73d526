"""A run that floats found, followed again in enclosures: the model narrowed to what the run chose, from a point."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from itertools import pairwise

from haverify.analyses.hybrid.model import hybrid_model
from haverify.analyses.hybrid.question import question_of
from haverify.analyses.hybrid.runs import by_a_run
from haverify.evidence.run import Run
from haverify.maths.interval import Fault
from haverify.model.claim import Claim, Goal
from haverify.model.expression import Expr, number, rebuild
from haverify.model.hybrid import Assign, Edge, FlowLine, HybridAutomaton, Init, Mode, Param, Range
from haverify.obligations.translate import OutsideFragmentError
from haverify.simulate.model import SHARE, SLOPE
from haverify.simulate.run import SimulatedRun
from haverify.text.record import holder, record, replace

TIME = Expr("time")


@record
class Certified:
    """The enclosed run that violates the goal, or why there is none."""

    run: Run | None
    reason: str = ""
    is_close: bool = False  # enclosures exist, but do not tell


def certified(run: SimulatedRun, claim: Claim, goal: Goal) -> Certified:
    """Follow the run again in enclosures."""
    if claim.assume or run.model.spec.assumptions:
        return Certified(None, "assumptions beside a flow that is not clock-driven")
    try:
        narrowing = _Narrowed(run)
        narrowed, asked = narrowing.automaton(), replace(goal, condition=narrowing.everywhere(goal.condition))
        spec = replace(run.model.spec, inputs=(), params=_pinned(run, run.model.spec.params))
        time = claim.time if goal.kind == "reach" or claim.time is not None else number(Fraction(run.time))
        alone = replace(claim, goals=(asked,), using=(), time=time)
        model = hybrid_model(spec, narrowed, [asked.condition])
        found = by_a_run(question_of(model, alone, asked))[1]
    except (OutsideFragmentError, Fault) as e:
        return Certified(None, str(e))
    if found is not None:
        return Certified(found)
    return Certified(None, "its enclosures do not decide the claim", is_close=True)


def _pinned(run: SimulatedRun, params: tuple[Param, ...]) -> tuple[Param, ...]:
    places, state = run.model.places, run.draw.state
    return tuple(replace(p, range=_only(state[places[p.name]])) for p in params)


def _only(x: float) -> Range:
    return Range(number(Fraction(x)), number(Fraction(x)))


@holder
class _Narrowed:
    """A copy of the automaton whose inputs are those of one run: each mode once for each of their pieces."""

    run: SimulatedRun

    def __post_init__(self) -> None:
        self.times = [Fraction(0), *sorted({Fraction(t) for t, _, _ in self.run.draw.writes if t > 0})]

    def automaton(self) -> HybridAutomaton:
        a = self.run.model.automaton
        pieces = range(len(self.times))
        modes = tuple(self._mode(m, k) for k in pieces for m in a.modes)
        edges = [self._edge(e, k) for k in pieces for e in a.edges]
        for k, _ in pairwise(pieces):
            edges += [self._onwards(m, k) for m in a.modes]
        lets = a.lets if len(self.times) == 1 and not self._values(0) else ()
        start = self._start(a)
        params = _pinned(self.run, a.params)
        return replace(a, modes=modes, edges=tuple(edges), lets=lets, init=(start,), params=params, inputs=())

    def _edge(self, e: Edge, k: int) -> Edge:
        resets = tuple(replace(x, to=self._ends(x.to, k)) for x in e.resets)
        source, target = self._name(e.source, k), self._name(e.target, k)
        return replace(e, source=source, target=target, guard=self._put(e.guard, k), resets=resets)

    def everywhere(self, e: Expr) -> Expr:
        """A condition with `at` true in every copy of a mode."""
        if e.op == "at" and len(self.times) > 1:
            return Expr("or", tuple(Expr("at", (self._name(e.name, k),)) for k in range(len(self.times))))
        return rebuild(e, self.everywhere)

    def _start(self, a: HybridAutomaton) -> Init:
        state, places = self.run.draw.state, self.run.model.places
        values = tuple(Assign(v.name, number(Fraction(state[places[v.name]]))) for v in a.vars)
        return Init(self._name(a.modes[self.run.draw.mode].name, 0), Expr("true"), values)

    def _name(self, mode: str, k: int) -> str:
        return mode if len(self.times) == 1 else f"{mode} @{k}"

    def _mode(self, m: Mode, k: int) -> Mode:
        a = self.run.model.automaton
        lets = {o.name: o for o in (*a.lets, *m.lets)}
        kept = m.lets if len(self.times) == 1 and not self._values(0) else tuple(lets.values())
        lets_here = tuple(replace(o, expr=self._put(o.expr, k)) for o in kept)
        flow = tuple(FlowLine(line.var, self._rate(line, k)) for line in m.flow)
        domain = self._put(m.domain, k)
        return replace(m, name=self._name(m.name, k), domain=domain, flow=flow, lets=lets_here)

    def _onwards(self, m: Mode, k: int) -> Edge:
        due = Expr(">=", (TIME, number(self.times[k + 1])))
        return Edge(f"input {k}", self._name(m.name, k), self._name(m.name, k + 1), True, due, ())

    def _rate(self, line: FlowLine, k: int) -> Expr:
        if not isinstance(line.rate, Range):
            return self._put(line.rate, k)
        low, high = self._put(line.rate.low, k), self._put(line.rate.high, k)
        share = number(self._values(k)[SHARE + line.var])
        return Expr("+", (low, Expr("*", (share, Expr("-", (high, low))))))

    def _ends(self, to: Expr | Range, k: int) -> Expr | Range:
        return Range(self._put(to.low, k), self._put(to.high, k)) if isinstance(to, Range) else self._put(to, k)

    def _put(self, e: Expr, k: int) -> Expr:
        """An expression with inputs as they are in one piece, and `at` naming all copies of a mode."""
        if e.op == "input":
            values = self._values(k)
            if SLOPE + e.name not in values:
                return number(values[e.name])
            since = Expr("-", (TIME, number(self.times[k])))
            return Expr("+", (number(values[e.name]), Expr("*", (number(values[SLOPE + e.name]), since))))
        return rebuild(e, lambda c: self._put(c, k))

    def _values(self, k: int) -> Mapping[str, Fraction]:
        """What inputs, slopes and shares are from the time of a piece on; continuous inputs at its start."""
        model, draw = self.run.model, self.run.draw
        names = [*(i.name for i in model.inputs), *(SLOPE + i.name for i in model.inputs if i.rate is not None)]
        names += [SHARE + v for v in model.inclusions]
        found = {n: Fraction(draw.state[model.places[n]]) for n in names}
        last = Fraction(0)
        for t, place, value in sorted(draw.writes):
            if Fraction(t) > self.times[k]:
                break
            self._move(found, Fraction(t) - last)
            last = Fraction(t)
            found[model.names[place]] = Fraction(value)
        self._move(found, self.times[k] - last)
        return found

    def _move(self, values: dict[str, Fraction], by: Fraction) -> None:
        for i in self.run.model.inputs:
            if i.rate is not None:
                values[i.name] += by * values[SLOPE + i.name]
