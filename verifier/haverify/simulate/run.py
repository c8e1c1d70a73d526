"""One run: what was drawn for it, what became of it, in the words of the model."""

from __future__ import annotations

from collections.abc import Sequence

from haverify.simulate.draws import Draw
from haverify.simulate.model import SimulatedAutomaton
from haverify.solvers.runs import PlanListing, Record, Row
from haverify.text.record import holder, record

ORDER = 20
STEPS = 200_000
JUMPS = 100_000


@record
class Settings:
    """Horizon (s), most jumps, what to do where an edge may be taken, and the number that chance starts from."""

    until: float
    jumps: int = JUMPS
    policy: str = "earliest"
    seed: int = 0
    order: int = ORDER
    steps: int = STEPS


@holder
class SimulatedRun:
    """A run that was followed to its end."""

    model: SimulatedAutomaton
    draw: Draw
    record: Record

    def __post_init__(self) -> None:
        self.end, self.time, self.mode, self.state, self.limit, self.steps = self.record.end()
        self.jumps = self.record.jumps()

    def rows(self, times: Sequence[float]) -> list[Row]:
        """The run at some times and on both sides of each jump."""
        return self.record.sample(list(times))

    def told(self) -> str:
        """How the run ended, in a sentence."""
        model = self.model
        count = len(model.automaton.vars)
        state = ", ".join(f"{n} = {x:.9g}" for n, x in zip(model.names[:count], self.state, strict=False))
        mode = model.automaton.modes[self.mode].name
        jumps = f"{len(self.jumps)} jump{'' if len(self.jumps) == 1 else 's'}"
        return f"{_ENDS[self.end]} at {self._when()} in {mode} after {jumps}: {state}"

    def _when(self) -> str:
        return f"{self.limit:.12g} s" if self.end == "zeno" else f"{self.time:.9g} s"


_ENDS = {
    "horizon": "followed to the horizon",
    "jumps": "the jumps allowed were used up",
    "steps": "the steps allowed were used up",
    "outside": "starts outside the domain",
    "stuck": "stuck (no time can pass, no edge is enabled)",
    "ended": "ended in a terminal mode",
    "zeno": "Zeno: jumps accumulate",
    "escape": "the state escapes to infinity",
    "undefined": "a right side of the flow has no value",
}


def followed(model: SimulatedAutomaton, draw: Draw, settings: Settings, given: Sequence[float] = ()) -> SimulatedRun:
    """The run from a draw; `given` are shares for choices, used before chance is asked."""
    return SimulatedRun(model, draw, model.kernel.run(plan_of(draw, settings, given)))


def plan_of(draw: Draw, settings: Settings, given: Sequence[float] = ()) -> PlanListing:
    """What the kernel is asked."""
    limits = settings.jumps, settings.steps, settings.order
    return draw.mode, draw.state, settings.until, limits, settings.policy, settings.seed, list(given), draw.writes
