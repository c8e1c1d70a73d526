"""How one state of a system follows another (LANGUAGE S7 to S18), derived from the core alone."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from itertools import product
from typing import Any, NamedTuple

from hacheck.core import Core
from hacheck.parts import Edge, Together, mentioned
from hacheck.rational import Beyond, Refused, spend
from hacheck.readings import Event, Readings, State
from hacheck.zones import NO_BOUND, Formula, Zone, both, either, opposite

Json = Any


class Move(NamedTuple):
    """One way to fire: where the guards hold and the outcome is allowed; the next discrete state, the clocks set."""

    event: Event
    urgent: bool
    where: Formula
    target: State | None  # None where a variable would leave its type
    sets: tuple[tuple[int, int, int], ...]  # clock, least and greatest value


class Network(Readings):
    """A system with all its parts, what can fire in its states and what becomes of them."""

    def __init__(self, core: Core, system: Json, scale: int, timed: bool) -> None:
        super().__init__(core, system, scale, timed)
        self.edges: dict[str, list[Edge]] = {}
        for e in (e for a in self.automata for e in a.edges()):
            self.edges.setdefault(e.name, []).append(e)
        self.together = self.root.together()
        self.over = self._priorities()
        self._moves: dict[State, list[Move]] = {}
        self._fires: dict[State, list[tuple[Move, Formula]]] = {}
        self._stops: dict[State, list[Zone]] = {}

    # ---- interactions ----

    def _priorities(self) -> list[tuple[str, str, Json]]:
        """Which interaction suppresses which, and when: all chains of the priorities of the core."""
        direct = self.root.priorities()
        if any(n not in self.together for a, b, _ in direct for n in (a, b)):
            raise Beyond("a priority among edges that fire only together with others")
        found, new = list(direct), list(direct)
        for _ in range(len(self.together)):
            new = [(a, d, _and(g, h)) for a, b, g in new for c, d, h in direct if b == c]
            new = [x for x in new if x not in found]
            spend(len(found) * (1 + len(new)))
            found += new
        if new or any(a == b for a, b, _ in found):
            raise Refused("priorities in a circle")
        return [x for x in found if x[2] is not False]

    def moves(self, s: State) -> list[Move]:
        """All ways to fire in a discrete state, with priorities applied (S14 to S17)."""
        if s not in self._moves:
            ways = {n: list(self._ways(t, s)) for n, t in self.together.items()}
            ready = {n: either(m.where for m in ms) for n, ms in ways.items()}
            out = []
            for n, ms in ways.items():
                above = [both([self.truth(g, s), ready[a]]) for a, b, g in self.over if b == n and ms]
                free = opposite(either(above))
                out += [m._replace(where=both([m.where, free])) for m in ms]
            self._moves[s] = [m for m in out if m.where is not False]
        return self._moves[s]

    def _ready(self, t: Together, s: State) -> tuple[list[Edge], Formula] | None:
        """The edges that take part and where their guards hold; None where one belongs to another mode."""
        edges: list[Edge] = []
        for name in t.edges:
            found = [e for e in self.edges[name] if s[self._owner(name)] == e.source]
            if len(found) > 1:
                raise Beyond(f"two edges {name!a} of one mode")
            if not found:
                return None
            edges += found
        return edges, both(self.truth(g, s) for g in (*t.guards, *(e.guard for e in edges)))

    def _owner(self, edge: str) -> int:
        return self.slots[edge.rpartition(".")[0] + "."]

    def _ways(self, t: Together, s: State) -> Iterator[Move]:
        first = self._ready(t, s)
        if first is None or first[1] is False:
            return
        joining = [(x, r, self._alone(x, r, s)) for x in t.listeners if (r := self._ready(x, s)) is not None]
        for choice in product((True, False), repeat=len(joining)):
            where = both([first[1], *(w if c else opposite(w) for c, (_, _, w) in zip(choice, joining, strict=True))])
            spend(50)
            if where is False:
                continue
            joined = [(x, r[0]) for c, (x, r, _) in zip(choice, joining, strict=True) if c]
            edges = [*first[0], *(e for _, es in joined for e in es)]
            names = (*t.names, *(n for x, _ in joined for n in x.names))
            resets = [*t.resets, *(r for x, _ in joined for r in x.resets)]
            yield from self._outcomes(Event(names, s), edges, resets, where)

    def _alone(self, t: Together, ready: tuple[list[Edge], Formula], s: State) -> Formula:
        """Where a listener is enabled: its guard holds and its outcome is in its own domain."""
        edges, guard = ready
        own = {e.name.rpartition(".")[0] + "." for e in edges}
        for e in edges:
            prefix = e.name.rpartition(".")[0] + "."
            if any(not n.startswith(prefix) for n in mentioned(self.domains[prefix + e.target])):
                raise Beyond("a listener whose domain reads other parts")
        moves = list(self._outcomes(Event((), s), edges, list(t.resets), guard, own))
        return either(m.where for m in moves)

    def _outcomes(self, event: Event, edges: list[Edge], resets: list[Json], where: Formula,
                  own: set[str] | None = None) -> Iterator[Move]:  # fmt: skip
        """One move for each discrete outcome (S9, S15); `own`: only the domains of these parts count."""
        s = event.before
        owners = [self._owner(e.name) for e in edges]
        everything = [r for e in edges for r in e.resets] + resets
        targets = [r["var"] for r in everything]
        if len(set(owners)) < len(owners) or len(set(targets)) < len(targets):
            raise Refused("an interaction takes two edges of a part, or writes a variable twice")
        urgent = any(e.urgent for e in edges)
        sets = tuple(self._clock_set(r, s) for r in everything if r["var"] in self.clocks)
        discrete = [(self.slots[r["var"]], self._results(r, s)) for r in everything if r["var"] not in self.clocks]
        for chosen in product(*(values for _, values in discrete)):
            new: list[Any] = list(s)
            for slot, e in zip(owners, edges, strict=True):
                new[slot] = e.target
            for (slot, _), value in zip(discrete, chosen, strict=True):
                new[slot] = value
            target = None if None in new else tuple(new)
            yield Move(event, urgent, both([where, self._allowed(target, sets, own)]), target, sets)

    def _results(self, r: Json, s: State) -> list[Fraction | None]:
        """The values a discrete variable may get; None for one that its type lacks."""
        low, high = (self.value(r[k], s) for k in (("to", "to") if "to" in r else ("low", "high")))
        if low == high:
            return [low if self.typed(r["var"], low) else None]
        if self.types[r["var"]] == "real":
            raise Beyond("a number from a range that no flow changes")
        spend(abs(int(high - low)) + 1)
        found = [
            Fraction(k) for k in range(-(-low.numerator // low.denominator), high.numerator // high.denominator + 1)
        ]
        return [q if self.typed(r["var"], q) else None for q in found]

    def _clock_set(self, r: Json, s: State) -> tuple[int, int, int]:
        low, high = (self.value(r[k], s) for k in (("to", "to") if "to" in r else ("low", "high")))
        if low > high:
            raise Beyond("a clock gets a value of an empty range")
        ends = [self.clock_value(r["var"], q) for q in (low, high)]
        return self.clocks[r["var"]], min(ends), max(ends)

    def _allowed(self, target: State | None, sets: tuple[tuple[int, int, int], ...], own: set[str] | None) -> Formula:
        """Where some outcome lies in the domain of the target."""
        if target is None:
            return True
        if own is None:
            z = self.domain(target)
        else:
            held = [self.truth(self.domains[p + target[self.slots[p]]], target, closed=True) for p in own]
            zones = self.space.cut(self.space.all, both(held))
            if len(zones) > 1:
                raise Beyond("a domain with alternatives about clocks")
            z = zones[0] if zones else None
        for clock, low, high in sets:
            found = self.space.cut(z, _range(clock, low, high)) if z is not None else []
            z = self.space.forget(found[0], clock) if found else None
        return False if z is None else self.space.formula(z)

    def fires(self, s: State) -> list[tuple[Move, Formula]]:
        """The moves, and where each may be made: an urgent one also where it is about to be enabled (S8)."""
        if s not in self._fires:
            out = []
            for m in self.moves(s):
                soon = (
                    [q for p in self.space.cut(self.space.all, m.where) for q in self.space.about_to(p)]
                    if m.urgent
                    else []
                )
                out.append((m, either([m.where, *(self.space.formula(q) for q in soon)])))
            self._fires[s] = out
        return self._fires[s]

    def stops(self, s: State) -> list[Zone]:
        """Where an urgent interaction is enabled."""
        if s not in self._stops:
            urgent = (m.where for m in self.moves(s) if m.urgent)
            self._stops[s] = [p for where in urgent for p in self.space.cut(self.space.all, where)]
        return self._stops[s]

    # ---- what follows ----

    def landings(self, s: State, z: Zone) -> Iterator[tuple[Move, State, Zone]]:
        """The states right after each jump from a zone."""
        for m, where in self.fires(s):
            for part in self.space.cut(z, where):
                if m.target is None:
                    raise Refused(f"the interaction {m.event.names[0]!a} gives a variable a value that its type lacks")
                for clock, low, high in m.sets:
                    part = self.space.cut(self.space.forget(part, clock), _range(clock, low, high))[0]
                landed = self.within_domain(m.target, part)
                if landed is not None:
                    yield m, m.target, landed

    def dwells(self, s: State, z: Zone) -> list[tuple[Zone | None, Zone]]:
        """What a zone inside the domain becomes as time passes: in the domain, up to what is urgent (S7, S8).

        Each time the part of it that this is about, None where no time may pass, and what it becomes.
        """
        space, stops = self.space, self.stops(s)
        out = list[tuple[Zone | None, Zone]]()
        open_: list[tuple[Zone, list[Zone]]] = [(z, [])]
        for p in stops:
            split = []
            for q, ends in open_:
                out += [(None, x) for x in space.cut(q, space.formula(p))]
                for rest in space.minus(q, p):
                    ahead = space.earlier(p)
                    split += [(x, [*ends, p]) for x in space.cut(rest, space.formula(ahead))]
                    split += [(x, ends) for x in space.minus(rest, ahead)]
            open_ = split
        for q, ends in open_:
            held = self.within_domain(s, space.later(q))
            zones = [held] if held is not None else []
            for p in ends:
                before = [x for y in zones for x in space.cut(y, space.formula(space.earlier(p)))]
                zones = [x for y in before for x in space.minus(y, space.after(p))]
            out += [(q, x) for x in zones]
        return out

    def is_terminal(self, s: State) -> bool:
        """May runs end here (S12, S13)?"""
        return all(a.prefix + s[i] in self.terminal for i, a in enumerate(self.automata))

    def stuck(self, s: State) -> Formula:
        """Where no time can pass and nothing can fire (S12)."""
        d = self.domain(s)
        if d is None or self.is_terminal(s):
            return False
        ends = either(
            (0, c, 1 - (d[c * self.space.n] & ~1)) for c in range(1, self.space.n) if d[c * self.space.n] != NO_BOUND
        )
        return both([self.space.formula(d), ends, *(opposite(f) for _, f in self.fires(s))])


def _range(clock: int, low: int, high: int) -> Formula:
    return both([(0, clock, 2 * -low + 1), (clock, 0, 2 * high + 1)])


def _and(a: Json, b: Json) -> Json:
    return b if a is True or a == b else a if b is True else ["and", a, b]
