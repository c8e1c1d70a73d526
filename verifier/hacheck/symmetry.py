"""Parts that can trade places: exchanges under which a system, taken apart, is the same as before."""

from __future__ import annotations

import json
from fractions import Fraction
from typing import Any, NamedTuple

from hacheck.networks import Network
from hacheck.parts import Edge, Scope
from hacheck.rational import Refused, number, spend
from hacheck.readings import State

Json = Any
COMMUTING = ("and", "or", "+", "*", "==", "!=", "min", "max")


class Symmetry:
    """Groups of places that can be exchanged; what is in a place is named by its members, and counts as a value.

    `{members: [[name, ...], ...], values: [q, ...], indexed: [variable, ...]}`: place k has the parts and variables
    `members[k]`; `indexed` variables name a place by its value, and no place by any other.
    """

    def __init__(self, network: Network, groups: Json) -> None:
        self.network = network
        self.groups = [self._group(g) for g in groups]
        once = [n for g in self.groups for m in g["members"] for n in m], [n for g in self.groups for n in g["indexed"]]
        if any(len(set(names)) < len(names) for names in once):
            raise Refused("two groups of places share a name")
        self._renamings: dict[str, Renaming] = {}
        self.model = self._model() if groups else []
        self.exchanges = [(g, k, k + 1) for g in self.groups for k in range(len(g["members"]) - 1)]
        normal = [_normal(e) for e in self.model]
        for g, i, j in self.exchanges:
            spend(100 * len(self.model))
            names, values, indexed = self._exchange(g, i, j)
            if sorted(_normal(_renamed(e, names, values, indexed)) for e in self.model) != sorted(normal):
                raise Refused("parts that the certificate calls interchangeable are not")

    def _group(self, g: Json) -> Json:
        members, values = g["members"], [number(v) for v in g["values"]]
        known = {a.prefix[:-1] for a in self.network.automata} | set(self.network.types)
        flat = [n for m in members for n in m]
        if len(set(flat)) < len(flat) or not set(flat) <= known or len({len(m) for m in members}) > 1:
            raise Refused("a group of places has a name twice, an unknown one, or unlike members")
        if (
            len(set(values)) < len(values)
            or len(values) != len(members)
            or not set(g["indexed"]) <= set(self.network.types)
        ):
            raise Refused("a group of places has not one value for each place")
        indexed = set(g["indexed"])
        if any(len({n in indexed for n in column}) > 1 for column in zip(*members, strict=True)):
            raise Refused("a group of places has unlike members")
        if not all(self.network.typed(n, v) for n in indexed for v in values) or any(
            n in self.network.clocks for n in indexed
        ):
            raise Refused("a variable that names places cannot name all of them")
        return {"members": members, "values": values, "indexed": indexed}

    def _model(self) -> list[Json]:
        """Everything that can be observed of the system, as a list whose order does not matter."""
        net = self.network
        out: list[Json] = [
            ["flow", ["var", n], str(q)] for n, q in net.rates.items() if n in net.clocks and n != "time"
        ]
        out += [["type", ["var", n], t] for n, t in net.types.items()]
        out += [["window", ["var", n], *ends] for n, ends in net.windows.items()]
        out += [["mode", ["at", m], d, m in net.terminal] for m, d in net.domains.items()]
        for o in [*net.root.systems(), *net.automata]:
            out.append(["or", "init", *(_line(o, i) for i in o.model["init"])])
        edges = {n: ["and", *map(_edge, es)] for n, es in net.edges.items()}
        fired = {n: self._fired(t, edges) for n, t in net.together.items()}
        if len({_normal(f) for f in fired.values()}) < len(fired):
            raise Refused("two interactions of a symmetric system are alike")
        out += list(fired.values())
        return out + [["over", fired[a], fired[b], when] for a, b, when in net.over]

    def _fired(self, t: Any, edges: dict[str, Json]) -> Json:
        listeners = ["and", *(self._fired(x, edges) for x in t.listeners)]
        inner = ["and", *(edges[n] for n in t.edges)]
        return ["fire", inner, ["and", *t.guards], ["and", *_assigned(list(t.resets))], listeners]

    def _exchange(self, g: Json, i: int, j: int) -> tuple[dict[str, str], dict[Fraction, Fraction], set[str]]:
        a, b = g["members"][i], g["members"][j]
        values = {g["values"][i]: g["values"][j], g["values"][j]: g["values"][i]}
        return {**dict(zip(a, b, strict=True)), **dict(zip(b, a, strict=True))}, values, g["indexed"]

    def keeps(self, e: Json) -> None:
        """Refuse an expression that some exchange changes."""
        for g, i, j in self.exchanges:
            if _normal(_renamed(e, *self._exchange(g, i, j))) != _normal(e):
                raise Refused("a claim that does not treat interchangeable parts alike")

    def renaming(self, given: Json) -> Renaming:
        """The renaming that puts what is in place k of each group into place given[group][k]."""
        key = json.dumps(given)
        if key not in self._renamings:
            self._renamings[key] = self._made(given)
        return self._renamings[key]

    def _made(self, given: Json) -> Renaming:
        if given and len(given) != len(self.groups):
            raise Refused("a renaming does not speak of each group")
        names: dict[str, str] = {}
        values: dict[str, dict[Any, Any]] = {}
        for g, order in zip(self.groups, given, strict=False):
            if sorted(order) != list(range(len(g["members"]))):
                raise Refused("a renaming is none")
            for k, to in enumerate(order):
                names.update(zip(g["members"][k], g["members"][to], strict=True))
            for v in g["indexed"]:
                values[v] = {q: g["values"][order[k]] for k, q in enumerate(g["values"])}
        slots = [n.removesuffix(".") for n in self.network.slots]
        clocks = self.network.clocks
        return Renaming([slots.index(names.get(n, n)) for n in slots], [values.get(n, {}) for n in slots],
                        [0, *(clocks[names.get(n, n)] for n in clocks)])  # fmt: skip


