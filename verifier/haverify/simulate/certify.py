"""A run that floats found, followed again in enclosures: the model narrowed to what the run chose, from a point."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
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
COPIES = 3000  # of modes
SHIFT = Fraction(1, 10**6)  # s; at the instant itself the guard may just come to hold


@record
class Certified:
    """The enclosed run that violates the goal, or why there is none."""

    run: Run | None
    reason: str = ""
    is_close: bool = False  # enclosures exist, but do not tell


def certified(run: SimulatedRun, claim: Claim, goal: Goal) -> Certified:
    """Follow the run again in enclosures, jumps that might have waited a little later, else a little earlier."""
    if claim.assume or run.model.spec.assumptions:
        return Certified(None, "assumptions beside a flow that is not clock-driven")
    waits = any(not run.model.automaton.edges[number_of].urgent for _, number_of, _, _ in run.jumps)
    found = Certified(None)
    for shift in (SHIFT, -SHIFT) if waits else (Fraction(0),):
        try:
            found = _followed(_Narrowed(run, shift), claim, goal)
        except (OutsideFragmentError, Fault) as e:
            return Certified(None, str(e))
        if found.run is not None:
            break
    return found


def _followed(narrowing: _Narrowed, claim: Claim, goal: Goal) -> Certified:
    run = narrowing.run
    narrowed, asked = narrowing.automaton(), replace(goal, condition=narrowing.everywhere(goal.condition))
    spec = replace(run.model.spec, inputs=(), params=_pinned(run, run.model.spec.params))
    time = claim.time if goal.kind == "reach" or claim.time is not None else number(Fraction(run.time))
    alone = replace(claim, goals=(asked,), using=(), time=time)
    model = hybrid_model(spec, narrowed, [asked.condition])
    found = by_a_run(question_of(model, alone, asked))[1]
    if found is not None:
        return Certified(found)
    return Certified(None, "its enclosures do not decide the claim", is_close=True)


def _pinned(run: SimulatedRun, params: tuple[Param, ...]) -> tuple[Param, ...]:
    places, state = run.model.places, run.draw.state
    return tuple(replace(p, range=_only(state[places[p.name]])) for p in params)


def _only(x: float) -> Range:
    return Range(number(Fraction(x)), number(Fraction(x)))


def _share(low: float, high: float, value: float) -> Fraction:
    """Where between two ends a value is, as a number that never leads beyond them."""
    return min(max(Fraction((value - low) / (high - low)), Fraction(0)), Fraction(1)) if high > low else Fraction(0)


@record
class _Chosen:
    """A jump at which a run had a choice: its edge, when, and the shares of the ways between its resets' ends."""

    edge: int
    time: Fraction
    shares: Mapping[str, Fraction]


