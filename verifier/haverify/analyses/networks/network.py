"""A system as a transition system over discrete states and zones of clocks (LANGUAGE S5 to S18)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from functools import cached_property
from itertools import product
from math import ceil, floor
from typing import Any

from haverify.analyses.networks.naming import Edge, Interaction, Place
from haverify.analyses.networks.terms import TIME, Event, State, Terms, holds, whole
from haverify.analyses.networks.zones import Effort, Formula, Space, Zone, conjunction, disjunction, negation
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import holder, record, replace

Json = Any
Sets = tuple[tuple[int, int, int], ...]  # clock, least value, greatest value


@record
class Move:
    """One way to fire: where it is enabled, the next discrete state, the clocks set. `target` None: outside a type."""

    event: Event
    is_urgent: bool
    where: Formula
    target: State | None
    sets: Sets


@record
class Dwell:
    """A zone of landings that can wait alike, and all that becomes of it as time passes."""

    landed: Zone
    reached: Zone
    can_wait: bool = True


@holder
class Network:
    """A system of the core with its parts; `is_timed` adds a clock for the time since the start."""

    core: Mapping[str, Json]
    system: Json
    scale: int
    is_timed: bool
    effort: Effort

    def __post_init__(self) -> None:
        self.root = Place(self.core, self.system)
        self.places = list(self.root.all())
        self.automata = [p for p in self.places if p.is_automaton]
        self.enums = {e["name"]: e for e in self.core["enums"]}
        self.slots = {a.prefix: k for k, a in enumerate(self.automata)}
        self.clocks: dict[str, int] = {}
        self.rates: dict[str, Fraction] = {TIME: Fraction(1)}
        self.types: dict[str, str] = {}
        self.windows: dict[str, tuple[Fraction | None, Fraction | None]] = {}
        modes = {a.prefix + m["name"]: (k, m["name"]) for k, a in enumerate(self.automata) for m in a.model["modes"]}
        self.terms = Terms(self.scale, self.slots, self.clocks, self.rates, modes, self.stuck)
        for place in [*(p for p in self.places if not p.is_automaton), *self.automata]:
            for v in place.model["vars"]:
                self._variable(place, v)
        if self.is_timed:
            self.clocks[TIME] = len(self.clocks) + 1
        self.space = Space(len(self.clocks) + 1, self.effort)
        self._domains: dict[State, Zone | None] = {}
        self._moves: dict[State, list[Move]] = {}
        self._fires: dict[State, list[tuple[Move, Formula]]] = {}
        self._stops: dict[State, list[Zone]] = {}

    def _variable(self, place: Place, v: Json) -> None:
        name = place.prefix + v["name"]
        flows = [m["flow"] for m in place.model["modes"]] if place.is_automaton else [place.model["flow"]]
        lines = [f for flow in flows for f in flow if f["var"] == v["name"]]
        if any("rate" not in f for f in lines):
            raise OutsideFragmentError(
                f"`{name}` has a range of rates; systems are decided with clocks and discrete variables"
            )
        rates = {self._rate(name, place.flat(f["rate"])) for f in lines} or {Fraction(0)}
        if len(rates) > 1:
            raise OutsideFragmentError(
                f"`{name}` has another rate in other modes; systems are decided with clocks that never stop"
            )
        self.types[name] = v["type"]
        if v["low"] is not None or v["high"] is not None:
            if v["type"] != "real":
                raise OutsideFragmentError(f"`{name}` is discrete and has a declared range besides its type")
            ends = [None if v[k] is None else self.terms.number(place.flat(v[k]), ()) for k in ("low", "high")]
            self.windows[name] = (ends[0], ends[1])
        rate = rates.pop()
        if rate:
            self.clocks[name], self.rates[name] = len(self.clocks) + 1, rate
        else:
            self.slots[name] = len(self.slots)

    def _rate(self, name: str, e: Json) -> Fraction:
        try:
            return self.terms.number(e, ())
        except OutsideFragmentError as reason:
            text = (
                f"`{name}` moves at a rate that is no constant; systems are decided with clocks and discrete variables"
            )
            raise OutsideFragmentError(text) from reason

    @cached_property
    def domains(self) -> dict[str, Json]:
        """The domain of each `part.mode`."""
        return {a.prefix + m["name"]: a.flat(m["domain"]) for a in self.automata for m in a.model["modes"]}

    @cached_property
    def terminal(self) -> set[str]:
        """The `part.mode` in which runs may end."""
        return {a.prefix + m["name"] for a in self.automata for m in a.model["modes"] if m["terminal"]}

    @cached_property
    def edges(self) -> dict[str, list[Edge]]:
        """The edges by full name; several modes may use one."""
        found: dict[str, list[Edge]] = {}
        for a in self.automata:
            for e in a.edges():
                found.setdefault(e.name, []).append(e)
        return found

    @cached_property
    def interactions(self) -> dict[str, Interaction]:
        """What can fire, by name."""
        return self.root.interactions()

    # ---- types, ranges, domains ----

    def values(self, name: str) -> list[Fraction] | None:
        """The values a discrete variable may have; None for a number that no flow changes."""
        kind = self.types[name]
        if kind == "real":
            return None
        if kind == "bool":
            return [Fraction(0), Fraction(1)]
        low = Fraction(self.enums[kind]["low"] or 0)
        return [low + k for k in range(len(self.enums[kind]["values"]))]

    def ends(self, r: Json, s: State) -> tuple[Fraction, Fraction]:
        low, high = ("to", "to") if "to" in r else ("low", "high")
        return self.terms.number(r[low], s), self.terms.number(r[high], s)

    def window(self, s: State) -> Formula:
        """Inside the declared ranges (S4)."""
        out: list[Formula] = []
        for n, (low, high) in self.windows.items():
            if n in self.clocks:
                out.append(self.terms.clock_bounds(n, low, high))
            elif self.values(n) is None:
                out.append(between(low, s[self.slots[n]], high))
        return conjunction(out)

    def domain(self, s: State) -> Zone | None:
        """The clock values that the domains of the parts allow."""
        if s not in self._domains:
            names = [a.prefix + s[k] for k, a in enumerate(self.automata)]
            self._domains[s] = self._closed_zone(names, s)
        return self._domains[s]

    def _closed_zone(self, modes: Sequence[str], s: State) -> Zone | None:
        zones = self.space.meet(
            self.space.everything, conjunction(self.terms.truth(self.domains[m], s, closed=True) for m in modes)
        )
        if len(zones) > 1:
            raise OutsideFragmentError(f"a domain with alternatives about clocks ({', '.join(modes)})")
        return zones[0] if zones else None

    def in_domain(self, s: State, z: Zone) -> Zone | None:
        """The part of a zone inside the domain."""
        d = self.domain(s)
        found = self.space.meet(z, self.space.formula(d)) if d is not None else []
        return found[0] if found else None

    # ---- interactions ----

    @cached_property
    def over(self) -> dict[str, list[tuple[str, Json]]]:
        """For each interaction those that suppress it, and where: all chains of priorities (S17)."""
        direct = self.root.priorities()
        for a, b, _ in direct:
            for n in (a, b):
                if n not in self.interactions:
                    raise OutsideFragmentError(f"a priority orders `{n}`, which fires only together with others")
        above: dict[str, list[tuple[str, Json]]] = {n: [] for n in self.interactions}
        new = list(direct)
        while new:
            for a, b, when in new:
                above[b].append((a, when))
            self.effort.spend(100 * len(new))
            chained = [(a, d, _both(g, h)) for a, b, g in new for c, d, h in direct if b == c]
            new = [x for x in dict(_hashed(x) for x in chained).values() if (x[0], x[2]) not in above[x[1]]]
        return above

    def moves(self, s: State) -> list[Move]:
        """The ways to fire in a discrete state, priorities applied (S14 to S17)."""
        if s not in self._moves:
            self.effort.spend(20 * len(self.interactions))
            ways = {n: list(self._ways(i, s)) for n, i in self.interactions.items()}
            ready = {n: disjunction(m.where for m in ms) for n, ms in ways.items()}
            found = []
            for n, ms in ways.items():
                above = [conjunction([self.terms.truth(g, s), ready[a]]) for a, g in self.over[n] if ms]
                free = negation(disjunction(above))
                found += [replace(m, where=conjunction([m.where, free])) for m in ms]
            self._moves[s] = [m for m in found if m.where is not False]
        return self._moves[s]

    def _ready(self, i: Interaction, s: State) -> tuple[list[Edge], Formula] | None:
        """The edges of the current modes and where all guards hold; None where an edge belongs to another mode."""
        edges = []
        for name in i.edges:
            found = [e for e in self.edges[name] if s[self.owner(name)] == e.source]
            if len(found) > 1:
                raise OutsideFragmentError(f"mode {found[0].source} has two edges named `{name}`: name them apart")
            if not found:
                return None
            edges += found
        return edges, conjunction(self.terms.truth(g, s) for g in (*i.guards, *(e.guard for e in edges)))

    def owner(self, edge: str) -> int:
        """The position of the part that an edge belongs to."""
        return self.slots[part_of(edge)]

    def _ways(self, i: Interaction, s: State) -> Iterator[Move]:
        first = self._ready(i, s)
        if first is None or first[1] is False:
            return
        listening = [(x, r[0], self._alone(x, r, s)) for x in i.listeners if (r := self._ready(x, s)) is not None]
        for choice in product((True, False), repeat=len(listening)):
            self.effort.spend(10)
            pairs = list(zip(choice, listening, strict=True))
            where = conjunction([first[1], *(w if c else negation(w) for c, (_, _, w) in pairs)])
            if where is not False:
                joined = [(x, edges) for c, (x, edges, _) in pairs if c]
                names = (*i.names, *(n for x, _ in joined for n in x.names))
                resets = [*i.resets, *(r for x, _ in joined for r in x.resets)]
                edges = [*first[0], *(e for _, es in joined for e in es)]
                yield from self._outcomes(Event(names, s), edges, resets, where, None)

    def _alone(self, i: Interaction, ready: tuple[list[Edge], Formula], s: State) -> Formula:
        """Where a listener is enabled by itself: its guards hold and its outcome lies in its own parts' domains."""
        edges, guard = ready
        for e in edges:
            part = part_of(e.name)
            if any(not n.startswith(part) for n in mentioned(self.domains[part + e.target])):
                raise OutsideFragmentError(f"the listener `{e.name}` leads to a mode whose domain reads other parts")
        own = [part_of(e.name) for e in edges]
        return disjunction(m.where for m in self._outcomes(Event((), s), edges, i.resets, guard, own))

    def _outcomes(
        self, event: Event, edges: Sequence[Edge], resets: Sequence[Json], where: Formula, own: Sequence[str] | None
    ) -> Iterator[Move]:
        """One move for each discrete outcome (S9, S15); `own`: only the domains of these parts count."""
        s, owners = event.before, [self.owner(e.name) for e in edges]
        written = [r for e in edges for r in e.resets] + list(resets)
        if len(set(owners)) < len(owners) or len({r["var"] for r in written}) < len(written):
            raise OutsideFragmentError(f"`{event.names[0]}` takes two edges of one part, or writes a variable twice")
        sets = tuple(self._set(r, s) for r in written if r["var"] in self.clocks)
        discrete = [(self.slots[r["var"]], self._results(r, s)) for r in written if r["var"] in self.slots]
        urgent = any(e.is_urgent for e in edges)
        for chosen in product(*(values for _, values in discrete)):
            new = list(s)
            for k, e in zip(owners, edges, strict=True):
                new[k] = e.target
            for (k, _), value in zip(discrete, chosen, strict=True):
                new[k] = value
            target = None if None in new else tuple(new)
            yield Move(event, urgent, conjunction([where, self._allowed(target, sets, own)]), target, sets)

    def _results(self, r: Json, s: State) -> list[Fraction | None]:
        """The values that a discrete variable may get; None for those outside its type."""
        (low, high), values = self.ends(r, s), self.values(r["var"])
        if values is None:
            if low != high:
                raise OutsideFragmentError(f"`{r['var']}` gets any value of a range, and no flow changes it")
            return [low]
        self.effort.spend(int(abs(high - low)) + 1)
        given = [low] if low == high else [Fraction(k) for k in range(ceil(low), floor(high) + 1)]
        return [q if q in values else None for q in given]

    def _set(self, r: Json, s: State) -> tuple[int, int, int]:
        name = r["var"]
        ends = [whole(q / self.rates[name] * self.scale) for q in self.ends(r, s)]
        if "to" not in r and ends != sorted(ends, reverse=self.rates[name] < 0):
            raise OutsideFragmentError(f"`{name}` gets a value of an empty range")
        return self.clocks[name], min(ends), max(ends)

    def _allowed(self, target: State | None, sets: Sets, own: Sequence[str] | None) -> Formula:
        """Where some outcome lies in the domain of the target."""
        if target is None:
            return True
        z = self.domain(target) if own is None else self._closed_zone([p + target[self.slots[p]] for p in own], target)
        for clock, low, high in sets:
            ends = conjunction([(0, clock, 1 - 2 * low), (clock, 0, 1 + 2 * high)])
            found = self.space.meet(z, ends) if z is not None else []
            z = self.space.forget(found[0], clock) if found else None
        return False if z is None else self.space.formula(z)

    def fires(self, s: State) -> list[tuple[Move, Formula]]:
        """The moves and where each may be made: urgent ones also where they are about to be enabled (S8)."""
        if s not in self._fires:
            self._fires[s] = [(m, disjunction([m.where, *self._soon(m)])) for m in self.moves(s)]
        return self._fires[s]

    def _soon(self, m: Move) -> Iterator[Formula]:
        if m.is_urgent:
            for z in self.space.meet(self.space.everything, m.where):
                yield from (self.space.formula(q) for q in self.space.about_to_enter(z))

    def stops(self, s: State) -> list[Zone]:
        """Where an urgent interaction is enabled."""
        if s not in self._stops:
            zones = [z for m in self.moves(s) if m.is_urgent for z in self.space.meet(self.space.everything, m.where)]
            self._stops[s] = list(dict.fromkeys(zones))
        return self._stops[s]

    # ---- what follows ----

    def jumps(self, s: State, z: Zone) -> Iterator[tuple[Move, Zone, Zone]]:
        """The jumps from a zone: the move, the part of the zone it is made from, and where that lands."""
        for m, where in self.fires(s):
            for part in self.space.meet(z, where):
                if m.target is None:
                    raise OutsideFragmentError(
                        f"`{m.event.names[0]}` may give a variable a value that its type does not have"
                    )
                landed = self.in_domain(m.target, self.space.assigned(part, m.sets))
                if landed is not None:
                    yield m, part, landed

    def dwells(self, s: State, z: Zone) -> Iterator[Dwell]:
        """What a zone inside the domain becomes as time passes: in the domain, up to what is urgent (S7, S8)."""
        space = self.space
        waiting: list[tuple[Zone, list[Zone]]] = [(z, [])]
        for stop in self.stops(s):
            before, split = space.earlier(stop), list[tuple[Zone, list[Zone]]]()
            for q, ends in waiting:
                yield from (Dwell(p, p, False) for p in space.meet(q, space.formula(stop)))
                for rest in space.without(q, stop):
                    split += [(p, [*ends, stop]) for p in space.meet(rest, space.formula(before))]
                    split += [(p, ends) for p in space.without(rest, before)]
            waiting = split
        for q, ends in waiting:
            held = self.in_domain(s, space.later(q))
            zones = [held] if held is not None else []
            for stop in ends:
                ahead = [p for y in zones for p in space.meet(y, space.formula(space.earlier(stop)))]
                zones = [p for y in ahead for p in space.without(y, space.strictly_later(stop))]
            yield from (Dwell(q, p) for p in zones)

    def is_terminal(self, s: State) -> bool:
        """May runs end here (S12, S13)?"""
        return all(a.prefix + s[k] in self.terminal for k, a in enumerate(self.automata))

    def stuck(self, s: State) -> Formula:
        """Where no time can pass and nothing can fire (S12)."""
        d, n = self.domain(s), self.space.n
        if d is None or self.is_terminal(s):
            return False
        ends = disjunction((0, c, -2 * (d[c * n] >> 1) + 1) for c in range(1, n) if d[c * n] < 1 << 60)
        if ends is False:
            return False
        return conjunction([self.space.formula(d), ends, *(negation(f) for _, f in self.fires(s))])


def part_of(edge: str) -> str:
    """`part.` of `part.edge`."""
    return edge.rpartition(".")[0] + "."


def mentioned(e: Json) -> set[str]:
    """The variables and modes that an expression reads."""
    if not isinstance(e, list):
        return set()
    return {e[1]} if e[0] in ("var", "at") else {n for x in e[1:] for n in mentioned(x)}


def between(low: Fraction | None, q: Fraction, high: Fraction | None) -> bool:
    return (low is None or holds("<=", low - q)) and (high is None or q <= high)


def _both(a: Json, b: Json) -> Json:
    return b if a is True or a == b else a if b is True else ["and", a, b]


def _hashed(x: tuple[str, str, Json]) -> tuple[str, tuple[str, str, Json]]:
    return repr(x), x
