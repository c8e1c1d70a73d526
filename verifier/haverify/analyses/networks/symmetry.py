"""Interchangeable parts: families `part p for i in I` whose members can trade places without any difference."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from functools import cmp_to_key
from typing import Any

from haverify.analyses.networks.naming import Edge, Interaction
from haverify.analyses.networks.network import Network, part_of
from haverify.analyses.networks.terms import State
from haverify.analyses.networks.zones import Zone
from haverify.maths.digits import rational_text
from haverify.text.record import holder, record

Json = Any
_UNORDERED = frozenset({"and", "or", "+", "*", "==", "!=", "min", "max"})


class _NotAlikeError(Exception):
    """An expression that an exchange cannot be applied to."""


@record
class Group:
    """Places that can be exchanged: the names in each, the number each counts as, the variables that hold numbers."""

    members: tuple[tuple[str, ...], ...]
    values: tuple[Fraction, ...]
    indexed: tuple[str, ...]

    def exchange(self, i: int, j: int) -> Exchange:
        """What is in places i and j trades places."""
        a, b = self.members[i], self.members[j]
        names = dict(zip(a, b, strict=True)) | dict(zip(b, a, strict=True))
        values = {self.values[i]: self.values[j], self.values[j]: self.values[i]}
        return Exchange(names, values, frozenset(self.indexed))

    def only(self, places: Sequence[int]) -> Group:
        """The group with some of its places."""
        return Group(tuple(self.members[k] for k in places), tuple(self.values[k] for k in places), self.indexed)

    def json(self) -> Json:
        """The group as certificates have it."""
        return {
            "members": [list(m) for m in self.members],
            "values": [rational_text(v) for v in self.values],
            "indexed": list(self.indexed),
        }


@holder
class Exchange:
    """A renaming of parts and variables, and of the values of the variables that name them."""

    names: Mapping[str, str]
    values: Mapping[Fraction, Fraction]
    indexed: frozenset[str]

    def applied(self, e: Json) -> Json:
        """An expression after the exchange."""
        if not isinstance(e, list):
            return e
        if e[0] in ("==", "!=", "set") and len(e) == 3:
            for a, b in ((e[1], e[2]), (e[2], e[1])):
                if isinstance(a, list) and a[0] == "var" and a[1] in self.indexed and isinstance(b, str):
                    return [e[0], self._name(a), rational_text(self.values.get(Fraction(b), Fraction(b)))]
        if e[0] in ("jump", "jumped", "pre") or (e[0] == "var" and e[1] in self.indexed):
            raise _NotAlikeError
        if e[0] == "type":
            return ["type", self._name(e[1]), *e[2:]]
        return self._name(e) if e[0] in ("var", "at") else [e[0], *map(self.applied, e[1:])]

    def _name(self, e: Json) -> Json:
        if e[0] == "var":
            return ["var", self.names.get(e[1], e[1])]
        part, _, mode = e[1].rpartition(".")
        return ["at", f"{self.names.get(part, part)}.{mode}"]


@holder
class Renaming:
    """Where slots and clocks go, and what values become."""

    slots: Sequence[int]
    values: Sequence[Mapping[Fraction, Fraction]]
    clocks: Sequence[int]

    def state(self, s: State) -> State:
        """A discrete state renamed."""
        new: list[Any] = [None] * len(s)
        for k, known, v in zip(self.slots, self.values, s, strict=True):
            new[k] = known.get(v, v) if known else v
        return tuple(new)


@holder
class Symmetry:
    """The groups of a network whose exchanges keep it and some conditions the same."""

    network: Network
    groups: tuple[Group, ...]

    def __post_init__(self) -> None:
        net = self.network
        self._names = [n.removesuffix(".") for n in net.slots]
        slot = {n: k for k, n in enumerate(self._names)}
        self._slots = [[[slot[n] for n in m if n in slot] for m in g.members] for g in self.groups]
        self._indexed = [[slot[n] for n in g.indexed] for g in self.groups]
        self._clocks = [[_clocks_of(net, m) for m in g.members] for g in self.groups]
        self._known: dict[tuple[tuple[int, ...], ...], Renaming] = {}

    def canonical(self, s: State, z: Zone) -> tuple[tuple[tuple[int, ...], ...], State, Zone]:
        """A renaming (where each place goes, by group) and what it makes of a state; equal for most that are alike."""
        if not self.groups:
            return (), s, z
        orders = tuple(self._order(g, s, z) for g in range(len(self.groups)))
        renaming = self.renaming(orders)
        return orders, renaming.state(s), self.network.space.renamed(z, renaming.clocks)

    def key(self, s: State) -> Json:
        """What states that differ by exchanges have in common."""
        moved = {k for g in self._slots for m in g for k in m} | {k for g in self._indexed for k in g}
        rest = tuple(v for k, v in enumerate(s) if k not in moved)
        named = tuple(
            s[k] if s[k] not in self.groups[g].values else None for g, ks in enumerate(self._indexed) for k in ks
        )
        return (
            rest,
            named,
            tuple(
                tuple(sorted(self._local(g, k, s) for k in range(len(self._slots[g])))) for g in range(len(self.groups))
            ),
        )

    def _local(self, g: int, place: int, s: State) -> tuple[Any, ...]:
        value = self.groups[g].values[place]
        return (*(s[k] for k in self._slots[g][place]), *(s[k] == value for k in self._indexed[g]))

    def _order(self, g: int, s: State, z: Zone) -> tuple[int, ...]:
        """Where each place of a group goes when they are sorted."""
        n, clocks = self.network.space.n, self._clocks[g]
        local = [self._local(g, k, s) for k in range(len(clocks))]

        def compare(a: int, b: int) -> int:
            if local[a] != local[b]:
                return -1 if local[a] < local[b] else 1
            for x, y in zip(clocks[a], clocks[b], strict=True):
                for p, q in ((z[x * n + y], z[y * n + x]), (z[x * n], z[y * n]), (z[x], z[y])):
                    if p != q:
                        return -1 if p < q else 1
            return a - b

        order = sorted(range(len(clocks)), key=cmp_to_key(compare))
        return tuple(order.index(k) for k in range(len(order)))

    def renaming(self, orders: tuple[tuple[int, ...], ...]) -> Renaming:
        """The renaming that puts what is in place k of group g into place orders[g][k]."""
        if orders not in self._known:
            names, values = dict[str, str](), dict[str, dict[Fraction, Fraction]]()
            for group, order in zip(self.groups, orders, strict=True):
                for k, to in enumerate(order):
                    names |= dict(zip(group.members[k], group.members[to], strict=True))
                for v in group.indexed:
                    values[v] = {q: group.values[order[k]] for k, q in enumerate(group.values)}
            clocks = self.network.clocks
            self._known[orders] = Renaming(
                [self._names.index(names.get(n, n)) for n in self._names],
                [values.get(n, {}) for n in self._names],
                [0, *(clocks[names.get(n, n)] for n in clocks)],
            )
        return self._known[orders]


def _clocks_of(net: Network, member: Sequence[str]) -> list[int]:
    return [net.clocks[n] for n in member if n in net.clocks]


def symmetry_of(network: Network, conditions: Sequence[Json]) -> Symmetry:
    """The largest groups found whose exchanges change neither the network nor any of the conditions."""
    found: list[Group] = []
    try:
        model = list(everything(network))
        normal = sorted(map(normal_form, model))
        whole = [normal_form(e) for e in conditions]
    except RecursionError:
        return Symmetry(network, ())

    def keeps(x: Exchange) -> bool:
        try:
            same = all(normal_form(x.applied(e)) == w for e, w in zip(conditions, whole, strict=True))
            return same and sorted(normal_form(x.applied(e)) for e in model) == normal
        except _NotAlikeError:
            return False

    for group in candidates(network):
        taken = {n for g in found for m in g.members for n in m} | {n for g in found for n in g.indexed}
        if not taken & ({n for m in group.members for n in m} | set(group.indexed)):
            classes = _classes(group, keeps)
            found += [group.only(c) for c in classes[:1]] if group.indexed else [group.only(c) for c in classes]
    return Symmetry(network, tuple(found))


def _classes(group: Group, keeps: Any) -> list[list[int]]:
    """Sets of at least two places that can all be exchanged, the largest first."""
    classes: list[list[int]] = []
    for k in range(len(group.members)):
        for c in classes:
            if keeps(group.exchange(c[0], k)):
                c.append(k)
                break
        else:
            classes.append([k])
    return sorted((c for c in classes if len(c) > 1), key=len, reverse=True)


def candidates(network: Network) -> Iterator[Group]:
    """Families of parts and variables by the enumeration they are indexed with, the largest first."""
    names = [*(a.prefix[:-1] for a in network.automata), *network.types]
    for enum in sorted(network.core["enums"], key=lambda e: -len(e["values"])):
        low = Fraction(enum["low"] or 0)
        values = [low + k for k in range(len(enum["values"]))]
        members = [tuple(_indexed_by(names, v)) for v in enum["values"]]
        inside = {n for m in members for n in m}
        if len(members) < 2 or not members[0] or len({len(m) for m in members}) > 1:
            continue
        if len(inside) < sum(len(m) for m in members):
            continue
        of_type = [
            n for n in network.types
            if n not in inside and n not in network.clocks and set(values) <= set(network.values(n) or ())
            and (network.types[n] == enum["name"] or enum["low"] is not None)
        ]  # fmt: skip
        for indexed in dict.fromkeys((tuple(of_type), ())):
            yield Group(tuple(members), tuple(values), indexed)


def _indexed_by(names: Sequence[str], value: str) -> Iterator[str]:
    """The names with an index of that value, up to it: `p[1].x` has it as much as `p[1]`."""
    return (n for n in names if f"[{value}]" in n)


def everything(network: Network) -> Iterator[Json]:
    """All that can be observed of a network, in no order."""
    for n, q in network.rates.items():
        if n in network.types:
            yield ["flow", ["var", n], rational_text(q)]
    for n, kind in network.types.items():
        yield ["type", ["var", n], kind]
        ends = network.windows.get(n, (None, None))
        if ends != (None, None):
            yield ["window", ["var", n], *(None if q is None else rational_text(q) for q in ends)]
    for m, domain in network.domains.items():
        yield ["mode", ["at", m], domain, m in network.terminal]
    for p in network.places:
        yield ["or", "init", *(_line(p, i) for i in p.model["init"])]
    fired = {n: _fired(network, i) for n, i in network.interactions.items()}
    if len({normal_form(f) for f in fired.values()}) < len(fired):
        yield ["jumped"]  # which no exchange takes: two interactions alike could not be told apart in priorities
    yield from fired.values()
    for n, above in network.over.items():
        yield from (["over", fired[a], fired[n], when] for a, when in above)


def _line(p: Any, i: Json) -> Json:
    modes = [["at", p.prefix + m["name"]] for m in p.model.get("modes", ()) if i["mode"] in (None, m["name"])]
    return ["line", *modes, p.flat(i["where"]), *_assigned(p.resets(i["with"]))]


def _fired(network: Network, i: Interaction) -> Json:
    edges = [["and", *(_edge(e) for e in network.edges[n])] for n in i.edges]
    listeners = ["and", *(_fired(network, x) for x in i.listeners)]
    return ["fire", ["and", *edges], ["and", *i.guards], ["and", *_assigned(i.resets)], listeners]


def _edge(e: Edge) -> Json:
    part = part_of(e.name)
    return ["edge", ["at", part + e.source], ["at", part + e.target], e.is_urgent, e.guard, *_assigned(e.resets)]


def _assigned(resets: Sequence[Json]) -> list[Json]:
    return [
        ["set", ["var", r["var"]], r["to"]] if "to" in r else ["among", ["var", r["var"]], r["low"], r["high"]]
        for r in resets
    ]


def normal_form(e: Json) -> str:
    """An expression as text, the operands of what commutes in one order and each once where that is the same."""
    if not isinstance(e, list):
        return json.dumps(e)
    parts = [normal_form(x) for x in e[1:]]
    if e[0] in _UNORDERED:
        parts = sorted(set(parts) if e[0] in ("and", "or") else parts)
    return f"({e[0]} {' '.join(parts)})"
