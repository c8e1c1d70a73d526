"""Runs beside a proof: random and corner runs have to keep the claim and stay inside the flowpipe that was found.

A run in floats is no judge. What lies outside by more than rounding is followed again in enclosures, and only what
these confirm says that two engines disagree.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from fractions import Fraction
from time import process_time
from typing import Any

from haverify.analyses.hybrid.drawing import jumps_of
from haverify.analyses.hybrid.model import HybridModel, hybrid_model
from haverify.analyses.hybrid.question import Question, question_of, settings_of, sides
from haverify.maths.interval import Fault
from haverify.model.claim import Claim
from haverify.model.hybrid import HybridAutomaton
from haverify.model.spec import Spec
from haverify.obligations.translate import OutsideFragmentError
from haverify.simulate.certify import certified
from haverify.simulate.draws import Drawing
from haverify.simulate.formula import AskedOfRuns, asked_of_runs
from haverify.simulate.model import SimulatedAutomaton
from haverify.simulate.run import Settings, SimulatedRun, followed
from haverify.solvers.kernel import Budget, reach
from haverify.text.record import holder, record, replace

Json = Any

DRAWN = 60  # pieces of a drawn flowpipe; where there are as many, some may be missing
DIGITS = 5.1e-6  # to which its numbers are rounded, of their size: six digits are off by 5e-6 of it at most
ERROR = 1e-8  # of a state may be due to floats
LOOKS = 3  # instants of each step of a run
TINY = 4e-5  # of a run's time is a step of the enclosures that confirm
STEPS = 50_000
JUMPS = 400
MARGIN = -1e-7  # a margin nearer to zero is no violation


@record
class Disagreement:
    """What a run shows against a proof; `is_certain` where enclosures confirm it."""

    text: str
    is_certain: bool


@record
class Instant:
    """A state on a run that lies outside."""

    time: float
    mode: str
    jumps: int
    values: dict[str, float]


@holder
class Beside:
    """A claim on an automaton with the flowpipe that shows it (None: it was shown otherwise)."""

    spec: Spec
    automaton: HybridAutomaton
    claim: Claim
    flowpipe: Json = None
    checked: int = 0

    def __post_init__(self) -> None:
        goal = self.claim.goals[0]
        self.asked: AskedOfRuns = asked_of_runs(self.spec, self.automaton, self.claim, goal, 10.0)
        self.model = SimulatedAutomaton(self.spec, self.automaton, self.asked.observed, self.asked.landings)
        self.drawing = Drawing(self.model, self.asked.horizon)

    def disagreement(self, seconds: float, runs: int = 1000, seed: int = 0) -> Disagreement | None:
        """The first one that runs show, until their number or the time (s of the processor) is used up."""
        end = process_time() + seconds
        chance = random.Random(seed)
        for k in range(runs):
            if process_time() >= end:
                return None
            draw = self.drawing.corner(chance.random) if k % 2 else self.drawing.random(chance.random)
            jumps = self.asked.jumps if self.asked.jumps is not None else 200
            run = followed(self.model, draw, Settings(self.asked.horizon, jumps, "random", seed + k))
            self.checked += 1
            found = self._of(run)
            if found is not None:
                return found
        return None

    def _of(self, run: SimulatedRun) -> Disagreement | None:
        if self.asked.assumed and run.record.robustness(self.asked.assumed) < 0:
            return None  # a run that the proof does not speak of
        margin = run.record.robustness(self.asked.words)
        if margin < MARGIN * self._size(run):
            confirmed = certified(run, self.claim, self.claim.goals[0]).run is not None
            return Disagreement(f"a simulated run violates the claim by {-margin:.6g}", confirmed)
        outside = max(self._outside(run), key=self._excess, default=None)
        if outside is None:
            return None
        text = f"a simulated run leaves the flowpipe at t = {outside.time:.6g} s in {outside.mode}"
        return Disagreement(text, self._is_confirmed(run, outside))

    def _size(self, run: SimulatedRun) -> float:
        return max(1.0, *(abs(x) for x in run.state)) if run.state else 1.0

    def _outside(self, run: SimulatedRun) -> Iterator[Instant]:
        """The looked-at instants of a run that lie outside of the flowpipe."""
        if self.flowpipe is None or len(self.flowpipe["pieces"]) >= DRAWN or self.claim.goals[0].kind == "reach":
            return
        last = max((step[1] for p in self.flowpipe["pieces"] for step in p["steps"]), default=0.0)
        pieces = run.record.pieces()
        times = [start + length * k / LOOKS for _, _, start, length, _, _ in pieces for k in range(LOOKS)]
        for t, mode, jumps, state, _ in run.record.sample([t for t in times if t <= last]):
            named = dict(zip(self.model.names, state, strict=True))
            at = Instant(t, self.automaton.modes[mode].name, jumps, named)
            if t <= last and not self._covers(at):
                yield at

    def _covers(self, at: Instant) -> bool:
        """Whether some step of the flowpipe contains an instant, but for rounding of both."""
        return any(_is_in(self.flowpipe["names"], box, at, ERROR) for box in self._boxes(at))

    def _excess(self, at: Instant) -> float:
        """How far an instant is from the nearest box: from the farthest one can tell best whether it is outside."""
        names = self.flowpipe["names"]
        return min((_beyond(names, box, at) for box in self._boxes(at)), default=float("inf"))

    def _boxes(self, at: Instant) -> Iterator[list[float]]:
        """The boxes of the flowpipe at the time, in the mode and after the jumps of an instant."""
        slack = 2 * DIGITS * (abs(at.time) + 1e-3)
        for piece in self.flowpipe["pieces"]:
            if piece["mode"] == at.mode and piece["jumps"] == at.jumps:
                yield from (s[2:] for s in piece["steps"] if s[0] - slack <= at.time <= s[1] + slack)

    def _is_confirmed(self, run: SimulatedRun, at: Instant) -> bool:
        """Whether an enclosure of the one run, too, lies outside of every box of the flowpipe there."""
        try:
            model = hybrid_model(self.spec, self.automaton, [g.condition for g in self.claim.goals])
            question = question_of(model, self.claim, self.claim.goals[0])
            boxes = list(_enclosures(model, question, run, at))
        except (OutsideFragmentError, Fault):
            return False
        names = self.flowpipe["names"]
        return bool(boxes) and all(_is_apart(names, box, x) for box in self._boxes(at) for x in boxes)


def _enclosures(model: HybridModel, question: Question, run: SimulatedRun, at: Instant) -> Iterator[dict[str, Any]]:
    """What contains the run from the same start at an instant."""
    places, state = run.model.places, run.draw.state
    for start in model.starts:
        if model.places[start.mode].mode != run.model.automaton.modes[run.draw.mode].name:
            continue
        box = tuple((Fraction(state[places[n]]), Fraction(state[places[n]])) for n in model.names)
        step = TINY * max(run.time, 1e-9)
        horizon = max(at.time, step) * (1 + 1e-9) + 1e-12
        settings = replace(settings_of(question, box, is_finer=True), longest=step, first=step, steps=STEPS)
        given = start.mode, sides(box), list[tuple[int, str]]()
        most = at.jumps + 1 + (JUMPS if None in model.origins else 0)
        tree = reach(question.modes, given, horizon, "horizon", settings, Budget(most, JUMPS, 0))
        for s, jumps in zip(tree, jumps_of(model, tree), strict=True):
            if model.places[s.mode].mode == at.mode and jumps == at.jumps:
                for stage in s.stages:
                    if stage.time[0] <= at.time <= stage.time[1]:
                        yield dict(zip(model.names, stage.states, strict=True))


def _is_in(names: Sequence[str], box: Sequence[float], at: Instant, error: float) -> bool:
    for k, name in enumerate(names):
        if name == "time":  # by which the box was chosen
            continue
        low, high, x = box[2 * k], box[2 * k + 1], at.values[name]
        slack = DIGITS * max(abs(low), abs(high)) + error * (1 + abs(x))
        if not low - slack <= x <= high + slack:
            return False
    return True


def _beyond(names: Sequence[str], box: Sequence[float], at: Instant) -> float:
    pairs = ((box[2 * k] - at.values[n], at.values[n] - box[2 * k + 1]) for k, n in enumerate(names) if n != "time")
    return max(max(below, above) for below, above in pairs)


def _is_apart(names: Sequence[str], box: Sequence[float], x: dict[str, Any]) -> bool:
    for k, name in enumerate(names):
        low, high = box[2 * k], box[2 * k + 1]
        slack = DIGITS * max(abs(low), abs(high))
        if name != "time" and (x[name][0] > high + slack or x[name][1] < low - slack):
            return True
    return False
