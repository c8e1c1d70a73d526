"""Where runs from a box are when they end, and how that depends on their start: one lap of an automaton cut open."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction

from haverify.analyses.hybrid.conditions import Atom, Condition, Every
from haverify.analyses.hybrid.goal import window
from haverify.analyses.hybrid.listing import Judged, listings
from haverify.analyses.hybrid.model import HybridModel
from haverify.analyses.orbits.laps import BACK, BEGIN, Cut, derived, guard_atoms, modelled, opened, speed_of
from haverify.analyses.orbits.linear import Matrix
from haverify.analyses.orbits.ranges import Ranges
from haverify.maths.interval import Fault, Interval
from haverify.model.expression import Expr
from haverify.solvers.kernel import Budget, Jump, ModeListing, Settings, Stretch, grown, stretches
from haverify.text.record import holder, record

Q = Fraction
Box = Mapping[str, Interval]
LEAST = 1e-9  # of a lap: no step is shorter
LONGEST = 1 / 24  # of a lap: no step is longer
BEYOND = 1.3  # laps: so far runs are followed
STRETCHES = 60
OPENED = {"<=": "<", ">=": ">", "<": "<", ">": ">", "!=": "!=", "==": "=="}
ORDER, ERROR = 20, 1e-15  # of a step, in units of the state
WIDE = 1e-11  # the same where params are open


@record
class Landing:
    """A jump of all runs of a lap: the edge of the automaton, its instants, states before and after it."""

    edge: int
    time: Interval
    before: Box
    after: Box


@record
class Lap:
    """A lap of all runs from a box: jumps on the way, when and where it ends, the derivative by the columns there."""

    landings: tuple[Landing, ...]
    time: Interval
    state: Box
    slopes: Matrix


@holder
class Track:
    """The automaton cut open, as the kernel takes it, for laps of about some length."""

    model: HybridModel
    cut: Cut
    length: float
    size: float

    def __post_init__(self) -> None:
        automaton = opened(self.model, self.cut)
        self.opened = modelled(self.model, automaton)
        self.names = self.opened.names
        self.modes = self._listed()
        self.beginning = {"time": Interval.at(-1)}

    def _listed(self) -> list[ModeListing]:
        count = len(self.opened.modes)
        landing: dict[int, Condition] = dict.fromkeys(range(len(self.opened.automaton.edges)), True)
        nothing = tuple(() for _ in range(count))
        kept = Every(tuple(window(self.opened)))
        return listings(self.opened, Judged((True,) * count, landing, kept, nothing, nothing))

    def ends(self, start: Box, settings: Settings, cuts: int = 0) -> list[Jump] | None:
        """The jumps with which all runs from a box end; None where some may end elsewhere."""
        tree = self._tree(start, settings, cuts)
        if not self._stays(tree):
            return None
        ends = []
        for number, s in enumerate(tree):
            if any(t.parent == number for t in tree) and s.end in ("jumped", "cut"):
                continue
            if self.opened.modes[s.mode].name != BACK or s.end != "horizon" or s.jump is None:
                return None
            ends.append(s.jump)
        return ends

    def lap(self, start: Box, settings: Settings) -> Lap | None:
        """The lap of all runs from a box, which all make the same jumps; None where that is not certain."""
        tree = self._tree(start, settings, 0)
        if not self._stays(tree):
            return None
        for number, s in enumerate(tree):
            is_last = number == len(tree) - 1
            follows = s.parent == (number - 1 if number else None) and s.is_certain
            if not follows or (not is_last and s.end != "jumped"):
                return None
        jumps = [self._landing(tree, n) for n in range(1, len(tree))]
        if not jumps or self.opened.modes[tree[-1].mode].name != BACK or tree[-1].end != "horizon":
            return None
        *on_the_way, last = jumps
        if self.cut.columns and not self._is_smooth(jumps):
            return None
        slopes = [[last.after[derived(v, c)] for c in self.cut.columns] for v in self.cut.columns]
        landings = tuple(j for j in on_the_way if j.edge >= 0)
        return Lap(landings, last.time, last.after, slopes)

    def _stays(self, tree: Sequence[Stretch]) -> bool:
        """Whether runs stay in the declared ranges, and end nowhere: because of their domain, or as they choose."""
        moving = [s for s in tree if self.opened.modes[s.mode].name not in (BACK, BEGIN)]
        if any(self.opened.modes[s.mode].terminal for s in moving):
            return False
        return all(g.keeps_window and g.stays for s in moving for g in s.stages)

    def _tree(self, start: Box, settings: Settings, cuts: int) -> list[Stretch]:
        """The tree of stretches; derivatives at the start are those of the state by itself."""
        framed, none = self.cut.enters is not None, Interval.at(0)
        unit = {derived(v, c): Interval.at(int(v == c)) for v in self.cut.columns for c in self.cut.columns}
        given = {**(self.beginning if framed else unit), **start}
        sides = [given.get(n, none) for n in self.names]
        mode = self.opened.mode(BEGIN if framed else self.cut.start)
        budget = Budget(STRETCHES, STRETCHES * (1 + 2**cuts), cuts)
        horizon = BEYOND * self.length
        where = mode, [(x.low, x.high) for x in sides], list[tuple[int, str]]()
        return stretches(grown(self.modes, where, horizon, "horizon", settings, budget))

    def _landing(self, tree: Sequence[Stretch], number: int) -> Landing:
        jump, parent = tree[number].jump, tree[number - 1]
        assert jump is not None, "a stretch after the first begins with a jump"
        edge = self.opened.edges[parent.mode][jump.edge]
        before, after = (dict(zip(self.names, [Interval(*x) for x in xs], strict=True))
                         for xs in (jump.before, jump.after))  # fmt: skip
        return Landing(self._origin(edge), Interval(*jump.time), before, after)

    def _origin(self, edge: int) -> int:
        """The number of an edge in the automaton; -1 for those that cut it open."""
        leaving = [
            k for k, e in enumerate(self.model.automaton.edges) if e.source in {m.name for m in self.model.modes}
        ]
        copied = [k for k in leaving if self.model.automaton.edges[k].source == self.cut.end]
        return ([*leaving, *copied, -1, -1, -1])[edge]

    def _is_smooth(self, jumps: Sequence[Landing]) -> bool:
        """Whether each jump is made where its border is crossed at a certain speed, for a while after the last one.

        Then its instant is a smooth function of the start: what else its guard says holds, and with room.
        """
        last = Interval.at(-1)
        for j in jumps:
            if not last.high < j.time.low:
                return False
            last = j.time
            if j.edge >= 0 and not self._crosses(j):
                return False
        return is_moving(self.model, self.cut.end, self.cut.quantity, jumps[-1].before)

    def _crosses(self, j: Landing) -> bool:
        edge = self.model.automaton.edges[j.edge]
        border = (self.cut.borders or {}).get(j.edge)
        here = Ranges(j.before, self.model.definitions[self.model.mode(edge.source)])
        atoms = guard_atoms(self.model, edge)
        if border is None or not any(a.quantity == border and a.op != "!=" for a in atoms):
            return False
        others = [Atom(a.quantity, OPENED[a.op]) for a in atoms if a.quantity != border]
        return all(here.truth(a) is True for a in others) and is_moving(self.model, edge.source, border, j.before)


def is_moving(model: HybridModel, mode: str, quantity: Expr, box: Box) -> bool:
    """Whether a quantity certainly moves one way along the flow of a mode, in a box."""
    try:
        x = Ranges(box, model.definitions[model.mode(mode)]).of(speed_of(model, mode, quantity))
    except Fault:
        return False
    return x.low > 0 or x.high < 0


def settings_of(length: float, size: float, degree: int = 1, error: float = ERROR) -> Settings:
    """How finely a lap is followed."""
    longest = length * LONGEST
    return Settings(ORDER, degree, error * max(size, 1e-6), min(longest, 0.02), longest, length * LEAST, 4000, 4)


def finely(given: Box, length: float, size: float) -> Settings:
    """How finely a lap from nearly one state is followed: numbers that are open in it make polynomials of it."""
    is_open = any(x.low < x.high for x in given.values())
    return settings_of(length, size, 3 if is_open else 1, WIDE if is_open else ERROR)
