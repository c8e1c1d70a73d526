"""A system as one automaton, put together from the core alone (LANGUAGE S13 to S18, docs/core.md section 7).

Modes are those of all parts at once, as far as edges lead from the starts; those that a certificate does not name are
there, as where edges lead to, and are not left: `open`. Nothing may be shown in them. What is claimed to be inductive
speaks of all modes, also of those that no edge leads to (S22): these are there if `everywhere`.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from math import prod
from typing import Any, NamedTuple

from hacheck.core import Core
from hacheck.folding import earlier, joined, known, negation, only_known, weakened
from hacheck.parts import Edge, Scope, Together, mentioned
from hacheck.rational import Beyond, Refused, spend

Json = Any
Modes = tuple[str, ...]
MOST = 4000  # chains of priorities, and modes


class Named(Scope):
    """A part whose params and inputs keep names of their own, where nothing gives them one value."""

    def flat(self, e: Json) -> Json:
        """An expression under full names; values of enumerations stay."""
        if isinstance(e, list) and not isinstance(e[0], str):
            raise Beyond("arguments with names, in a system put together")
        return e if isinstance(e, list) and e[0] == "sym" else super().flat(e)

    def _named(self, kind: str, name: str) -> Json:
        if "." in name or kind not in ("param", "input"):
            return super()._named(kind, name)
        given = self.given(name)
        if given is not None and "to" in given:
            return super()._named(kind, name)
        own = any(x["name"] == name for x in self.model[f"{kind}s"])
        if given is not None and not own:
            raise Beyond("a range for a name that the part does not declare")
        return [kind, (self.prefix if own else "") + name]

    def _let(self, name: str) -> Json:
        """What a let stands for: where each mode has its own, that of the last is not asked for."""
        own = [[o["expr"] for o in m["lets"] if o["name"] == name] for m in self.model.get("modes", ())]
        if any(o["name"] == name for o in self.model["lets"]) or not all(own) or not own:
            return super()._let(name)
        out = self.flat(own[-1][0])
        for m, (e, *_) in zip(self.model["modes"][:-1], own[:-1], strict=True):
            out = ["if", ["at", self.prefix + m["name"]], self.flat(e), out]
        return out

    def given(self, name: str) -> Json:
        """What the name is bound to from outside, if it is."""
        return self.bound.get(name) if self.outer is not None else None

    def declared(self, kind: str) -> Iterator[Json]:
        """Its params or inputs that have no one value, under full names, with their ranges."""
        for x in self.model[kind]:
            given = self.given(x["name"])
            if given is None or "to" not in given:
                scope, ends = (self, x) if given is None or self.outer is None else (self.outer, given)
                low, high = (None if ends[k] is None else scope.flat(ends[k]) for k in ("low", "high"))
                yield {**x, "name": self.prefix + x["name"], "low": low, "high": high}

    def everything(self) -> Iterator[Named]:
        """This and all parts inside, the outer ones first."""
        yield self
        for p in self.parts.values():
            assert isinstance(p, Named)
            yield from p.everything()


class Joint(NamedTuple):
    """A way to fire in one mode of all parts: its names, where, what is assigned, where it leads."""

    name: str
    names: tuple[str, ...]
    urgent: bool
    guard: Json
    resets: list[Json]
    target: Modes


class Composed:
    """The automaton of a system; `left` are the modes whose edges are listed, None for all."""

    def __init__(self, core: Core, system: Json, left: frozenset[str] | None = None, everywhere: bool = False) -> None:
        self.root = Named(core, system, "", None, [])
        self.places = list(self.root.everything())
        self.automata = [p for p in self.places if "modes" in p.model]
        self.modes = [{m["name"]: m for m in p.model["modes"]} for p in self.automata]
        self.domains = {p.prefix + m["name"]: p.flat(m["domain"]) for p in self.automata for m in p.model["modes"]}
        self.edges: dict[str, list[tuple[int, Edge]]] = {}
        for k, p in enumerate(self.automata):
            for e in p.edges():
                self.edges.setdefault(e.name, []).append((k, e))
        self.together = self.root.together()
        self.over = self._chains()
        self.jumps: dict[str, tuple[str, ...]] = {}
        starts = list(self._starts())
        found: dict[Modes, list[Joint] | None] = dict.fromkeys(m for m, _, _ in starts)
        if everywhere:
            found.update(dict.fromkeys(self._all_modes()))
        waiting = list(found)
        for modes in waiting:  # which grows
            if left is not None and self.name(modes) not in left:
                continue
            found[modes] = joints = list(self._leaving(modes))
            self.jumps.update({j.name: j.names for j in joints})
            new = [t for t in dict.fromkeys(j.target for j in joints) if t not in found]
            found.update(dict.fromkeys(new))
            waiting += new
            if len(found) > MOST:
                raise Beyond("a system of too many modes")
        self.found, self.names = found, {m: self.name(m) for m in found}
        self.open = frozenset(n for m, n in self.names.items() if found[m] is None)
        if left is not None and left - set(self.names.values()):
            raise Refused("a certificate names a mode of a system to which no edges lead")
        self.automaton = self._automaton(starts)

    def _all_modes(self) -> Iterator[Modes]:
        if prod(map(len, self.modes)) > MOST:
            raise Beyond("a system of too many modes")
        spend(10 * prod(map(len, self.modes)))
        return product(*self.modes)

    def name(self, modes: Modes) -> str:
        """The name of a mode of all parts."""
        return ", ".join(p.prefix + m for p, m in zip(self.automata, modes, strict=True))

    def _here(self, modes: Modes) -> frozenset[str]:
        return frozenset(p.prefix + m for p, m in zip(self.automata, modes, strict=True))

    def claim(self, claim: Json) -> Json:
        """A claim on the system as one on its automaton."""

        def told(e: Json) -> Json:
            return None if e is None else self._placed(only_known(self.root.flat(e)))

        goals = [{**g, "condition": told(g["condition"]), "within": told(g["within"]),
                  "window": g["window"] and [told(e) for e in g["window"]]} for g in claim["goals"]]  # fmt: skip
        horizon = {**claim["horizon"], "time": told(claim["horizon"]["time"])}
        return {**claim, "goals": goals, "assume": [told(e) for e in claim["assume"]], "horizon": horizon}

    def _placed(self, e: Json) -> Json:
        """`at` of a part as one of the modes in which it is there, `jump` as one of the edges that it is part of."""
        spend(2)
        if not isinstance(e, list):
            return e
        if e[0] == "at":
            some = [["at", n] for m, n in self.names.items() if e[1] in self._here(m)]
        elif e[0] == "jump":
            some = [["jump", n] for n, names in self.jumps.items() if e[1] in names]
        else:
            return [e[0], *(self._placed(a) for a in e[1:])]
        spend(10 * len(self.names))
        return joined("or", some)

    # ---- what fires ----

    def _chains(self) -> dict[str, list[tuple[str, Json]]]:
        """For each interaction those that silence it, with where, along all chains (S17)."""
        direct = self.root.priorities()
        if any(n not in self.together for a, b, _ in direct for n in (a, b)):
            raise Beyond("a priority among edges that fire only together with others")
        found = list(direct)
        for a, b, g in found:  # which grows
            for c, d, h in direct:
                longer = a, d, joined("and", [g, h])
                if b == c and longer not in found:
                    found.append(longer)
            spend(10 * len(found))
            if len(found) > MOST or a == b:
                raise Refused("priorities in a circle, or too many chains of them")
        return {n: [(a, g) for a, b, g in found if b == n] for n in self.together}

    def _leaving(self, modes: Modes) -> Iterator[Joint]:
        here, ready = self._here(modes), dict[str, Json]()
        ways = {n: list(self._ways(t, modes)) for n, t in self.together.items()}
        for n, joints in ways.items():
            silenced = []
            for a, when in self.over[n] if joints else ():
                if a not in ready:
                    ready[a] = joined("or", [self._enabled(j) for j in ways[a]])
                silenced.append(joined("and", [known(when, here), ready[a]]))
            free = negation(joined("or", silenced))
            for j in joints:
                guard = joined("and", [j.guard, free])
                if guard is not False:
                    yield j._replace(guard=only_known(guard))

    def _enabled(self, j: Joint) -> Json:
        """Where the guard holds, and the outcome lies in the domain of the target (S9)."""
        here = self._here(j.target)
        domain = known(joined("and", [self.domains[n] for n in sorted(here)]), here)
        return joined("and", [j.guard, earlier(weakened(domain), j.resets)])

    def _taken(self, t: Together, modes: Modes) -> Iterator[list[tuple[int, Edge]]]:
        given = [[(k, e) for k, e in self.edges[n] if e.source == modes[k]] for n in t.edges]
        yield from map(list, product(*given))

    def _ways(self, t: Together, modes: Modes) -> Iterator[Joint]:
        """With each choice of the listeners that join, the others being unable to (S14)."""
        here = self._here(modes)
        for first in self._taken(t, modes):
            heard = [(x, w, self._able(x, w)) for x in t.listeners for w in self._taken(x, modes)]
            for chosen in product((True, False), repeat=len(heard)):
                spend(50)
                join = [(x, w) for yes, (x, w, _) in zip(chosen, heard, strict=True) if yes]
                able = [a if yes else negation(a) for yes, (_, _, a) in zip(chosen, heard, strict=True)]
                guards = [*t.guards, *(e.guard for _, e in first), *able]
                yield self._joint(t, [(t, first), *join], known(joined("and", guards), here), modes)

    def _able(self, t: Together, way: list[tuple[int, Edge]]) -> Json:
        """Where a listener may join: its guards hold, and its outcome lies in the domain of its own parts."""
        domains = []
        for k, e in way:
            prefix = self.automata[k].prefix
            if any(not n.startswith(prefix) for n in mentioned(self.domains[prefix + e.target])):
                raise Beyond("a listener whose domain reads other parts")
            own = frozenset(self.automata[i].prefix + x.target for i, x in way)
            domains.append(weakened(known(self.domains[prefix + e.target], own)))
        resets = [*t.resets, *(r for _, e in way for r in e.resets)]
        return joined("and", [*t.guards, *(e.guard for _, e in way), earlier(joined("and", domains), resets)])

    def _joint(self, t: Together, taking: list[Any], guard: Json, modes: Modes) -> Joint:
        edges = [ke for _, way in taking for ke in way]
        resets = [r for x, way in taking for r in (*x.resets, *(r for _, e in way for r in e.resets))]
        if len({k for k, _ in edges}) < len(edges) or len({r["var"] for r in resets}) < len(resets):
            raise Refused("an interaction takes two edges of a part, or writes a variable twice")
        others = [x.names[0] for x, _ in taking[1:]]
        after = {k: e.target for k, e in edges}
        return Joint(
            t.names[0] + " with " * bool(others) + ", ".join(others), tuple(n for x, _ in taking for n in x.names),
            any(e.urgent for _, e in edges), guard, self._settled(resets, modes),
            tuple(after.get(k, m) for k, m in enumerate(modes)),
        )  # fmt: skip

    def _settled(self, resets: list[Json], modes: Modes) -> list[Json]:
        here = self._here(modes)
        return [{k: e if k == "var" else only_known(known(e, here)) for k, e in r.items()} for r in resets]

    # ---- what it is ----

    def _starts(self) -> Iterator[tuple[Modes, Json, list[Json]]]:
        choices = []
        for p in self.places:
            lines = p.model["init"] or [{"mode": None, "where": True, "with": []}]
            names = [m["name"] for m in p.model["modes"]] if "modes" in p.model else [None]
            choices.append([(p, i, m) for i in lines for m in names if m is None or i["mode"] in (None, m)])
        for chosen in product(*choices):
            spend(100)
            modes = tuple(m for _, _, m in chosen if m is not None)
            here = self._here(modes)
            where = joined("and", [known(p.flat(i["where"]), here) for p, i, _ in chosen])
            resets = [r for p, i, _ in chosen for r in self._settled(p.resets(i["with"]), modes)]
            if where is not False:
                yield modes, only_known(where), resets

    def _automaton(self, starts: list[tuple[Modes, Json, list[Json]]]) -> Json:
        variables = [{**v, "name": p.prefix + v["name"], **{k: None if v[k] is None else p.flat(v[k])
                      for k in ("low", "high")}} for p in self.places for v in p.model["vars"]]  # fmt: skip
        edges = [{"name": j.name, "source": self.names[m], "target": self.names[j.target], "urgent": j.urgent,
                  "guard": j.guard, "resets": j.resets} for m, js in self.found.items() for j in js or ()]  # fmt: skip
        return {
            "name": self.root.model["name"], "constants": [], "lets": [], "priorities": [], "vars": variables,
            "params": [x for p in self.places for x in p.declared("params")],
            "inputs": [x for p in self.places for x in p.declared("inputs")],
            "init": [{"mode": self.names[m], "where": e, "with": done} for m, e, done in starts],
            "modes": [self._mode(m) for m in self.found], "edges": edges,
        }  # fmt: skip

    def _mode(self, modes: Modes) -> Json:
        here = self._here(modes)
        own = [(p, ms[m]) for p, ms, m in zip(self.automata, self.modes, modes, strict=True)]
        flows = [(p, m["flow"]) for p, m in own]
        flows += [(p, p.model["flow"]) for p in self.places if "modes" not in p.model]
        domain = joined("and", [known(self.domains[p.prefix + m["name"]], here) for p, m in own])
        return {
            "name": self.names[modes], "domain": only_known(domain), "lets": [],
            "terminal": all(m["terminal"] for _, m in own),
            "flow": [self._line(p, f, here) for p, fs in flows for f in fs],
        }  # fmt: skip

    @staticmethod
    def _line(p: Named, f: Json, here: frozenset[str]) -> Json:
        return {k: p.prefix + e if k == "var" else only_known(known(p.flat(e), here)) for k, e in f.items()}
