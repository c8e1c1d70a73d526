"""Names in a system: every expression of its parts with full names, constants, ports and lets put in.

Works on the core (docs/core.md section 3), where the expressions of an automaton that is a part have local names.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any

from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import holder, record

Json = Any


@record
class Edge:
    """An edge of a part: full name, modes, guard and resets with full names."""

    name: str
    source: str
    target: str
    is_urgent: bool
    guard: Json
    resets: tuple[Json, ...]


@record
class Interaction:
    """What fires as one (LANGUAGE S14). `names` are those that `jump(...)` knows it by, the first is its own."""

    names: tuple[str, ...]
    edges: tuple[str, ...]
    guards: tuple[Json, ...] = ()
    resets: tuple[Json, ...] = ()
    listeners: tuple[Interaction, ...] = ()


def _require_own(model: Json, part: Json) -> None:
    """Raise OutsideFragmentError where a system that is a part is bound a name that only its own parts read."""
    own = {x["name"] for key in ("constants", "params", "inputs") for x in model[key]}
    for b in part["bindings"] if "parts" in model else ():
        if b["name"] not in own:
            raise OutsideFragmentError(
                f"`{b['name']}` is bound on part {part['name']}, a system that does not declare it"
            )


@holder
class Place:
    """A system or an automaton in its place: what its names mean; `prefix` is empty or ends with a dot."""

    core: Mapping[str, Json]
    model: Json
    prefix: str = ""
    outer: Place | None = None
    bindings: Sequence[Json] = ()
    is_open: bool = False  # whether params and inputs that nothing binds keep a name, that of their owner before it

    def __post_init__(self) -> None:
        self.bound = {b["name"]: b for b in self.bindings}
        self.constants = {c["name"]: c for c in [*self.core["constants"], *self.model["constants"]]}
        models = {m["name"]: m for m in [*self.core["automata"], *self.core["systems"]]}
        for p in self.model.get("parts", ()):
            _require_own(models[p["of"]], p)
        self.parts = {p["name"]: self._part(models[p["of"]], p) for p in self.model.get("parts", ())}

    def _part(self, model: Json, p: Json) -> Place:
        return Place(self.core, model, f"{self.prefix}{p['name']}.", self, p["bindings"], self.is_open)

    @property
    def is_automaton(self) -> bool:
        """An automaton, with modes; else a system, with parts."""
        return "modes" in self.model

    def all(self) -> Iterator[Place]:
        """This and everything inside."""
        yield self
        for p in self.parts.values():
            yield from p.all()

    def flat(self, e: Json) -> Json:
        """An expression of this place with full names; constants, ports, lets and values of enumerations are put in."""
        if not isinstance(e, list):
            return e
        op, args = e[0], e[1:]
        if isinstance(op, list):  # arguments with names, of a fuzzy system
            return [[name, self.flat(x)] for name, x in e]
        if op in ("const", "param", "input", "let"):
            return self._meaning(op, args[0])
        if op in ("var", "at", "jump"):
            return [op, self.prefix + args[0]]
        if op == "sym" and self.is_open:
            return e
        if op == "sym":
            return str(self._ordinal(*args))
        if op == "scale":
            return [op, args[0], args[1], self.flat(args[2])]
        return [op, *map(self.flat, args)]

    def _ordinal(self, enum: str, value: str) -> Fraction:
        found = next(e for e in self.core["enums"] if e["name"] == enum)
        return Fraction(found["low"] or 0) + int(found["values"].index(value))

    def _meaning(self, kind: str, name: str) -> Json:
        head, _, rest = name.partition(".")
        if rest:
            return self.parts[head]._meaning(kind, rest)
        if kind == "let":
            return self._let(name)
        bound = self.bound.get(name)
        if bound is not None and self.outer is not None:
            if not isinstance(bound["to"], dict):
                return self.outer.flat(bound["to"])
            if self.is_open and kind in ("param", "input") and name in self._own(kind):
                return [kind, self.prefix + name]
            raise OutsideFragmentError(
                f"`{name}` of part {self.prefix[:-1]} is bound to a range; systems need one value"
            )
        if self.is_open and kind in ("param", "input"):
            return [kind, (self.prefix if name in self._own(kind) else "") + name]
        found = self.constants.get(name)
        if kind != "const" or found is None or isinstance(found["value"], dict):
            word = {"const": "the interval constant", "param": "the param"}.get(kind, "the input")
            raise OutsideFragmentError(
                f"{word} `{self.prefix}{name}`: numbers in a system need to be fixed; bind it to one value"
            )
        return self.flat(found["value"])

    def _own(self, kind: str) -> set[str]:
        """The params or inputs that are declared here."""
        return {x["name"] for x in self.model[f"{kind}s"]}

    def _let(self, name: str) -> Json:
        """What a let stands for: by mode; where each mode has its own, that of the last is not asked for."""
        common = next((o["expr"] for o in self.model["lets"] if o["name"] == name), None)
        modes = self.model.get("modes", ())
        cases = [(m["name"], o["expr"]) for m in modes for o in m["lets"] if o["name"] == name]
        out: Json = ["undefined", self.prefix + name] if common is None else self.flat(common)
        if common is None and self.is_open and modes and len(cases) == len(modes):
            out = self.flat(cases.pop()[1])
        for mode, e in cases:
            out = ["if", ["at", self.prefix + mode], self.flat(e), out]
        return out

    def resets(self, given: Sequence[Json]) -> tuple[Json, ...]:
        """Assignments with full names."""
        return tuple({k: self.prefix + e if k == "var" else self.flat(e) for k, e in r.items()} for r in given)

    def edges(self) -> list[Edge]:
        """The edges of an automaton."""
        return [
            Edge(
                self.prefix + e["name"],
                e["source"],
                e["target"],
                e["urgent"],
                self.flat(e["guard"]),
                self.resets(e["resets"]),
            )
            for e in self.model["edges"]
        ]

    def interactions(self) -> dict[str, Interaction]:
        """What can fire here, by name: the edges of an automaton; the syncs of a system and what no sync mentions."""
        if self.is_automaton:
            names = dict.fromkeys(self.prefix + e["name"] for e in self.model["edges"])
            return {n: Interaction((n,), (n,)) for n in names}
        offered = {n: i for p in self.parts.values() for n, i in p.interactions().items()}
        taken = {self.prefix + n for s in self.model["syncs"] for n in (*s["edges"], *s["listeners"])}
        free = {n: i for n, i in offered.items() if n not in taken}
        return free | {self.prefix + s["name"]: self._sync(s, offered) for s in self.model["syncs"]}

    def _sync(self, s: Json, offered: Mapping[str, Interaction]) -> Interaction:
        for n in (*s["edges"], *s["listeners"]):
            if self.prefix + n not in offered:
                raise OutsideFragmentError(
                    f"sync {s['name']} joins {n}, which fires only together with others in its part"
                )
            if offered[self.prefix + n].listeners:
                raise OutsideFragmentError(f"sync {s['name']} joins the broadcast {n}")
        first = [offered[self.prefix + n] for n in s["edges"]]
        return Interaction(
            (self.prefix + s["name"], *(n for i in first for n in i.names)),
            tuple(e for i in first for e in i.edges),
            (*(g for i in first for g in i.guards), self.flat(s["guard"])),
            (*(r for i in first for r in i.resets), *self.resets(s["resets"])),
            tuple(offered[self.prefix + n] for n in s["listeners"]),
        )

    def priorities(self) -> list[tuple[str, str, Json]]:
        """(higher, lower, where) of all priorities here and inside."""
        found = []
        for p in self.model["priorities"]:
            names = [self.prefix + n for n in p["over"]]
            found += [(a, b, self.flat(p["when"])) for k, a in enumerate(names) for b in names[k + 1 :]]
        return found + [x for p in self.parts.values() for x in p.priorities()]
