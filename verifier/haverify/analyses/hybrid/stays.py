"""What flowpipes show of a formula of several temporal operators: stays between jumps, on a timeline (LANGUAGE S21)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from math import ceil, floor, lcm
from typing import cast

from haverify.analyses.hybrid.model import HybridModel
from haverify.analyses.signals_formula import Formula
from haverify.analyses.signals_value import Cut, Dwell, Signal, Span, Timeline, at_start, joined, rest
from haverify.model.expression import Expr
from haverify.solvers.kernel import Pair, Stretch
from haverify.text.record import field, holder, record, replace

Q = Fraction
Ticks = tuple[int, int]
Path = tuple[int, ...]
FINENESS = 2**40  # ticks in the time that a formula looks at, at least
ONE = (Q(1), Q(1))
FIRST: Cut = (cast(Q, 0), 0)
LANDING: Cut = (cast(Q, 0), 1)  # just after the first instant of a stay


@record
class Grid:
    """A formula with its windows in ticks: whole numbers, which are exact and quick to compare."""

    formula: Formula
    ticks: int  # a second

    @property
    def horizon(self) -> int:
        """How far the formula looks, in ticks."""
        return int(self.formula.horizon)

    def around(self, time: Pair) -> Ticks:
        """The least interval of ticks around one of seconds."""
        return floor(Q(time[0]) * self.ticks), ceil(Q(time[1]) * self.ticks)


def grid_of(formula: Formula) -> Grid:
    """The formula on ticks of which the ends of all its windows are multiples."""
    ends = [q for e in windows(formula.whole) for q in formula.ends(e)]
    ticks = lcm(*(q.denominator for q in ends))
    while ticks * formula.horizon < FINENESS and formula.horizon > 0:
        ticks *= 2**20
    counted = replace(formula, number=lambda e: cast(Q, int(formula.number(e) * ticks)))
    return Grid(counted, ticks)


def windows(e: Expr) -> Iterator[Expr]:
    """The temporal operators of a formula."""
    if e.op in ("globally", "eventually", "until"):
        yield e
    for c in e.children:
        yield from windows(c)


@holder
class Stay:
    """A stay between jumps: when it begins, and when it may be in which steps, by stretches of the tree; in ticks.

    `after` is the stretch whose jump leads to it. From `open_from` on nothing is known, not even that it goes on.
    """

    begin: Ticks
    after: int | None
    steps: list[tuple[int, int, Ticks]] = field(default_factory=list)
    end: Ticks | None = None
    open_from: int | None = None

    def possible(self, time: Ticks) -> Span:
        """The times since its beginning that instants between two may be at."""
        return (cast(Q, max(time[0] - self.begin[1], 0)), 0), (cast(Q, time[1] - self.begin[0]), 1)

    def dwell(self, horizon: int) -> Dwell:
        """It as a part of a timeline that ends at the horizon."""
        first, last = self.begin
        ends = (horizon, horizon) if self.end is None else self.end
        sure = ends[0] if self.open_from is None else self.open_from
        is_instant = not self.steps and self.end is not None
        high = 0 if is_instant else max(ends[1] - first, 0)
        return Dwell(cast(Q, min(max(sure - last, 0), high)), cast(Q, high), (cast(Q, first), cast(Q, last)))


@holder
class Stays:
    """The trees of a box of starts, the same stretches judged for each atom of a formula."""

    model: HybridModel
    grid: Grid
    trees: Sequence[Sequence[Stretch]]

    @cached_property
    def _times(self) -> list[list[Ticks]]:
        return [[self.grid.around(g.time) for g in s.stages] for s in self.trees[0]]

    @cached_property
    def _jumps(self) -> list[Ticks | None]:
        return [None if s.jump is None else self.grid.around(s.jump.time) for s in self.trees[0]]

    @cached_property
    def _following(self) -> list[list[int]]:
        found: list[list[int]] = [[] for _ in self.trees[0]]
        for number, s in enumerate(self.trees[0]):
            if s.parent is not None:
                found[s.parent].append(number)
        return found

    def is_kept(self) -> bool:
        """Whether the formula holds on all runs; what is decided before a jump is not asked after it."""
        waiting = [0]
        while waiting:
            number = waiting.pop()
            following, way = self._following[number], self.way_to(number)
            if following and self.truth(way, is_over=False) is True:
                continue
            if self.trees[0][number].end not in ("jumped", "cut") and self.truth(way) is not True:
                return False
            waiting += reversed(following)
        return True

    def way_to(self, number: int) -> Path:
        """The stretches on the way to one, with it."""
        found = [number]
        while (parent := self.trees[0][found[0]].parent) is not None:
            found.insert(0, parent)
        return tuple(found)

    def truth(self, path: Path, is_over: bool = True) -> bool | None:
        """Whether the formula holds on all runs that go one way; None where that is not known.

        Where the way is not over, they go on somehow, at the earliest where they may leave the last stretch. False is
        said of the runs that exist.
        """
        stays = self._stays(path, is_over)
        line = Timeline(tuple(s.dwell(self.grid.horizon) for s in stays))

        def atom(number: int, _up: bool) -> Signal:
            found = [self._seen(s, number, d) for s, d in zip(stays, line.dwells, strict=True)]
            return Signal(tuple(must for must, _ in found), tuple(may for _, may in found))

        return at_start(self.grid.formula.value(line, ONE, atom))

    def _stays(self, path: Path, is_over: bool) -> list[Stay]:
        """The stays on a way, up to where runs may end or leave the declared ranges."""
        stays = [Stay((0, 0), None)]
        for number, following in pairwise((*path, None)):
            assert number is not None, "only what follows the last one is none"
            jump = None if following is None else self._jumps[following]
            if self._is_open(stays[-1], number, jump):
                break
            if following is None:
                stays[-1].open_from = self._known_until(stays[-1], number, is_over)
            elif jump is not None and self._is_real(following):
                stays[-1].end = jump
                stays.append(Stay(jump, following))
        return stays

    def _is_open(self, stay: Stay, number: int, until: Ticks | None) -> bool:
        """Add a stretch to a stay; whether its runs may leave the declared ranges or be stuck in a step of it."""
        for k, (g, time) in enumerate(zip(self.trees[0][number].stages, self._times[number], strict=True)):
            if until is not None and time[0] > until[1]:
                break
            if not (g.stays and g.keeps_window):
                stay.open_from = time[0]
                return True
            stay.steps.append((number, k, time if until is None else (time[0], min(time[1], until[1]))))
        return False

    def _known_until(self, stay: Stay, number: int, is_over: bool) -> int | None:
        """When it is first not known how the runs of the last stretch of a way go on; None at the horizon."""
        end, times = self.trees[0][number].end, self._times[number]
        if end == "horizon" and is_over:
            return None
        if end == "left" or not times:
            return times[0][0] if times else stay.begin[0]
        instants: list[int] = [t[0] for k in self._following[number] if (t := self._jumps[k]) is not None]
        return min([times[-1][0], *instants])

    def _is_real(self, number: int) -> bool:
        """Whether a stretch begins with a jump of the automaton, not with a change of side."""
        s = self.trees[0][number]
        assert s.parent is not None and s.jump is not None, "it follows another by a jump"
        return self.model.origins[self.model.edges[self.trees[0][s.parent].mode][s.jump.edge]] is not None

    def _seen(self, stay: Stay, atom: int, dwell: Dwell) -> tuple[tuple[Span, ...], tuple[Span, ...]]:
        """Where in a stay an atom certainly holds, and where it is not certainly false."""
        tree, end = self.trees[atom], dwell.end
        beyond = [] if stay.open_from is None else [(stay.possible((stay.open_from, stay.open_from))[0], end)]
        claims = [(time, tree[number].stages[k].claim) for number, k, time in stay.steps]
        doubtful = joined([*(stay.possible(time) for time, c in claims if not c.holds), *beyond])
        possible = joined([*(stay.possible(time) for time, c in claims if not c.fails), *beyond])
        whole = (FIRST, end)
        if stay.after is None:
            return rest(doubtful, whole), rest(rest(possible, whole), whole)
        landing = tree[stay.after].jump
        assert landing is not None, "a stay after a jump has one"
        at, later = (FIRST, LANDING), (LANDING, end)
        must = joined([*([at] if landing.claim.holds else []), *rest(doubtful, later)])
        never = joined([*([at] if landing.claim.fails else []), *rest(possible, later)])
        return must, rest(never, whole)