@holder
class _Narrowed:
    """A copy of the automaton in which everything is as one run chose it.

    Each mode is there once for each piece of the inputs and once for each choice that is still ahead. An edge that may
    wait is urgent from about the instant on at which the run took it, and not there before; a reset that chooses has a
    fixed share of the way between its ends. So each run of the copy is one of the model.
    """

    run: SimulatedRun
    shift: Fraction = Fraction(0)

    def __post_init__(self) -> None:
        self.times = [Fraction(0), *sorted({Fraction(t) for t, _, _ in self.run.draw.writes if t > 0})]
        self.chosen = list(self._choices())
        if len(self.times) * (len(self.chosen) + 1) * len(self.run.model.automaton.modes) > COPIES:
            raise OutsideFragmentError(f"more than {COPIES} modes of one run: inputs or choices change too often")

    def automaton(self) -> HybridAutomaton:
        a = self.run.model.automaton
        pieces, stages = range(len(self.times)), range(len(self.chosen) + 1)
        modes = tuple(self._mode(m, k, s) for k in pieces for s in stages for m in a.modes)
        edges = [
            x for k in pieces for s in stages for i in range(len(a.edges)) if (x := self._edge(i, k, s)) is not None
        ]
        edges += [self._onwards(m, k, s) for k, _ in pairwise(pieces) for s in stages for m in a.modes]
        lets = a.lets if len(self.times) == 1 and not self._values(0) else ()
        start = self._start(a)
        params = _pinned(self.run, a.params)
        return replace(a, modes=modes, edges=tuple(edges), lets=lets, init=(start,), params=params, inputs=())

    def _choices(self) -> Iterator[_Chosen]:
        """The jumps that could have been others."""
        model = self.run.model
        for time, number_of, before, after in self.run.jumps:
            edge = model.automaton.edges[number_of]
            open_ends = [a for a in edge.resets if isinstance(a.to, Range)]
            if edge.urgent and not open_ends:
                continue
            registers = {v: (low, high) for v, low, high in self._ends_of(number_of)}
            values = model.kernel.values(model.mode(edge.source), before)
            shares = {}
            for a in open_ends:
                low, high = registers[model.places[a.var]]
                shares[a.var] = _share(values[low], values[high], after[model.places[a.var]])
            yield _Chosen(number_of, Fraction(time) + self.shift, shares)

    def _ends_of(self, edge: int) -> Iterator[tuple[int, int, int]]:
        for v, low, high in self.run.model.resets[edge]:
            if high is not None:
                yield v, low, high

    def _edge(self, number_of: int, k: int, s: int) -> Edge | None:
        """An edge among copies; None where the run takes another one than this, which may wait."""
        e = self.run.model.automaton.edges[number_of]
        next_one = self.chosen[s] if s < len(self.chosen) else None
        is_next = next_one is not None and next_one.edge == number_of
        if not e.urgent and not is_next:
            return None
        shares = next_one.shares if next_one is not None and is_next else {}
        guard = self._put(e.guard, k)
        if next_one is not None and not e.urgent:
            guard = Expr("and", (guard, Expr(">=", (TIME, number(next_one.time)))))
        resets = tuple(replace(x, to=self._fixed(x, shares, k)) for x in e.resets)
        source, target = self._name(e.source, k, s), self._name(e.target, k, s + is_next)
        return replace(e, source=source, target=target, urgent=True, guard=guard, resets=resets)

    def _fixed(self, a: Assign, shares: Mapping[str, Fraction], k: int) -> Expr:
        """What a reset leads to, the middle where the run never took it."""
        if not isinstance(a.to, Range):
            return self._put(a.to, k)
        low, high = self._put(a.to.low, k), self._put(a.to.high, k)
        share = number(shares.get(a.var, Fraction(1, 2)))
        return Expr("+", (low, Expr("*", (share, Expr("-", (high, low))))))

    def everywhere(self, e: Expr) -> Expr:
        """A condition with `at` true in every copy of a mode."""
        if e.op == "at" and self._is_copied:
            copies = [(k, s) for k in range(len(self.times)) for s in range(len(self.chosen) + 1)]
            return Expr("or", tuple(Expr("at", (self._name(e.name, k, s),)) for k, s in copies))
        return rebuild(e, self.everywhere)

    @property
    def _is_copied(self) -> bool:
        return len(self.times) > 1 or bool(self.chosen)

    def _start(self, a: HybridAutomaton) -> Init:
        state, places = self.run.draw.state, self.run.model.places
        values = tuple(Assign(v.name, number(Fraction(state[places[v.name]]))) for v in a.vars)
        return Init(self._name(a.modes[self.run.draw.mode].name, 0, 0), Expr("true"), values)

    def _name(self, mode: str, k: int, s: int) -> str:
        return f"{mode} @{k}.{s}" if self._is_copied else mode

    def _mode(self, m: Mode, k: int, s: int) -> Mode:
        a = self.run.model.automaton
        lets = {o.name: o for o in (*a.lets, *m.lets)}
        kept = m.lets if len(self.times) == 1 and not self._values(0) else tuple(lets.values())
        lets_here = tuple(replace(o, expr=self._put(o.expr, k)) for o in kept)
        flow = tuple(FlowLine(line.var, self._rate(line, k)) for line in m.flow)
        domain = self._put(m.domain, k)
        return replace(m, name=self._name(m.name, k, s), domain=domain, flow=flow, lets=lets_here)

    def _onwards(self, m: Mode, k: int, s: int) -> Edge:
        due = Expr(">=", (TIME, number(self.times[k + 1])))
        return Edge(f"input {k}", self._name(m.name, k, s), self._name(m.name, k + 1, s), True, due, ())

    def _rate(self, line: FlowLine, k: int) -> Expr:
        if not isinstance(line.rate, Range):
            return self._put(line.rate, k)
        low, high = self._put(line.rate.low, k), self._put(line.rate.high, k)
        share = number(self._values(k)[SHARE + line.var])
        return Expr("+", (low, Expr("*", (share, Expr("-", (high, low))))))

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
