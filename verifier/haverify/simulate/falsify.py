"""A claim put to many runs: the least margin that a search finds, and the run that has it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from time import process_time

from haverify.model.claim import Claim, Goal
from haverify.model.hybrid import HybridAutomaton, Range
from haverify.model.spec import Spec
from haverify.simulate.draws import Draw, Drawing
from haverify.simulate.formula import AskedOfRuns, asked_of_runs
from haverify.simulate.model import SimulatedAutomaton
from haverify.simulate.run import Settings, SimulatedRun, followed, plan_of
from haverify.simulate.search import Found, Point, least
from haverify.text.record import holder, record, replace

ANY = "any"  # policy: the search chooses among all of them
POLICIES = ("earliest", "latest", "random")
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
    is_stopped: bool = False  # the time was over before the budget of runs

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
    def waits(self) -> bool:
        """Whether a run may wait with some edge."""
        return any(not e.urgent for e in self.model.automaton.edges)

    @property
    def choices(self) -> int:
        """How many shares go to choices on the way, the first to the policy where the search chooses it."""
        chooses = self.settings.policy == ANY and self.waits
        is_open = any(isinstance(a.to, Range) for e in self.model.automaton.edges for a in e.resets)
        is_random = self.settings.policy == "random" and self.waits
        return chooses + (CHOICES if is_open or is_random or chooses else 0)

    @property
    def dimension(self) -> int:
        """How many coordinates a point has."""
        return self.drawing.dimension + self.choices

    def split(self, point: Point) -> tuple[Draw | None, Settings, Point]:
        """The draw that a point stands for, how its run is followed, and its shares for choices."""
        own = self.drawing.dimension
        draw, settings, given = self.drawing.at(point[:own]), self.settings, point[own:]
        if settings.policy == ANY:
            policy = POLICIES[0]
            if self.waits:
                policy, given = POLICIES[min(int(given[0] * len(POLICIES)), len(POLICIES) - 1)], given[1:]
            settings = replace(settings, policy=policy)
        return draw, settings, given

    def values(self, points: Sequence[Point]) -> list[float]:
        """The margins of some points."""
        drawn = [self.split(p) for p in points]
        plans = [plan_of(d, settings, given) for d, settings, given in drawn if d is not None]
        found = iter(self.model.kernel.robustness(plans, self.asked.words))
        return [OUTSIDE if d is None else next(found) for d, _, _ in drawn]

    def run(self, found: Found) -> SimulatedRun | None:
        """The run of a point."""
        draw, settings, given = self.split(found.point)
        return None if draw is None else followed(self.model, draw, settings, given)


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


def searched(s: Subject, budget: int, seed: int, enough: float = -ROUNDING, end: float = math.inf) -> Searched:
    """Search with a budget of runs, until a time of the processor (s)."""
    found, runs = least(s.values, s.dimension, budget, seed, enough, end)
    is_stopped = runs < budget and process_time() >= end
    if found is None or found.value >= OUTSIDE:
        return Searched(OUTSIDE, None, runs, runs, s.asked, is_stopped)
    return Searched(found.value, s.run(found), runs, found.runs, s.asked, is_stopped)
