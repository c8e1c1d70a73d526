"""Periodic orbits in floats near which a proved one is looked for, from runs of the simulator."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from functools import partial
from itertools import pairwise, product

from haverify.analyses.orbits.ranges import Ranges
from haverify.maths.interval import Interval
from haverify.model.expression import Expr, nodes
from haverify.model.hybrid import FlowLine, HybridAutomaton
from haverify.model.spec import Spec
from haverify.obligations.translate import OutsideFragmentError
from haverify.simulate.draws import Draw, Drawing
from haverify.simulate.model import SimulatedAutomaton
from haverify.simulate.orbits import Orbit, orbit_of
from haverify.simulate.run import Settings, SimulatedRun, followed
from haverify.text.record import holder, replace

Q = Fraction
LAPS = (15, 3)  # times the period allowed: how long runs are looked at
DEFAULT = 20.0  # s, where no period is stated
ROOTS = 12  # steps towards a crossing
STEPS = 40_000


@holder
class Guesses:
    """The simulator of an automaton, and what it knows of orbits."""

    spec: Spec
    automaton: HybridAutomaton

    def __post_init__(self) -> None:
        self.model = SimulatedAutomaton(self.spec, self.automaton)

    def orbits(self, longest: Q | None, areas: list[tuple[str, dict[str, float]]]) -> Iterator[Orbit]:
        """Orbits that runs come near to: the usual run, and those from the middle of some areas."""
        period = float(longest) if longest is not None else DEFAULT
        found = list[Orbit]()
        ways = [self, *([Guesses(self.spec, _reversed(self.automaton))] if not self.automaton.edges else [])]
        for start, laps, way in product((*areas, None), LAPS, ways):
            orbit = way.near(start, laps * period)
            if orbit is not None and not any(_is_same(orbit, o) for o in found):
                found.append(orbit)
                yield orbit if way is self else self._again(orbit)

    def near(self, start: tuple[str, dict[str, float]] | None, until: float) -> Orbit | None:
        """An orbit that a run is near to at last, if there is one."""
        import numpy as np

        try:
            draw = Drawing(self.model, until).nominal() if start is None else self.draw(*start)
            with np.errstate(all="ignore"):
                return orbit_of(followed(self.model, draw, Settings(until, steps=STEPS)))
        except (OutsideFragmentError, np.linalg.LinAlgError):
            return None

    def _again(self, orbit: Orbit) -> Orbit:
        """An orbit that was followed backwards, as one of this automaton."""
        state = dict(zip(self.model.names, orbit.state, strict=True))
        return replace(orbit, run=self.run(self.model.automaton.modes[orbit.mode].name, state, orbit.period))

    def draw(self, mode: str, state: dict[str, float]) -> Draw:
        """The draw of a state."""
        usual = {p.name: float(sum(self.model.values.interval(p.range)) / 2) for p in self.model.params}
        values = {**usual, **state}
        return Draw(self.model.mode(mode), [values.get(n, 0.0) for n in self.model.names], [])

    def run(self, mode: str, state: dict[str, float], until: float) -> SimulatedRun:
        """The run from a state."""
        return followed(self.model, self.draw(mode, state), Settings(until, steps=STEPS))

    def crossings(
        self, run: SimulatedRun, mode: str, quantity: Expr, samples: int
    ) -> Iterator[tuple[float, dict[str, float]]]:
        """Instants and states of a run at which a quantity crosses zero in a mode, those between samples."""
        number, names = self.model.mode(mode), {n.name for n in nodes(quantity) if n.op in ("var", "param", "time")}
        value = partial(self._value, quantity, [k for k, n in enumerate(self.model.names) if n in names])
        rows = run.rows([run.time * k / samples for k in range(samples + 1)])
        for (t, m, jumps, state, _), (u, n, others, later, _) in pairwise(rows):
            if m == n == number and jumps == others and u > t:
                a, b = value(state), value(later)
                if a != 0 and (b == 0 or (a < 0) is not (b < 0)):
                    at, there = self._root(run, (t, a), (u, b), value)
                    yield at, dict(zip(self.model.names, there, strict=True))

    def _root(
        self,
        run: SimulatedRun,
        low: tuple[float, float],
        high: tuple[float, float],
        value: Callable[[list[float]], float],
    ) -> tuple[float, list[float]]:
        """Near the instant between two at which a value is zero, by secants and halves in turn."""
        state = list[float]()
        at = low[0]
        for k in range(ROOTS):
            share = 0.5 if k % 3 == 2 else low[1] / (low[1] - high[1])
            at = low[0] + share * (high[0] - low[0])
            state = min(run.rows([at]), key=lambda row: abs(row[0] - at))[3]
            found = value(state)
            if found == 0:
                break
            if (found < 0) is (low[1] < 0):
                low = at, found
            else:
                high = at, found
        return at, state

    def _value(self, quantity: Expr, read: Sequence[int], state: list[float]) -> float:
        box = {self.model.names[k]: Interval.at(state[k]) for k in read}
        return Ranges(box, {}).of(quantity).midpoint


def _reversed(automaton: HybridAutomaton) -> HybridAutomaton:
    """The automaton with its runs backwards: orbits that repel attract."""

    def back(line: FlowLine) -> FlowLine:
        return replace(line, rate=Expr("neg", (line.rate,))) if isinstance(line.rate, Expr) else line

    return replace(automaton, modes=tuple(replace(m, flow=tuple(map(back, m.flow))) for m in automaton.modes))


def _is_same(a: Orbit, b: Orbit) -> bool:
    return a.jumps == b.jumps and abs(a.period - b.period) < 1e-9 * a.period
