"""What certificates of goals about cells, rules and relations show: all values tried, or one that decides."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from hacheck.core import Core, by_name
from hacheck.finite import Env, Finite, World
from hacheck.rational import Refused, number

Json = Any


def shown(core: Core, claim: Json, goal: Json, entry: Json) -> str:
    """What an entry of kind `enumerated` or `witness` shows of its goal: `proved` or `refuted`."""
    fields = {"enumerated": {"kind", "hash", "params"}, "witness": {"kind", "hash", "params", "values"}}
    if set(entry) != fields[entry["kind"]] or claim["which"]:
        raise Refused("an entry of a goal has other fields than its kind has")
    point = World(core, claim["on"], _point(core, claim["on"], entry["params"]))
    for a in (*core.data["assumptions"], *claim["assume"]):
        if Finite(point).truth(a, {}) is not True:
            raise Refused("what is assumed does not hold for the params of the certificate")
    everywhere = World(core, claim["on"])  # where params have no value: what is decided there, holds for all of them
    if entry["kind"] == "enumerated":
        truth = Finite(everywhere).truth(goal["condition"], {})
        if truth is None:
            raise Refused("something undefined decides the goal")
        return "proved" if truth else "refuted"
    kind, body, env = _unwrapped(point, goal["condition"], entry["values"])
    if Finite(everywhere if kind == "exists" else point).truth(body, env) is not (kind == "exists"):
        raise Refused("the witness of a goal is none")
    return "proved" if kind == "exists" else "refuted"


def _point(core: Core, on: str | None, given: Json) -> dict[str, Fraction]:
    """A value in its range for each param; or none at all."""
    own = core.automata[on]["params"] if on in core.automata else []
    params = by_name(core.data["params"] + own, "params") if given else {}
    if set(given) != set(params):
        raise Refused("not every param has a value")
    point = {p: number(q) for p, q in given.items()}
    ranges = Finite(World(core, on, point))
    for name, p in params.items():
        if not ranges.value(p["low"], {}) <= point[name] <= ranges.value(p["high"], {}):
            raise Refused(f"the param {name!a} has a value outside its range")
    return point


def _unwrapped(world: World, e: Json, values: Json) -> tuple[str, Json, Env]:
    """A goal without its first quantifiers, all `forall` or all `exists`, whose names have the values given."""
    kind, env = (e[0] if values else "forall"), Env()
    for name, bits in values:
        op, bound, of, body = e
        cell = of, bits
        if op != kind or op not in ("forall", "exists") or name != bound or cell not in world.sets[of]:
            raise Refused("the witness of a goal names other things than the goal does")
        env, e = {**env, bound: cell}, body
    return kind, e, env
