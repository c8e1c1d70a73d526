"""Where runs start and what is chosen for them: params, inputs, start states, from shares between 0 and 1."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction

from haverify.analyses.hybrid.conditions import COMPARISONS, MIRRORED, members
from haverify.model.expression import Expr
from haverify.model.hybrid import Input
from haverify.obligations.constants import Values
from haverify.obligations.translate import OutsideFragmentError
from haverify.simulate.approximate import approximate, ends_of
from haverify.simulate.compile import holds
from haverify.simulate.model import SHARE, SLOPE, SimulatedAutomaton, Starting
from haverify.text.record import holder, record

Share = Callable[[], float]
Ends = tuple[float, float]

TRIES = 4000
PARTS = 10  # of the horizon in which an input has one value, where the model does not say


@record
class Draw:
    """A start: mode, state, and what inputs do later."""

    mode: int
    state: list[float]
    writes: list[tuple[float, int, float]]


@holder
class Drawing:
    """Draws for one automaton up to a horizon (s)."""

    model: SimulatedAutomaton
    horizon: float

    def __post_init__(self) -> None:
        values = self.model.values
        self.params = [(p, ends_of(values, p.range, f"`{p.name}`")) for p in self.model.params]
        self.inputs = [(i, *self._input(i)) for i in self.model.inputs]
        self.boxes = [self._box(s) for s in self.model.starts]

    def nominal(self) -> Draw:
        """Params at their defaults, everything else in the middle; where that is no start, one by chance."""
        middle = self._drawn(lambda: 0.5, 1, is_nominal=True)
        return middle or self.random(_halton())

    def random(self, share: Share) -> Draw:
        """A draw by shares.

        Raises
        ------
        OutsideFragmentError    if no admissible start was found
        """
        found = self._drawn(share, TRIES, is_nominal=False)
        if found is None:
            raise OutsideFragmentError("no start was found that the init lines and domains allow")
        return found

    def corner(self, share: Share) -> Draw:
        """A draw at ends of ranges."""

        def at_end() -> float:
            return float(share() < 0.5)

        return self._drawn(at_end, 50, is_nominal=False) or self.random(share)

    @property
    def dimension(self) -> int:
        """How many shares a draw takes at most."""
        held = len(self.params) + len(self.inputs) + len(self.model.inclusions)
        start = max((len(b) + len(s.assigned) for b, s in zip(self.boxes, self.model.starts, strict=True)), default=0)
        inputs = [PARTS if rates is not None else len(self._times(every)) for _, _, rates, every in self.inputs]
        return 1 + held + start + sum(inputs) + len(self.model.inclusions) * len(self._times(None))

    def at(self, shares: Sequence[float]) -> Draw | None:
        """The draw that shares stand for; None where it is no admissible start."""
        waiting = iter(shares)
        return self._drawn(lambda: next(waiting, 0.5), 1, is_nominal=False)

    def _drawn(self, share: Share, tries: int, is_nominal: bool) -> Draw | None:
        for k in range(tries):
            lines = self.model.starts
            start = lines[min(int(share() * len(lines)), len(lines) - 1)] if not is_nominal else None
            for chosen in (start,) if start else lines:
                state = self._state(chosen, share, is_nominal)
                if state is not None:
                    return Draw(chosen.mode, state, self._writes(state, share, is_nominal and k == 0))
        return None

    def _state(self, start: Starting, share: Share, is_nominal: bool) -> list[float] | None:
        model = self.model
        state = [0.0] * len(model.names)
        for p, ends in self.params:
            value = between(ends, share())
            if is_nominal and p.default is not None:
                value = float(approximate(model.values, p.default))
            state[model.places[p.name]] = value
        for i, ends, _, _ in self.inputs:
            state[model.places[i.name]] = between(ends, share())
        for v in model.inclusions:
            state[model.places[SHARE + v]] = share()
        for v, ends in self.boxes[model.starts.index(start)].items():
            state[model.places[v]] = between(ends, share())
        values = model.kernel.values(start.mode, state)
        for v, low, high in start.assigned:
            state[model.places[v]] = between((values[low], values[high]), share())
        values = model.kernel.values(start.mode, state)
        return state if holds(start.condition, values) else None

    def _writes(self, state: list[float], share: Share, is_still: bool) -> list[tuple[float, int, float]]:
        """What inputs and shares of inclusions do: one value after the other, or slopes of continuous inputs."""
        if is_still:
            return []
        found = []
        for i, ends, rates, every in self.inputs:
            place = self.model.places[i.name]
            if rates is None:
                found += [(t, place, between(ends, share())) for t in self._times(every)]
            else:
                found += self._slopes(i, ends, rates, state[place], share)
        for v in self.model.inclusions:
            place = self.model.places[SHARE + v]
            found += [(t, place, share()) for t in self._times(None)]
        return sorted(found)

    def _times(self, every: float | None) -> list[float]:
        step = every if every is not None else self.horizon / PARTS
        count = min(int(self.horizon / step + 1e-9), 100_000) if step > 0 else 0
        return [k * step for k in range(1, count + 1) if k * step < self.horizon]

    def _slopes(
        self, i: Input, ends: Ends, rates: Ends, value: float, share: Share
    ) -> Iterator[tuple[float, int, float]]:
        """Straight pieces that keep to the range and to the range of slopes."""
        step = self.horizon / PARTS
        place = self.model.places[SLOPE + i.name]
        for k in range(PARTS):
            target = min(max(between(ends, share()), value + rates[0] * step), value + rates[1] * step)
            yield k * step, place, (target - value) / step
            value = target

    def _input(self, i: Input) -> tuple[Ends, Ends | None, float | None]:
        values = self.model.values
        if i.range is None:
            raise OutsideFragmentError(f"the input `{i.name}` is bound by nothing here")
        rate = None if i.rate is None else ends_of(values, i.rate, f"the slope of `{i.name}`")
        every = None if i.every is None else float(approximate(values, i.every))
        return ends_of(values, i.range, f"`{i.name}`"), rate, every

    def _box(self, start: Starting) -> dict[str, Ends]:
        """Bounds of the variables that the init line does not assign."""
        model, automaton = self.model, self.model.automaton
        init, mode = automaton.init[start.line], automaton.modes[start.mode]
        assigned = {v for v, _, _ in start.assigned}
        stated: dict[str, list[Fraction | None]] = {v.name: [None, None] for v in automaton.vars}
        for e in (*members(init.where), *members(mode.domain)):
            _note(e, stated, model.values)
        found = {}
        for v in automaton.vars:
            if v.name in assigned:
                continue
            low, high = stated[v.name]
            wide = self._type(v.type) if v.type != "real" else None
            if v.range is not None:
                wide = ends_of(model.values, v.range, f"`{v.name}`")
            first = float(low) if low is not None else wide[0] if wide else None
            last = float(high) if high is not None else wide[1] if wide else None
            if first is None or last is None:
                raise OutsideFragmentError(f"the start leaves `{v.name}` without a bound")
            found[v.name] = first, last
        return found

    def _type(self, kind: str) -> Ends:
        if kind == "bool":
            return 0.0, 1.0
        numbers = self.model.values.positions[kind].values()
        return float(min(numbers)), float(max(numbers))


def between(ends: Ends, share: float) -> float:
    """The number that a share of the way leads to; the ends exactly."""
    low, high = ends
    return low if share <= 0 else high if share >= 1 else low + share * (high - low)


def _halton() -> Share:
    """Shares that fill the unit interval evenly."""
    index = 0

    def share() -> float:
        nonlocal index
        index += 1
        return index * 0.6180339887498949 % 1.0

    return share


def _note(e: Expr, stated: dict[str, list[Fraction | None]], values: Values) -> None:
    """Take down what a conjunct says about one variable."""
    if e.op not in COMPARISONS or e.op == "!=":
        return
    left, right = e.children
    for a, b, op in ((left, right, e.op), (right, left, MIRRORED[e.op])):
        inner = a.children[0] if a.op == "abs" else a
        if inner.op != "var":
            continue
        try:
            bound = approximate(values, b)
        except OutsideFragmentError:
            continue
        if op in ("<", "<=", "=="):
            _narrow(stated[inner.name], 1, bound)
        if op in (">", ">=", "==") and a.op != "abs":
            _narrow(stated[inner.name], 0, bound)
        if a.op == "abs" and op in ("<", "<="):
            _narrow(stated[inner.name], 0, -bound)


def _narrow(ends: list[Fraction | None], side: int, bound: Fraction) -> None:
    known = ends[side]
    ends[side] = bound if known is None else min(known, bound) if side else max(known, bound)
