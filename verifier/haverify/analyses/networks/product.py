"""A system as one automaton: modes are those of all parts together, edges the interactions (LANGUAGE S13-S18).

How it is put together, name by name and in which order, is docs/core.md section 7.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from itertools import product
from math import prod
from typing import Any

from haverify.analyses.networks.folding import assigned, both, closed, denied, either, expression, settled
from haverify.analyses.networks.naming import Edge as PartEdge
from haverify.analyses.networks.naming import Interaction, Place
from haverify.analyses.networks.network import mentioned, part_of
from haverify.model.claim import Claim
from haverify.model.core import expr_to_json
from haverify.model.expression import FALSE, Expr, rebuild
from haverify.model.hybrid import Assign, Edge, FlowLine, HybridAutomaton, Init, Input, Mode, Output, Param, Range
from haverify.model.hybrid import Variable as Var
from haverify.model.spec import Spec
from haverify.model.system import System
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import field, holder, record, replace

Json = Any
Combined = tuple[str, ...]
Ways = list[tuple[int, PartEdge]]

MODES = 2000  # a system with more is not put together
EDGES = 40_000
JOINING = " with "


class TooManyError(OutsideFragmentError):
    """A system has too many modes, or edges, to be put together."""


@record
class Joint:
    """An interaction in one mode of all parts together: who fires, where, what is assigned, and where it leads."""

    name: str
    names: tuple[str, ...]
    is_urgent: bool
    guard: Json
    resets: tuple[Json, ...]
    target: Combined


@holder
class Product:
    """A system of a spec, put together."""

    spec: Spec
    core: Mapping[str, Json]
    name: str
    # The modes whose edges are listed, None for all; the others are `open`.
    left: frozenset[str] | None = None
    most: int = MODES
    # Whether modes that no edge leads to are listed too: what is claimed to be inductive (S22) speaks of them.
    everywhere: bool = False
    open: set[str] = field(default_factory=set)
    _joints: dict[Combined, list[Joint]] = field(default_factory=dict)
    _kept: dict[tuple[Combined, bool], Mode] = field(default_factory=dict)

    def __post_init__(self) -> None:
        system = next(s for s in self.core["systems"] if s["name"] == self.name)
        self.root = Place(self.core, system, is_open=True)
        self.places = list(self.root.all())
        self.parts = [p for p in self.places if p.is_automaton]
        self.models: dict[str, HybridAutomaton | System] = {a.name: a for a in self.spec.automata}
        self.models |= {s.name: s for s in self.spec.systems}
        self.domains = {p.prefix + m["name"]: p.flat(m["domain"]) for p in self.parts for m in p.model["modes"]}
        self.edges: dict[str, list[tuple[int, PartEdge]]] = {}
        for k, part in enumerate(self.parts):
            for e in part.edges():
                self.edges.setdefault(e.name, []).append((k, e))
        self.interactions = self.root.interactions()
        self.names: dict[str, tuple[str, ...]] = {}
        self.starts = list(self._starts())
        self.started = frozenset(self.named(m) for m, _, _ in self.starts)
        if self.left is not None:
            self.left |= self.started
        self.modes, self.joined = self._reached()

    def list_edges(self, modes: Iterable[str]) -> None:
        """List the edges of the modes of starts and of these."""
        self.left = self.started | frozenset(modes)
        self.modes, self.joined = self._reached()

    def automaton(self, with_lets: bool = True) -> HybridAutomaton:
        """The automaton whose runs are those of the system; its lets are those of the system."""
        inits = tuple(
            Init(self.named(m), expression(where), tuple(self._assigns(assigns))) for m, where, assigns in self.starts
        )
        own = self.models[self.name].lets if with_lets else ()
        lets = [(o, self.root.flat(expr_to_json(o.expr))) for o in own]
        modes = tuple(self._mode_once(m, lets) for m in self.modes)
        edges = tuple(
            Edge(j.name, self.named(m), self.named(j.target), j.is_urgent, expression(j.guard), done)
            for m, j in self.joined for done in [tuple(self._assigns(j.resets))]
        )  # fmt: skip
        return HybridAutomaton(
            self.name, (), tuple(self._params()), tuple(self._inputs()), tuple(self._variables()), (), inits, modes,
            edges, (), is_system=True, open=frozenset(self.open),
        )  # fmt: skip

    def claim(self, claim: Claim) -> Claim:
        """A claim on the system as one on the automaton."""

        def told(e: Expr | None) -> Any:
            return None if e is None else self._somewhere(self._flat(self.root, e))

        goals = tuple(
            replace(
                g, condition=told(g.condition), within=told(g.within),
                window=g.window and (told(g.window[0]), told(g.window[1])),
            ) for g in claim.goals
        )  # fmt: skip
        return replace(claim, goals=goals, assume=tuple(told(e) for e in claim.assume), time=told(claim.time))

    def named(self, modes: Combined) -> str:
        """The name of a mode of all parts together."""
        return ", ".join(p.prefix + m for p, m in zip(self.parts, modes, strict=True))

    def _somewhere(self, e: Expr) -> Expr:
        """`at(part.Mode)` as: in one of the modes in which the part is there; `jump(n)`: by one of the edges with n."""
        if e.op == "at":
            found = [Expr("at", (self.named(m),)) for m in self.modes if e.name in self._present(m)]
        elif e.op == "jump":
            found = [Expr("jump", (n,)) for n, names in self.names.items() if e.name in names]
        else:
            return rebuild(e, self._somewhere)
        return FALSE if not found else found[0] if len(found) == 1 else Expr("or", tuple(found))

    def _present(self, modes: Combined) -> frozenset[str]:
        return frozenset(p.prefix + m for p, m in zip(self.parts, modes, strict=True))

    def _flat(self, place: Place, e: Expr) -> Expr:
        flat = expression(place.flat(expr_to_json(e)))
        return replace(flat, unit=e.unit, span=e.span)

    # ---- what is declared ----

    def _variables(self) -> Iterator[Var]:
        for place in self.places:
            for v in self.models[place.model["name"]].vars:
                wide = v.range and Range(self._flat(place, v.range.low), self._flat(place, v.range.high))
                yield Var(place.prefix + v.name, v.type, v.unit, wide)

    def _params(self) -> Iterator[Param]:
        """Params of the parts that are not bound to a value; those of the spec stay where they are."""
        yield from (self._own(place, p) for place in self.places for p in self._declared(place).params
                    if self._is_free(place, p.name))  # fmt: skip

    def _inputs(self) -> Iterator[Input]:
        yield from (self._own(place, i) for place in self.places for i in self._declared(place).inputs
                    if self._is_free(place, i.name))  # fmt: skip

    def _declared(self, place: Place) -> HybridAutomaton | System:
        return self.models[place.model["name"]]

    def _is_free(self, place: Place, name: str) -> bool:
        return name not in place.bound or isinstance(place.bound[name]["to"], dict)

    def _own(self, place: Place, x: Any) -> Any:
        """A param or an input under its full name, with the range that it is bound to where there is one."""
        given = place.bound[x.name]["to"] if x.name in place.bound else None
        if given is not None and place.outer is not None:
            ends = [expression(place.outer.flat(given[k])) for k in ("low", "high")]
            return replace(x, name=place.prefix + x.name, range=Range(ends[0], ends[1]))
        flat = x.range and Range(self._flat(place, x.range.low), self._flat(place, x.range.high))
        return replace(x, name=place.prefix + x.name, range=flat)

    # ---- starts, modes, edges ----

    def _starts(self) -> Iterator[tuple[Combined, Json, tuple[Json, ...]]]:
        choices = []
        for place in self.places:
            lines = place.model["init"] or [{"mode": None, "where": True, "with": []}]
            names = [m["name"] for m in place.model["modes"]] if place.is_automaton else [None]
            choices.append([(place, i, m) for i in lines for m in names if i["mode"] in (None, m) or m is None])
        for chosen in product(*choices):
            modes = tuple(m for _, _, m in chosen if m is not None)
            where = both(settled(p.flat(i["where"]), self._present(modes)) for p, i, _ in chosen)
            assigns = tuple(a for p, i, _ in chosen for a in self._settled(p.resets(i["with"]), modes))
            if where is not False:
                yield modes, where, assigns

    def _settled(self, resets: Sequence[Json], modes: Combined) -> list[Json]:
        here = self._present(modes)
        return [{k: e if k == "var" else settled(e, here) for k, e in r.items()} for r in resets]

    @staticmethod
    def _assigns(resets: Sequence[Json]) -> Iterator[Assign]:
        for r in resets:
            if "to" in r:
                yield Assign(r["var"], expression(r["to"]))
            else:
                yield Assign(r["var"], Range(expression(r["low"]), expression(r["high"])))

    def _reached(self) -> tuple[list[Combined], list[tuple[Combined, Joint]]]:
        """The modes that edges lead to, breadth first, guards aside unless they are plainly false; and these edges."""
        found = list(dict.fromkeys(m for m, _, _ in self.starts))
        if self.everywhere:
            found = self._with_all(found)
        known, edges = set(found), list[tuple[Combined, Joint]]()
        self.open.clear()
        self.names.clear()
        for modes in found:  # which grows
            if self.left is not None and self.named(modes) not in self.left:
                self.open.add(self.named(modes))
                continue
            if modes not in self._joints:
                self._joints[modes] = list(self._leaving(modes))
            for joint in self._joints[modes]:
                edges.append((modes, joint))
                self.names[joint.name] = joint.names
                if joint.target not in known:
                    known.add(joint.target)
                    found.append(joint.target)
            if len(found) > self.most or len(edges) > EDGES:
                raise TooManyError(f"more than {self.most} modes of all parts together, or {EDGES} edges")
        return found, edges

    def _with_all(self, first: list[Combined]) -> list[Combined]:
        """These modes, then all others."""
        names = [[m["name"] for m in p.model["modes"]] for p in self.parts]
        if prod(map(len, names)) > self.most:
            raise TooManyError(f"more than {self.most} modes of all parts together")
        return list(dict.fromkeys([*first, *product(*names)]))

    def _leaving(self, modes: Combined) -> Iterator[Joint]:
        """What may fire in a mode, priorities applied (S17)."""
        ways = {n: list(self._ways(i, modes)) for n, i in self.interactions.items()}
        here = self._present(modes)
        ready = dict[str, Json]()
        for n, joints in ways.items():
            above = []
            for a, when in self.over[n] if joints else ():
                if a not in ready:
                    ready[a] = either(self._enabled(j) for j in ways[a])
                above.append(both([settled(when, here), ready[a]]))
            free = denied(either(above))
            for j in joints:
                guard = both([j.guard, free])
                if guard is not False:
                    yield replace(j, guard=guard)

    def _enabled(self, j: Joint) -> Json:
        """Where an interaction is enabled (S9): its guard holds, and it leads into the domain of its target."""
        domain = settled(both(self.domains[n] for n in sorted(self._present(j.target))), self._present(j.target))
        return both([j.guard, assigned(closed(domain), j.resets)])

    @cached_property
    def over(self) -> dict[str, list[tuple[str, Json]]]:
        """For each interaction those that suppress it, and where: all chains of priorities."""
        direct = self.root.priorities()
        for n in (n for a, b, _ in direct for n in (a, b)):
            if n not in self.interactions:
                raise OutsideFragmentError(f"a priority orders `{n}`, which fires only together with others")
        found = list(direct)
        for a, b, g in found:  # which grows
            for c, d, h in direct:
                if b == c and (a, d, both([g, h])) not in found:
                    found.append((a, d, both([g, h])))
            if len(found) > EDGES:
                raise OutsideFragmentError("too many chains of priorities")
        return {n: [(a, g) for a, b, g in found if b == n] for n in self.interactions}

    def _ways(self, i: Interaction, modes: Combined) -> Iterator[Joint]:
        """The ways in which an interaction may fire in a mode: with each choice of its listeners."""
        for first in self._taken(i, modes):
            heard = [(x, w) for x in i.listeners for w in self._taken(x, modes)]
            for joins in product((True, False), repeat=len(heard)):
                yield self._joint(i, first, list(zip(joins, heard, strict=True)), modes)

    def _taken(self, i: Interaction, modes: Combined) -> Iterator[Ways]:
        """The edges of the current modes that an interaction can consist of."""
        own = [[(k, e) for k, e in self.edges.get(n, ()) if modes[k] == e.source] for n in i.edges]
        yield from (list(way) for way in product(*own))

    def _joint(self, i: Interaction, first: Ways, heard: list[Any], modes: Combined) -> Joint:
        moved, resets, names, others = list(first), [*self._written(i, first)], list(i.names), list[str]()
        conditions = [*i.guards, *(e.guard for _, e in first)]
        for joins, (x, way) in heard:
            conditions.append(self._alone(x, way) if joins else denied(self._alone(x, way)))
            if joins:
                moved += way
                resets += self._written(x, way)
                names += x.names
                others.append(x.names[0])
        if len({k for k, _ in moved}) < len(moved) or len({r["var"] for r in resets}) < len(resets):
            raise OutsideFragmentError(f"`{i.names[0]}` takes two edges of one part, or writes a variable twice")
        after = {k: e.target for k, e in moved}
        name = i.names[0] + (JOINING if others else "") + ", ".join(others)
        guard = settled(both(conditions), self._present(modes))
        target = tuple(after.get(k, m) for k, m in enumerate(modes))
        is_urgent = any(e.is_urgent for _, e in moved)
        return Joint(name, tuple(names), is_urgent, guard, tuple(self._settled(resets, modes)), target)

    @staticmethod
    def _written(i: Interaction, way: Ways) -> list[Json]:
        return [*i.resets, *(r for _, e in way for r in e.resets)]

    def _alone(self, x: Interaction, way: Ways) -> Json:
        """Where a listener is enabled by itself: its guards hold, its outcome lies in its own parts' domains."""
        own = [part_of(e.name) + e.target for _, e in way]
        for n, (_, e) in zip(own, way, strict=True):
            if any(not m.startswith(part_of(e.name)) for m in mentioned(self.domains[n])):
                raise OutsideFragmentError(f"the listener `{e.name}` leads to a mode whose domain reads other parts")
        domains = both(closed(settled(self.domains[n], frozenset(own))) for n in own)
        return both([*x.guards, *(e.guard for _, e in way), assigned(domains, self._written(x, way))])

    # ---- one mode ----

    def _mode_once(self, modes: Combined, lets: Sequence[tuple[Output, Json]]) -> Mode:
        key = modes, bool(lets)
        if key not in self._kept:
            self._kept[key] = self._mode(modes, lets)
        return self._kept[key]

    def _mode(self, modes: Combined, lets: Sequence[tuple[Output, Json]]) -> Mode:
        present = self._present(modes)
        here = [next(m for m in p.model["modes"] if m["name"] == n) for p, n in zip(self.parts, modes, strict=True)]
        domain = both(settled(self.domains[p.prefix + m], present) for p, m in zip(self.parts, modes, strict=True))
        flows = [(p, m["flow"]) for p, m in zip(self.parts, here, strict=True)]
        flows += [(p, p.model["flow"]) for p in self.places if not p.is_automaton]
        lines = tuple(self._line(p, f, present) for p, flow in flows for f in flow)
        own = tuple(replace(o, expr=expression(settled(e, present))) for o, e in lets)
        return Mode(self.named(modes), expression(domain), lines, own, all(m["terminal"] for m in here))

    @staticmethod
    def _line(place: Place, f: Json, present: frozenset[str]) -> FlowLine:
        ends = {k: expression(settled(place.flat(e), present)) for k, e in f.items() if k != "var"}
        rate = ends["rate"] if "rate" in ends else Range(ends["low"], ends["high"])
        return FlowLine(place.prefix + f["var"], rate)
