"""Breadth-first exploration of a network: symbolic states with where each leads, up to inclusion and symmetry."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from haverify.analyses.networks.bounds import Bounds
from haverify.analyses.networks.network import Network
from haverify.analyses.networks.starts import starts
from haverify.analyses.networks.symmetry import Symmetry
from haverify.analyses.networks.terms import State
from haverify.analyses.networks.zones import Effort, Formula, Zone, inside
from haverify.text.record import field, holder

Json = Any
Orders = tuple[tuple[int, ...], ...]


@holder
class Node:
    """A symbolic state: all time makes of some landings. `next`: (renaming, number) of states that cover what follows.

    `parent` is the state it was first found from, None for a start; `jumps` the number of jumps to it.
    """

    state: State
    zone: Zone
    jumps: int
    parent: int | None
    next: dict[tuple[Orders, int], None] = field(default_factory=dict)


@holder
class Exploration:
    """The states reached, found when asked for; `limit` bounds time, `jumps` the number of jumps (None: no bound)."""

    network: Network
    symmetry: Symmetry
    bounds: Bounds
    limit: Formula
    jumps: int | None
    nodes: list[Node] = field(default_factory=list)
    starts: dict[tuple[Orders, int], None] = field(default_factory=dict)
    _alive: dict[State, list[int]] = field(default_factory=dict)
    _heir: dict[int, int] = field(default_factory=dict)
    _done: int = 0
    _is_started: bool = False

    def use(self, effort: Effort) -> None:
        """Spend this effort from now on."""
        self.network.effort = self.network.space.effort = effort

    def reached(self) -> Iterator[Node]:
        """All states, those with fewest jumps first; states that later ones contain are among them."""
        k = 0
        while k < len(self.nodes) or self._step():
            if k < len(self.nodes):
                yield self.nodes[k]
                k += 1

    def _step(self) -> bool:
        """Look at the next state; False when there is none left."""
        if not self._is_started:
            self._is_started = True
            for s, z in starts(self.network):
                self._found(s, z, None, 0, self.starts)
            return True
        if self._done >= len(self.nodes):
            return False
        k, self._done = self._done, self._done + 1
        node = self.nodes[k]
        if k not in self._heir and (self.jumps is None or node.jumps < self.jumps):
            for m, _, landed in self.network.jumps(node.state, node.zone):
                assert m.target is not None
                self._found(m.target, landed, k, node.jumps + 1, node.next)
        return True

    def _found(
        self, s: State, landed: Zone, parent: int | None, jumps: int, links: dict[tuple[Orders, int], None]
    ) -> None:
        for d in self.network.dwells(s, landed):
            for part in self.network.space.meet(d.reached, self.limit):
                z = self.network.space.extrapolated(part, *self.bounds.of(s))
                for held in self.network.space.meet(z, self.limit):
                    orders, t, q = self.symmetry.canonical(s, held)
                    links[orders, self._covering(t, q, parent, jumps)] = None

    def _covering(self, s: State, z: Zone, parent: int | None, jumps: int) -> int:
        """The state that contains a found one, which is added where none does."""
        self.network.effort.spend(20)
        alive = self._alive.setdefault(s, [])
        for k in alive:
            if inside(z, self.nodes[k].zone) and (self.jumps is None or self.nodes[k].jumps <= jumps):
                return k
        new = len(self.nodes)
        for k in alive:
            if inside(self.nodes[k].zone, z) and (self.jumps is None or jumps <= self.nodes[k].jumps):
                self._heir[k] = new
        alive[:] = [*(k for k in alive if k not in self._heir), new]
        self.nodes.append(Node(s, z, jumps, parent))
        return new

    def path(self, node: Node) -> list[Node]:
        """The states from a start to one."""
        found = [node]
        while found[-1].parent is not None:
            found.append(self.nodes[found[-1].parent])
        return found[::-1]

    def heirs(self) -> dict[int, int]:
        """For each state the number, among those that no later one contains, of the one that contains it."""
        kept = [k for k in range(len(self.nodes)) if k not in self._heir]
        number = {k: i for i, k in enumerate(kept)}
        out = {}
        for k in range(len(self.nodes)):
            last = k
            while last in self._heir:
                last = self._heir[last]
            out[k] = number[last]
        return out

    def kept(self) -> list[Node]:
        """The states that no later one contains."""
        return [n for k, n in enumerate(self.nodes) if k not in self._heir]
