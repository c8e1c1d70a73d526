"""A claim put to many runs: the least margin that a search finds, and the run that has it."""

from __future__ import annotations

from collections.abc import Sequence

from haverify.model.claim import Claim, Goal
from haverify.model.hybrid import HybridAutomaton, Range
from haverify.model.spec import Spec
from haverify.simulate.draws import Draw, Drawing
from haverify.simulate.formula import AskedOfRuns, asked_of_runs
from haverify.simulate.model import SimulatedAutomaton
from haverify.simulate.run import Settings, SimulatedRun, followed, plan_of
from haverify.simulate.search import Found, Point, least
from haverify.text.record import holder, record

CHOICES = 12  # shares for what a run leaves open on its way
OUTSIDE = 1e305  # of a point that is no admissible start
ROUNDING = 1e-9  # a margin nearer to zero is no violation


@record
class Searched:
    """What a search found: the least margin and its run (None where there is no start), and how many runs it took."""

    margin: float
    run: SimulatedRun | None
    runs: int
    found_after: int
    asked: AskedOfRuns

    @property
    def is_violated(self) -> bool:
        """Whether the run violates the claim, as far as floats tell."""
        return self.run is not None and self.margin < -ROUNDING


@holder
class Subject:
    """An automaton under a goal, with a point of the unit cube for each run."""

    model: SimulatedAutomaton
    drawing: Drawing
    asked: AskedOfRuns
    settings: Settings

    @property
    def choices(self) -> int:
        """How many shares go to choices on the way."""
        edges = self.model.automaton.edges
        is_open = any(isinstance(a.to, Range) for e in edges for a in e.resets)
        return CHOICES if is_open or (self.settings.policy == "random" and edges) else 0

    @property
    def dimension(self) -> int:
        """How many coordinates a point has."""
        return self.drawing.dimension + self.choices

    def split(self, point: Point) -> tuple[Draw | None, Point]:
        """The draw that a point stands for, and its shares for choices."""
        own = self.drawing.dimension
        return self.drawing.at(point[:own]), point[own:]

    def values(self, points: Sequence[Point]) -> list[float]:
        """The margins of some points."""
        drawn = [self.split(p) for p in points]
        plans = [plan_of(d, self.settings, given) for d, given in drawn if d is not None]
        found = iter(self.model.kernel.robustness(plans, self.asked.words))
        return [OUTSIDE if d is None else next(found) for d, _ in drawn]

    def run(self, found: Found) -> SimulatedRun | None:
        """The run of a point."""
        draw, given = self.split(found.point)
        return None if draw is None else followed(self.model, draw, self.settings, given)


def subject(
    spec: Spec, automaton: HybridAutomaton, claim: Claim, goal: Goal, until: float, policy: str, seed: int
) -> Subject:
    """A goal made ready for the search.

    Raises
    ------
    OutsideFragmentError    if automaton or goal are outside of what is simulated
    """
    asked = asked_of_runs(spec, automaton, claim, goal, until)
    model = SimulatedAutomaton(spec, automaton, asked.observed, asked.landings)
    jumps = asked.jumps if asked.jumps is not None else 10_000
    settings = Settings(asked.horizon, jumps, policy, seed)
    return Subject(model, Drawing(model, asked.horizon), asked, settings)


def searched(s: Subject, budget: int, seed: int, enough: float = -ROUNDING) -> Searched:
    """Search with a budget of runs."""
    found, runs = least(s.values, s.dimension, budget, seed, enough)
    if found is None or found.value >= OUTSIDE:
        return Searched(OUTSIDE, None, runs, runs, s.asked)
    return Searched(found.value, s.run(found), runs, found.runs, s.asked)
