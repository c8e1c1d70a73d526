"""Runs with exact numbers along a path of symbolic states: chosen from the end back to the start, round ones first."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from math import ceil, floor
from typing import Any

from haverify.analyses.networks.explore import Exploration
from haverify.analyses.networks.network import Dwell, Move, Network
from haverify.analyses.networks.starts import starts
from haverify.analyses.networks.terms import State
from haverify.analyses.networks.zones import FREE, Zone
from haverify.evidence.network_run import Moment, NetworkRun
from haverify.text.record import holder, record, replace

Point = dict[int, Fraction]  # clock -> value, clock 0 -> 0
Cut = tuple[Fraction, bool]  # an end of an interval, and whether it is left out
End = Any  # (the last Stage) -> zones in which the path may end


@record
class Stage:
    """A state on the way: the move to it (None at the start), the part of the zone before that makes it, the dwell."""

    move: Move | None
    before: Zone | None
    state: State
    dwell: Dwell


def concrete_run(exploration: Exploration, path: Sequence[State], end: End) -> NetworkRun | None:
    """A run through discrete states like those of a path that ends in what `end` allows; None where there is none."""
    keys = [exploration.symmetry.key(s) for s in path]
    for stages, last in _walks(exploration, keys, end):
        return _Chosen(exploration.network, stages, last).run()
    return None


def _walks(exploration: Exploration, keys: Sequence[Any], end: End) -> Iterator[tuple[list[Stage], Zone]]:
    """Paths of exact symbolic states through discrete states alike to the given ones, with the zone to end in."""
    net = exploration.network
    waiting: list[list[Stage]] = []
    for s, z in starts(net):
        if exploration.symmetry.key(s) == keys[0]:
            waiting += [[x] for x in _stages(exploration, None, None, s, z)]
    waiting.reverse()
    seen: set[Any] = set()
    while waiting:
        stages = waiting.pop()
        net.effort.spend(50)
        last = stages[-1]
        if len(stages) == len(keys):
            yield from ((stages, z) for z in end(last))
            continue
        new: list[list[Stage]] = []
        for m, part, landed in net.jumps(last.state, last.dwell.reached):
            assert m.target is not None
            if exploration.symmetry.key(m.target) == keys[len(stages)]:
                new += [[*stages, x] for x in _stages(exploration, m, part, m.target, landed)]
        for found in reversed(new):
            mark = len(found), found[-1].state, found[-1].dwell.reached, found[-1].dwell.landed
            if mark not in seen:
                seen.add(mark)
                waiting.append(found)


def _stages(exploration: Exploration, m: Move | None, before: Zone | None, s: State, landed: Zone) -> Iterator[Stage]:
    for d in exploration.network.dwells(s, landed):
        for z in exploration.network.space.meet(d.reached, exploration.limit):
            yield Stage(m, before, s, replace(d, reached=z))


@holder
class _Chosen:
    """Points chosen on a path, from the last zone backwards."""

    network: Network
    stages: list[Stage]
    last: Zone

    def run(self) -> NetworkRun:
        """The run through the chosen points."""
        moments: list[Moment] = []
        point = self._point(self.last, {})
        end = self._values(self.stages[-1].state, point)
        for k in range(len(self.stages) - 1, -1, -1):
            stage = self.stages[k]
            waited = self._waited(stage.dwell.landed, point)
            landing = {c: x - (waited if c else 0) for c, x in point.items()}
            moments.append(self._moment(stage, landing, waited))
            if stage.move is not None and stage.before is not None:
                kept = {c for c, _, _ in stage.move.sets}
                point = self._point(stage.before, {c: x for c, x in landing.items() if c not in kept})
        return NetworkRun(tuple(reversed(moments)), end)

    def _moment(self, stage: Stage, point: Point, waited: Fraction) -> Moment:
        net = self.network
        modes = tuple((a.prefix[:-1], str(stage.state[k])) for k, a in enumerate(net.automata))
        names = stage.move.event.names if stage.move is not None else ()
        return Moment(names, modes, self._values(stage.state, point), waited / net.scale)

    def _values(self, s: State, point: Point) -> tuple[tuple[str, Fraction], ...]:
        net = self.network
        clocks = {n: point[c] * net.rates[n] / net.scale for n, c in net.clocks.items()}
        return tuple((n, clocks[n] if n in clocks else s[net.slots[n]]) for n in net.types)

    def _waited(self, landed: Zone, point: Point) -> Fraction:
        """The shortest round time after which a landing has become the point."""
        n = self.network.space.n
        lows, highs = [(Fraction(0), False)], list[tuple[Fraction, bool]]()
        for c in range(1, n):
            if landed[c * n] != FREE:
                lows.append((point[c] - (landed[c * n] >> 1), not landed[c * n] & 1))
            if landed[c] != FREE:
                highs.append((point[c] + (landed[c] >> 1), not landed[c] & 1))
        return self._round(max(lows), _least(highs))

    def _point(self, z: Zone, fixed: Mapping[int, Fraction]) -> Point:
        """A point of a zone with the fixed values: clocks are as equal, that is set at as few instants, as may be."""
        n, point = self.network.space.n, {0: Fraction(0), **fixed}
        order = [c for c in range(1, n) if c not in point]
        for c in sorted(order, key=lambda c: -(z[c] >> 1) if z[c] != FREE else -FREE, reverse=True):
            lows = [(x - (z[j * n + c] >> 1), not z[j * n + c] & 1) for j, x in point.items() if z[j * n + c] != FREE]
            highs = [(x + (z[c * n + j] >> 1), not z[c * n + j] & 1) for j, x in point.items() if z[c * n + j] != FREE]
            high = _least(highs)
            low = max(lows) if lows else (Fraction(0), False) if high is None else (high[0] - self.network.scale, False)
            equal = [x for k, x in point.items() if k and _is_between(low, x, high)]
            point[c] = max(equal) if equal else self._round(low, high)
        return point

    def _round(self, low: Cut, high: Cut | None) -> Fraction:
        """The least value where it may be taken, else a round one a little above, in s."""
        (a, is_open), (b, ends_open) = low, high or (None, False)
        if not is_open:
            return a
        for step in (Fraction(1), Fraction(1, 2), Fraction(1, 10), Fraction(1, 100), Fraction(1, 1000)):
            unit = step * self.network.scale
            q = (floor(a / unit) + 1) * unit
            if b is None or q < b or (q == b and not ends_open):
                return q
        assert b is not None
        return _simplest(a, b)


def _is_between(low: Cut, x: Fraction, high: Cut | None) -> bool:
    is_above = low[0] < x or (low[0] == x and not low[1])
    return is_above and (high is None or x < high[0] or (x == high[0] and not high[1]))


def _least(ends: Sequence[Cut]) -> Cut | None:
    return min(ends, key=lambda e: (e[0], not e[1]), default=None)


def _simplest(a: Fraction, b: Fraction) -> Fraction:
    """A number of small denominator strictly between two."""
    d = ceil(1 / (b - a)) + 1
    return Fraction(floor(a * d) + 1, d)
