"""A system taken apart: its parts under their full names, what they read of each other, which edges fire together."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import Any, NamedTuple

from hacheck.core import Core, by_name
from hacheck.expressions import ARITY, nodes
from hacheck.rational import Beyond, Refused, number, spend

Json = Any


class Edge(NamedTuple):
    """An edge of a part, with full names in its guard and resets."""

    name: str
    source: str
    target: str
    urgent: bool
    guard: Json
    resets: list[Json]


class Together(NamedTuple):
    """What fires as one (LANGUAGE S14): edges by name, guards and resets of syncs, listeners that join."""

    name: str
    names: tuple[str, ...]
    edges: tuple[str, ...]
    guards: tuple[Json, ...]
    resets: tuple[Json, ...]
    listeners: tuple[Any, ...]


def own_names(model: Json) -> set[str]:
    """The constants, params and inputs that a model declares."""
    return {x["name"] for key in ("constants", "params", "inputs") for x in model[key]}


class Scope:
    """What names mean in a system or an automaton that is a part; `outer` is where its ports are bound."""

    def __init__(self, core: Core, model: Json, prefix: str, outer: Scope | None, bindings: list[Json]) -> None:
        spend(1000)
        self.core, self.model, self.prefix, self.outer = core, model, prefix, outer
        self.bound = by_name(bindings, "bindings")
        self.constants = by_name(model["constants"], "constants")
        self.parts: dict[str, Scope] = {}
        depth = prefix.count(".")
        for p in model.get("parts", ()):
            found = core.automata.get(p["of"]) or core.systems.get(p["of"])
            if found is None or depth > 8 or p["name"] in self.parts or "." in p["name"]:
                raise Refused("a part of nothing, of too much, or of a name that is none")
            if "parts" in found and any(b["name"] not in own_names(found) for b in p["bindings"]):
                raise Beyond("a system bound a name that it does not declare itself")
            self.parts[p["name"]] = type(self)(core, found, f"{prefix}{p['name']}.", self, p["bindings"])

    def automata(self) -> Iterator[Scope]:
        """The parts that are automata, however deep."""
        if "modes" in self.model:
            yield self
        for p in self.parts.values():
            yield from p.automata()

    def systems(self) -> Iterator[Scope]:
        """This system and those inside."""
        if "modes" not in self.model:
            yield self
        for p in self.parts.values():
            yield from p.systems()

    def flat(self, e: Json) -> Json:
        """An expression in which only variables, modes and numbers are left, under their full names."""
        spend(3)
        if not isinstance(e, list):
            return e
        least, most = ARITY.get(e[0], (0, 10**6))
        if not least <= len(e) - 1 <= most:
            raise Refused(f"`{e[0]!s:.20}` has a wrong number of operands")
        if e[0] in ("const", "param", "input", "let"):
            return self._named(e[0], e[1])
        if e[0] in ("var", "at", "jump"):
            return [e[0], self.prefix + e[1]]
        if e[0] == "sym":
            return str(ordinal(self.core, e[1], e[2]))
        if e[0] == "scale":
            return ["scale", e[1], e[2], self.flat(e[3])]
        return [e[0], *(self.flat(x) for x in e[1:])]

    def _named(self, kind: str, name: str) -> Json:
        head, _, rest = name.partition(".")
        if rest:
            if head not in self.parts:
                raise Refused(f"there is no part {head!a}")
            return self.parts[head]._named(kind, rest)
        if kind == "let":
            return self._let(name)
        if name in self.bound and self.outer is not None:
            if "to" not in self.bound[name]:
                raise Beyond("a part with a constant or port that may have several values")
            return self.outer.flat(self.bound[name]["to"])
        found = self.constants.get(name) or self.core.constants.get(name)
        if kind != "const" or found is None or isinstance(found["value"], dict):
            raise Beyond(f"{kind} {name!a}, which has no single value")
        return self.flat(found["value"])

    def _let(self, name: str) -> Json:
        common = next((o["expr"] for o in self.model["lets"] if o["name"] == name), None)
        out: Json = ["nothing"] if common is None else self.flat(common)
        for m in self.model.get("modes", ()):
            for o in m["lets"]:
                if o["name"] == name:
                    out = ["if", ["at", self.prefix + m["name"]], self.flat(o["expr"]), out]
        return out

    def resets(self, given: list[Json]) -> list[Json]:
        """Assignments with full names."""
        return [{key: self.prefix + e if key == "var" else self.flat(e) for key, e in r.items()} for r in given]

    def edges(self) -> list[Edge]:
        """The edges of an automaton."""
        return [Edge(self.prefix + e["name"], e["source"], e["target"], e["urgent"], self.flat(e["guard"]),
                     self.resets(e["resets"])) for e in self.model["edges"]]  # fmt: skip

    def together(self) -> dict[str, Together]:
        """What this part offers to fire, by name: single edges, or the syncs of a system and what no sync mentions."""
        if "modes" in self.model:
            names = dict.fromkeys(self.prefix + e["name"] for e in self.model["edges"])
            return {n: Together(n, (n,), (n,), (), (), ()) for n in names}
        offered = {n: t for p in self.parts.values() for n, t in p.together().items()}
        mentioned = {self.prefix + n for s in self.model["syncs"] for n in [*s["edges"], *s["listeners"]]}
        out = {n: t for n, t in offered.items() if n not in mentioned}
        for s in self.model["syncs"]:
            made = self._sync(s, offered)
            if made.name in out:
                raise Refused("two interactions of one name")
            out[made.name] = made
        return out

    def _sync(self, s: Json, offered: dict[str, Together]) -> Together:
        names = [self.prefix + n for n in [*s["edges"], *s["listeners"]]]
        if not s["edges"] or any(n not in offered or offered[n].listeners for n in names):
            raise Beyond(f"sync {s['name']!a} joins what is no interaction of a part, or a broadcast")
        given = [offered[n] for n in names]
        first, name = given[: len(s["edges"])], self.prefix + s["name"]
        return Together(
            name, (name, *(m for t in first for m in t.names)), tuple(e for t in first for e in t.edges),
            (*(g for t in first for g in t.guards), self.flat(s["guard"])),
            (*(r for t in first for r in t.resets), *self.resets(s["resets"])), tuple(given[len(s["edges"]) :]),
        )  # fmt: skip

    def priorities(self) -> list[tuple[str, str, Json]]:
        """Pairs of interactions, the first suppressing the second where the condition holds."""
        out = []
        for p in self.model["priorities"]:
            names = [self.prefix + n for n in p["over"]]
            out += [(a, b, self.flat(p["when"])) for k, a in enumerate(names) for b in names[k + 1 :]]
        return out + [found for p in self.parts.values() for found in p.priorities()]


def mentioned(e: Json) -> set[str]:
    """The variables and modes that an expression reads."""
    return {str(n[1]) for n in nodes(e) if n[0] in ("var", "at")}


def ordinal(core: Core, enum: str, value: str) -> Fraction:
    """The number that a value of an enumeration counts as."""
    found = core.enums.get(enum)
    if found is None or value not in found["values"]:
        raise Refused(f"there is no value {value!a} of {enum!a}")
    return number(found["low"] if found["low"] is not None else "0") + int(found["values"].index(value))
