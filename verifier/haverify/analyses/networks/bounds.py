"""Up to which value each clock is still compared, by discrete state: what an exploration may forget beyond.

Source          G. Behrmann, P. Bouyer, E. Fleury, K. Larsen, TACAS 2003 (static guard analysis)
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import cached_property
from itertools import islice, product
from typing import Any

from haverify.analyses.networks.network import Network, mentioned, part_of
from haverify.analyses.networks.terms import State
from haverify.analyses.networks.zones import literals
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import field, holder

Json = Any
MANY = 4096


@holder
class Marks:
    """For clocks the largest c in `x > c` or `x >= c` (lower) and in `x < c` or `x <= c` (upper) still ahead."""

    lower: dict[int, int] = field(default_factory=dict)
    upper: dict[int, int] = field(default_factory=dict)

    def add(self, found: Iterable[tuple[int, int, int]], is_exact: bool) -> None:
        """Take in some bounds; where the truth and its opposite both count, each bound is one of either kind."""
        for i, j, bound in found:
            c = bound >> 1
            if i and j:  # no extrapolation is exact for differences; this one only has to end
                for clock in (i, j):
                    for table in (self.lower, self.upper):
                        _raise(table, clock, 2 * abs(c) + 1)
            elif i:
                _raise(self.upper, i, c)
                if not is_exact:
                    _raise(self.lower, i, c)
            else:
                _raise(self.lower, j, -c)
                if not is_exact:
                    _raise(self.upper, j, -c)

    def join(self, other: Marks, without: frozenset[int] = frozenset()) -> bool:
        """Take in other marks, those of some clocks apart; whether anything grew."""
        grew = False
        for mine, theirs in ((self.lower, other.lower), (self.upper, other.upper)):
            for clock, c in theirs.items():
                if clock not in without and c > mine.get(clock, c - 1):
                    mine[clock] = c
                    grew = True
        return grew


def _raise(table: dict[int, int], clock: int, c: int) -> None:
    table[clock] = max(c, table.get(clock, c))


@holder
class Bounds:
    """The marks of a network; bounds in `claims` count everywhere, with `both_ways` each as one of either kind.

    `is_exact`: nothing may be forgotten.
    """

    network: Network
    claims: tuple[Json, ...]
    both_ways: bool
    is_exact: bool = False
    _known: dict[State, tuple[list[int | None], list[int | None]]] = field(default_factory=dict)

    def of(self, s: State) -> tuple[list[int | None], list[int | None]]:
        """Lower and upper marks of all clocks in a discrete state; None: not compared any more."""
        if self.is_exact:
            return [1 << 50] * self.network.space.n, [1 << 50] * self.network.space.n
        key = s[: len(self.network.automata)]
        if key not in self._known:
            marks = Marks()
            marks.join(self.everywhere)
            for k, a in enumerate(self.network.automata):
                marks.join(self.local[a.prefix + s[k]])
            n = self.network.space.n
            lower: list[int | None] = [0, *(marks.lower.get(c) for c in range(1, n))]
            upper: list[int | None] = [0, *(marks.upper.get(c) for c in range(1, n))]
            if self.both_ways:
                lower = upper = [None if a is b is None else max(x for x in (a, b) if x is not None)
                                 for a, b in zip(lower, upper, strict=True)]  # fmt: skip
            self._known[key] = lower, upper
        return self._known[key]

    @cached_property
    def everywhere(self) -> Marks:
        """What syncs, priorities, claims, and parts that read another's clock compare."""
        net, marks = self.network, Marks()
        for i in net.interactions.values():
            for x in (i, *i.listeners):
                marks.add(self._found(x.guards), False)
        marks.add(self._found([g for pairs in net.over.values() for _, g in pairs]), False)
        marks.add(self._found(self.claims), False)
        for n, window in net.windows.items():
            marks.add(literals(net.terms.clock_bounds(n, *window)) if n in net.clocks else (), False)
        for place, table in self._sources.items():
            own = {c for n, c in net.clocks.items() if n.startswith(part_of(place))}
            marks.join(table, frozenset(own))
        return marks

    @cached_property
    def _sources(self) -> dict[str, Marks]:
        """What each `part.mode` compares: in its domain and in the edges that leave it."""
        net, out = self.network, dict[str, Marks]()
        suppressing = {e for pairs in net.over.values() for a, _ in pairs for e in net.interactions[a].edges}
        listening = {e for i in net.interactions.values() for x in i.listeners for e in x.edges}
        for place, domain in net.domains.items():
            out[place] = Marks()
            out[place].add(
                self._found([domain], closed=True), not self._enters_negatively(place, suppressing | listening)
            )
        for name, edges in net.edges.items():
            for e in edges:
                exact = not (e.is_urgent or name in suppressing or name in listening or self._is_urgent(name))
                out[part_of(name) + e.source].add(self._found([e.guard]), exact)
        return out

    def _enters_negatively(self, place: str, names: set[str]) -> bool:
        """Is there an edge into a mode whose not being enabled matters?"""
        part = part_of(place)
        return any(
            part + e.target == place and (n in names or e.is_urgent or self._is_urgent(n))
            for n, es in self.network.edges.items() if part_of(n) == part for e in es
        )  # fmt: skip

    def _is_urgent(self, edge: str) -> bool:
        """Is an edge part of something urgent?"""
        return edge in self._urgent

    @cached_property
    def _urgent(self) -> set[str]:
        found = set()
        for i in self.network.interactions.values():
            names = {e for x in (i, *i.listeners) for e in x.edges}
            if any(e.is_urgent for n in names for e in self.network.edges[n]):
                found |= names
        return found

    @cached_property
    def local(self) -> dict[str, Marks]:
        """For each `part.mode` the marks of the part's own clocks: those there and those ahead where not set before."""
        net = self.network
        out = {place: Marks() for place in net.domains}
        for place, table in self._sources.items():
            others = frozenset(c for n, c in net.clocks.items() if not n.startswith(part_of(place)))
            out[place].join(table, others)
        edges = [
            (part_of(n) + e.source, part_of(n) + e.target, self._set(e.resets))
            for n, es in net.edges.items()
            for e in es
        ]
        grew = True
        while grew:
            grew = False
            for source, target, sets in edges:
                grew = out[source].join(out[target], sets) or grew
        return out

    def _set(self, resets: Iterable[Json]) -> frozenset[int]:
        return frozenset(self.network.clocks[r["var"]] for r in resets if r["var"] in self.network.clocks)

    def _found(self, conditions: Iterable[Json], closed: bool = False) -> Iterator[tuple[int, int, int]]:
        """The bounds that conditions come to, for all values of the discrete variables they read."""
        for e in conditions:
            for s in self._assignments(e):
                try:
                    yield from literals(self.network.terms.truth(e, s, closed=closed))
                except (OutsideFragmentError, TypeError):
                    continue  # it does for no state that is reached, or the exploration says so

    def _assignments(self, e: Json) -> Iterator[State]:
        net = self.network
        slots: dict[int, list[Any]] = {}
        for n in mentioned(e):
            if n in net.terms.modes:
                k = net.terms.modes[n][0]
                slots[k] = [m["name"] for m in net.automata[k].model["modes"]]
            elif n in net.slots:
                slots[net.slots[n]] = net.values(n) or [None]
        for chosen in islice(product(*slots.values()), MANY):
            given = dict(zip(slots, chosen, strict=True))
            yield tuple(given.get(k) for k in range(len(net.slots)))
