"""A periodic orbit that is proved: from one in floats to a fixed point of the return map, and where it passes P."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from itertools import islice

from haverify.analyses.hybrid.model import HybridModel
from haverify.analyses.orbits.guesses import Guesses
from haverify.analyses.orbits.laps import Cut, Frame, guard_atoms, written_out
from haverify.analyses.orbits.linear import basis_of, inverse
from haverify.analyses.orbits.newton import Fixed, Search
from haverify.analyses.orbits.passing import Crossed, Section, passes_crossing, passes_landing
from haverify.analyses.orbits.ranges import Ranges
from haverify.analyses.orbits.returns import Box, Track, finely
from haverify.maths.interval import Interval
from haverify.model.expression import Expr, number
from haverify.simulate.orbits import Orbit
from haverify.text.record import holder, record

Q = Fraction
LATE = 0.05  # of the lap before its end: the section counts from then on
EARLY = (0.1, 0.02, 0.002)  # of the lap before the orbit comes to P
MOST = 6  # crossings that are tried
SAMPLES = 400  # of a lap


@record
class Passed:
    """Where all runs of a lap pass P: the section, states in it, instants since the start of the lap."""

    section: Section
    state: Box
    time: Interval


@holder
class Plane:
    """The section of a return map: where a variable has a value, in a mode, on an orbit in floats."""

    model: HybridModel
    guesses: Guesses
    orbit: Orbit

    def __post_init__(self) -> None:
        orbit, simulated = self.orbit, self.guesses.model
        self.mode = simulated.automaton.modes[orbit.mode].name
        self.names = tuple(v.name for v in self.model.automaton.vars)
        rates = simulated.kernel.slopes(orbit.mode, list(orbit.state))
        states = [row[3] for row in orbit.run.rows([orbit.period * k / 100 for k in range(101)])]
        wide = [max(s[k] for s in states) - min(s[k] for s in states) for k in range(len(self.names))]
        self.sizes = {v: w or 1.0 for v, w in zip(self.names, wide, strict=True)}
        across = max(range(len(self.names)), key=lambda k: abs(rates[k]) / self.sizes[self.names[k]])
        self.variable, self.value = self.names[across], orbit.state[across]
        self.columns = tuple(v for v in self.names if v != self.variable)
        self.centre = dict(zip(self.names, orbit.state, strict=False))
        params = self.model.names[len(self.names) : -1]
        ranges = {p.name: self.model.values.interval(p.range) for p in simulated.params}
        self.given = {self.variable: Interval.at(self.value)}
        self.given |= {p: Interval.between(*ranges[p]) for p in params}
        self.size = max(abs(x) for s in states for x in s[: len(self.names)])

    @property
    def quantity(self) -> Expr:
        """What is zero on the section."""
        return Expr("-", (Expr("var", (self.variable,)), number(Q(self.value))))

    def track(self, frame: Frame | None = None) -> Track:
        """The way from the section around the orbit, with derivatives; in coordinates where there is a frame."""
        period, last = self.orbit.period, max((j[0] for j in self.orbit.run.jumps), default=0.0)
        after = max(last + (period - last) / 2, period * (1 - LATE))
        borders = dict(self.borders())
        cut = Cut(self.mode, self.mode, self.quantity, Q(after), self.columns, borders, frame, frame)
        return Track(self.model, cut, period, self.size)

    def frame(self, slopes: list[list[float]], centre: Mapping[str, float]) -> Frame | None:
        """Coordinates around a state in which a derivative of the return map is near to numbers and turns."""
        basis = [[Q(x) for x in row] for row in basis_of(slopes, [self.sizes[v] for v in self.columns])]
        back = inverse(basis)
        if back is None:
            return None
        rounded = tuple(tuple(Q(float(q)) for q in row) for row in back)
        middle = {v: Q(centre[v]) for v in self.columns}
        return Frame(middle, tuple(map(tuple, basis)), rounded, {self.variable: Q(self.value)})

    def borders(self) -> Iterator[tuple[int, Expr]]:
        """The quantity that is zero where each edge on the way is taken."""
        names = self.guesses.model.names
        for _, edge, before, _ in self.orbit.run.jumps:
            of = self.model.automaton.edges[edge]
            box = {n: Interval.at(x) for n, x in zip(names, before, strict=True)}
            here = Ranges(box, self.model.definitions[self.model.mode(of.source)])
            atoms = [a for a in guard_atoms(self.model, of) if a.op != "!="]
            nearest = min(atoms, key=lambda a: (a.op != "==", abs(here.of(a.quantity)).high), default=None)
            if nearest is not None:
                yield edge, nearest.quantity

    def fixed(self) -> Fixed | None:
        """The orbit, proved."""
        search = Search(self.track(), self.columns, self.given, [self.sizes[v] for v in self.columns])
        return search.fixed([self.centre[v] for v in self.columns])

    def passed(self, sections: list[Section], box: Box) -> Passed | None:
        """Where all runs from a box of the section pass P; None if that is not certain."""
        start = {**self.given, **box}
        settings = finely(self.given, self.orbit.period, self.size)
        landings = None
        for s in sections:
            if isinstance(s, Crossed):
                found = self._crossing(s, start)
                if found is not None:
                    return found
                continue
            if landings is None:
                lap = self._plain().lap(start, settings)
                landings = () if lap is None else lap.landings
            for j in landings:
                if passes_landing(self.model, s, j):
                    return Passed(s, j.after, j.time)
        return None

    def _plain(self) -> Track:
        cut = self.track().cut
        return Track(self.model, Cut(cut.start, cut.end, cut.quantity, cut.after), self.orbit.period, self.size)

    def written(self, section: Crossed) -> Expr:
        """The quantity of a section, without lets and constants."""
        known = self.model.definitions[self.model.mode(section.mode)]
        return written_out(section.quantity, known)

    def _crossing(self, section: Crossed, start: Box) -> Passed | None:
        period = self.orbit.period
        run = self.guesses.run(self.mode, self.centre, 1.1 * period)
        quantity = self.written(section)
        for t, _ in islice(self.guesses.crossings(run, section.mode, quantity, SAMPLES), MOST):
            for early in EARLY:
                if t <= early * period:
                    continue
                cut = Cut(self.mode, section.mode, section.quantity, Q(t - early * period))
                track = Track(self.model, cut, t + 0.2 * period, self.size)
                lap = track.lap(start, finely(self.given, period, self.size))
                if lap is not None and passes_crossing(self.model, section, lap.state, lap.time):
                    return Passed(section, lap.state, lap.time)
        return None