class Renaming(NamedTuple):
    """Where each slot of a discrete state goes, what its values become, and what each clock is called."""

    slots: list[int]
    values: list[dict[Any, Any]]
    clocks: list[int]

    def state(self, s: State) -> State:
        """The discrete state renamed."""
        new: list[Any] = [None] * len(s)
        for k, known, v in zip(self.slots, self.values, s, strict=True):
            new[k] = known.get(v, v)
        return tuple(new)


def _line(o: Scope, i: Json) -> Json:
    modes = [["at", o.prefix + m["name"]] for m in o.model.get("modes", ()) if i["mode"] in (None, m["name"])]
    return ["line", *modes, o.flat(i["where"]), *_assigned(o.resets(i["with"]))]


def _edge(e: Edge) -> Json:
    part = e.name.rpartition(".")[0]
    ends = [["at", f"{part}.{mode}"] for mode in (e.source, e.target)]
    return ["edge", *ends, e.urgent, e.guard, *_assigned(e.resets)]


def _assigned(resets: list[Json]) -> list[Json]:
    return [
        ["set", ["var", r["var"]], r["to"]] if "to" in r else ["among", ["var", r["var"]], r["low"], r["high"]]
        for r in resets
    ]


def _renamed(e: Json, names: dict[str, str], values: dict[Fraction, Fraction], indexed: set[str]) -> Json:
    """An expression after an exchange; a variable that names places may only be compared with, or set to, a number."""
    spend(3)
    if not isinstance(e, list):
        return e
    if e[0] == "var":
        if e[1] in indexed:
            raise Refused("a variable that names places is used as a number")
        return ["var", names.get(e[1], e[1])]
    if e[0] == "at":
        part, _, mode = e[1].rpartition(".")
        return ["at", f"{names.get(part, part)}.{mode}"]
    if e[0] in ("jump", "jumped", "pre"):
        raise Refused("a claim about jumps, on states up to symmetry")
    if e[0] == "type":
        return ["type", ["var", names.get(e[1][1], e[1][1])], *e[2:]]
    if e[0] in ("==", "!=", "set") and len(e) == 3:
        pair = _pair(e[1], e[2], indexed) or _pair(e[2], e[1], indexed)
        if pair:
            value = values.get(pair[1], pair[1])
            return [e[0], ["var", names.get(pair[0], pair[0])], str(value)]
    return [e[0], *(_renamed(x, names, values, indexed) for x in e[1:])]


def _pair(a: Json, b: Json, indexed: set[str]) -> tuple[str, Fraction] | None:
    if isinstance(a, list) and a[0] == "var" and a[1] in indexed and isinstance(b, str):
        return a[1], number(b)
    return None


def _normal(e: Json) -> str:
    """An expression as text, with the operands of what commutes in one order and each once."""
    spend(3)
    if not isinstance(e, list):
        return json.dumps(e)
    parts = [_normal(x) for x in e[1:]]
    if e[0] in COMMUTING:
        parts = sorted(set(parts) if e[0] in ("and", "or") else parts)
    return f"[{e[0]} {' '.join(parts)}]"
