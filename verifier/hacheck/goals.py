"""The parts that an `always` goal comes to, derived from its condition and the automaton."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

from hacheck.expressions import EVENTS, nodes
from hacheck.formula import NEGATED
from hacheck.rational import spend

Json = Any


def conjuncts(e: Json) -> list[Json]:
    """The members of a conjunction; an implication is distributed over those of its conclusion."""
    if isinstance(e, list) and e and e[0] == "and":
        return [c for x in e[1:] for c in conjuncts(x)]
    if isinstance(e, list) and len(e) == 3 and e[0] == "implies":
        return [["implies", e[1], c] for c in conjuncts(e[2])]
    return [e]


def pushed(e: Json) -> Json:
    """An expression with a negation at its top pushed inwards by one level."""
    is_not = isinstance(e, list) and len(e) == 2 and e[0] == "not"
    inner = e[1] if is_not and isinstance(e[1], list) and e[1] else [None]
    if inner[0] == "or":
        return ["and", *(["not", x] for x in inner[1:])]
    if inner[0] == "not":
        return inner[1]
    if inner[0] == "implies":
        return ["and", inner[1], ["not", inner[2]]]
    return [NEGATED[inner[0]], *inner[1:]] if inner[0] in NEGATED else e


class Part(NamedTuple):
    """One part of an `always` goal; `place` is a mode's name or an edge's index."""

    kind: str
    where: str
    output: str
    place: Any
    conjuncts: list[Json]


def parts(a: Json, condition: Json) -> Iterator[Part]:
    """What `always condition` comes to, in order; parts that are true as such need not be in a certificate."""
    if condition == ["not", ["stuck"]]:
        yield from (Part("stuck", m["name"], "", m["name"], []) for m in a["modes"])
        return
    groups: dict[str, list[tuple[Json, Json]]] = {}
    for c in conjuncts(pushed(condition)):
        inside = list(nodes(c))
        seen = [{n[1] for n in inside if n[0] == kind} for kind in ("let", "var")]
        premises = conjuncts(c[1]) if isinstance(c, list) and c[0] == "implies" else []
        only = next((p[1] for p in premises if isinstance(p, list) and p[0] == "at"), None)
        groups.setdefault(",".join(sorted(seen[0] or seen[1])), []).append((only, c))

    def found(mode: str, of: list[str]) -> Iterator[tuple[str, list[Json]]]:
        for output in of:
            spend(len(groups[output]))
            if mine := [c for only, c in groups[output] if only in (None, mode)]:
                yield output, mine

    wanted = {only for cs in groups.values() for only, _ in cs}
    for name in [m["name"] for m in a["modes"] if None in wanted or m["name"] in wanted]:
        yield from (Part("dwell", name, o, name, cs) for o, cs in found(name, list(groups)))
    jumpy = [o for o, cs in groups.items() if any(n[0] in EVENTS for n in nodes([c for _, c in cs]))]
    ends = [(e["source"], e["target"]) for e in a["edges"]] if jumpy else []
    for k, (source, target) in enumerate(ends):
        where = f"{source} -> {target}" + (f" ({a['edges'][k]['name']})" if ends.count(ends[k]) > 1 else "")
        yield from (Part("jump", where, o, k, cs) for o, cs in found(target, jumpy))
