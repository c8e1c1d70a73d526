"""A system as one automaton: modes are those of all parts together, edges the interactions (LANGUAGE S13-S18)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import product
from typing import Any

from haverify.analyses.networks.naming import Edge as PartEdge
from haverify.analyses.networks.naming import Interaction, Place
from haverify.model.claim import Claim
from haverify.model.core import expr_from_json, expr_to_json
from haverify.model.expression import FALSE, TRUE, Expr, rebuild
from haverify.model.hybrid import (
    Assign,
    Edge,
    FlowLine,
    HybridAutomaton,
    Init,
    Input,
    Mode,
    Output,
    Param,
    Priority,
    Range,
    Variable,
)
from haverify.model.spec import Spec
from haverify.model.system import System
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import holder, replace

Json = Any
Combined = tuple[str, ...]

MODES = 2000  # a system with more is not put together
EDGES = 40_000


@holder
class Product:
    """A system of a spec, put together."""

    spec: Spec
    core: Mapping[str, Json]
    name: str

    def __post_init__(self) -> None:
        system = next(s for s in self.core["systems"] if s["name"] == self.name)
        self.root = Place(self.core, system, is_open=True)
        self.places = list(self.root.all())
        self.parts = [p for p in self.places if p.is_automaton]
        self.models: dict[str, HybridAutomaton | System] = {a.name: a for a in self.spec.automata}
        self.models |= {s.name: s for s in self.spec.systems}
        self.edges: dict[str, list[tuple[int, PartEdge]]] = {}
        for k, part in enumerate(self.parts):
            for e in part.edges():
                self.edges.setdefault(e.name, []).append((k, e))
        self.interactions = self.root.interactions()
        self.starts = list(self._starts())
        self.modes, self.joined = self._reached()

    def automaton(self) -> HybridAutomaton:
        """The automaton whose runs are those of the system."""
        inits = tuple(Init(_name(m), where, assigns) for m, where, assigns in self.starts)
        orders = tuple(Priority((a, b), expr_from_json(when)) for a, b, when in self.root.priorities())
        lets = tuple(Output(o.name, o.type, o.unit, self._flat(self.root, o.expr)) for o in self.models[self.name].lets)
        modes = tuple(self._mode(m, lets) for m in self.modes)
        return HybridAutomaton(
            self.name, (), tuple(self._params()), tuple(self._inputs()), tuple(self._variables()), (), inits, modes,
            tuple(self.joined), orders,
        )  # fmt: skip

    def claim(self, claim: Claim) -> Claim:
        """A claim on the system as one on the automaton."""

        def told(e: Expr) -> Expr:
            return self._somewhere(self._flat(self.root, e))

        goals = tuple(replace(g, condition=told(g.condition)) for g in claim.goals)
        return replace(claim, goals=goals, assume=tuple(told(e) for e in claim.assume))

    def _somewhere(self, e: Expr) -> Expr:
        """`at(part.Mode)` as: in one of the modes in which the part is there."""
        if e.op != "at":
            return rebuild(e, self._somewhere)
        found = [Expr("at", (_name(m),)) for m in self.modes if e.name in self._present(m)]
        return FALSE if not found else found[0] if len(found) == 1 else Expr("or", tuple(found))

    def _present(self, modes: Combined) -> set[str]:
        return {p.prefix + m for p, m in zip(self.parts, modes, strict=True)}

    def _flat(self, place: Place, e: Expr) -> Expr:
        return expr_from_json(place.flat(expr_to_json(e)))

    def _here(self, e: Json, modes: Combined) -> Expr:
        """A flat expression with `at` decided for some modes."""
        present = self._present(modes)

        def decided(x: Expr) -> Expr:
            if x.op == "at":
                return TRUE if x.name in present else FALSE
            return rebuild(x, decided)

        return decided(expr_from_json(e))

    # ---- what is declared ----

    def _variables(self) -> Iterator[Variable]:
        for place in self.places:
            for v in self.models[place.model["name"]].vars:
                wide = v.range and Range(self._flat(place, v.range.low), self._flat(place, v.range.high))
                yield Variable(place.prefix + v.name, v.type, v.unit, wide)

    def _params(self) -> Iterator[Param]:
        yield from self.spec.params
        for place in self.places:
            for p in self.models[place.model["name"]].params:
                if p.name not in place.bound:
                    yield replace(p, name=place.prefix + p.name)

    def _inputs(self) -> Iterator[Input]:
        for place in self.places:
            for i in self.models[place.model["name"]].inputs:
                if i.name not in place.bound:
                    yield replace(i, name=place.prefix + i.name)

    # ---- starts, modes, edges ----

    def _starts(self) -> Iterator[tuple[Combined, Expr, tuple[Assign, ...]]]:
        choices = []
        for place in self.places:
            lines = place.model["init"] or [{"mode": None, "where": True, "with": []}]
            names = [m["name"] for m in place.model["modes"]] if place.is_automaton else [None]
            choices.append([(place, i, m) for i in lines for m in names if i["mode"] in (None, m) or m is None])
        for chosen in product(*choices):
            modes = tuple(m for _, _, m in chosen if m is not None)
            where = Expr("and", tuple(self._here(p.flat(i["where"]), modes) for p, i, _ in chosen))
            assigns = tuple(a for p, i, _ in chosen for a in self._assigned(p.resets(i["with"]), modes))
            yield modes, where, assigns

    def _assigned(self, resets: tuple[Json, ...], modes: Combined) -> Iterator[Assign]:
        for r in resets:
            if "to" in r:
                yield Assign(r["var"], self._here(r["to"], modes))
            else:
                yield Assign(r["var"], Range(self._here(r["low"], modes), self._here(r["high"], modes)))

    def _reached(self) -> tuple[list[Combined], list[Edge]]:
        """The modes that edges lead to, guards aside, and these edges."""
        waiting = list(dict.fromkeys(m for m, _, _ in self.starts))
        known, edges = dict.fromkeys(waiting), list[Edge]()
        while waiting:
            modes = waiting.pop()
            for target, edge in self._leaving(modes):
                edges.append(edge)
                if target not in known:
                    known[target] = None
                    waiting.append(target)
            if len(known) > MODES or len(edges) > EDGES:
                raise OutsideFragmentError(f"more than {MODES} modes of all parts together, or {EDGES} edges")
        return list(known), edges

    def _leaving(self, modes: Combined) -> Iterator[tuple[Combined, Edge]]:
        for i in self.interactions.values():
            for first in self._ways(i, modes):
                heard = [(x, w) for x in i.listeners for w in self._ways(x, modes)]
                for joins in product((True, False), repeat=len(heard)):
                    yield self._joined(i, first, list(zip(joins, heard, strict=True)), modes)

    def _ways(self, i: Interaction, modes: Combined) -> Iterator[list[tuple[int, PartEdge]]]:
        """The edges of the current modes that an interaction can consist of."""
        own = [[(k, e) for k, e in self.edges.get(n, ()) if modes[k] == e.source] for n in i.edges]
        yield from (list(way) for way in product(*own))

    def _joined(
        self, i: Interaction, first: list[tuple[int, PartEdge]], heard: list[Any], modes: Combined
    ) -> tuple[Combined, Edge]:
        conditions = [*self._guards(i, first, modes)]
        resets = [*i.resets, *(r for _, e in first for r in e.resets)]
        moved = list(first)
        for joins, (x, way) in heard:
            alone = Expr("and", tuple(self._guards(x, way, modes)) or (TRUE,))
            conditions.append(alone if joins else Expr("not", (alone,)))
            if joins:
                moved += way
                resets += [*x.resets, *(r for _, e in way for r in e.resets)]
        target = list(modes)
        for k, e in moved:
            target[k] = e.target
        after = tuple(target)
        is_urgent = any(e.is_urgent for _, e in moved)
        guard = Expr("and", tuple(conditions)) if conditions else TRUE
        done = tuple(self._assigned(tuple(resets), modes))
        return after, Edge(i.names[0], _name(modes), _name(after), is_urgent, guard, done)

    def _guards(self, i: Interaction, way: list[tuple[int, PartEdge]], modes: Combined) -> Iterator[Expr]:
        for g in (*i.guards, *(e.guard for _, e in way)):
            yield self._here(g, modes)

    def _mode(self, modes: Combined, lets: tuple[Output, ...]) -> Mode:
        here = [next(m for m in p.model["modes"] if m["name"] == n) for p, n in zip(self.parts, modes, strict=True)]
        domain = Expr(
            "and", tuple(self._here(p.flat(m["domain"]), modes) for p, m in zip(self.parts, here, strict=True))
        )
        flows = [(p, m["flow"]) for p, m in zip(self.parts, here, strict=True)]
        flows += [(p, p.model["flow"]) for p in self.places if not p.is_automaton]
        lines = tuple(self._line(p, f, modes) for p, flow in flows for f in flow)
        own = tuple(replace(o, expr=self._here(expr_to_json(o.expr), modes)) for o in lets)
        return Mode(_name(modes), domain, lines, own, all(m["terminal"] for m in here))

    def _line(self, place: Place, f: Json, modes: Combined) -> FlowLine:
        name = place.prefix + f["var"]
        if "rate" in f:
            return FlowLine(name, self._here(place.flat(f["rate"]), modes))
        low, high = (self._here(place.flat(f[k]), modes) for k in ("low", "high"))
        return FlowLine(name, Range(low, high))


def _name(modes: Combined) -> str:
    return " | ".join(modes)
