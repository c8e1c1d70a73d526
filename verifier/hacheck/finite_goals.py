"""What certificates of goals without time show: all values of names tried, one that decides, all params on boxes."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from hacheck import bernstein
from hacheck.core import Core, by_name
from hacheck.expressions import Instant
from hacheck.finite import Env, Finite, World
from hacheck.formula import disj, variables
from hacheck.polynomial import const
from hacheck.rational import Refused, number
from hacheck.scope import Scope

Json = Any
FIELDS: dict[str, set[str]] = {"enumerated": set(), "witness": {"values"}, "boxes": {"proof", "verdict"}}


def shown(core: Core, claim: Json, goal: Json, entry: Json) -> str:
    """What an entry of kind `enumerated` or `witness` shows of its goal: `proved` or `refuted`."""
    timed = claim["which"] or goal["window"] is not None or goal["within"] is not None
    if timed or set(entry) != {"kind", "hash", "params", *FIELDS[entry["kind"]]}:
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
    if entry["kind"] == "boxes":
        return _on_boxes(core, claim, goal, entry)
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
    kind, env = "forall", Env()
    for name, bits in values:
        op, bound, of, body = e if isinstance(e, list) and len(e) == 4 else ("", "", "", None)
        kind = kind if env else op
        if op not in ("forall", "exists") or (op, name) != (kind, bound) or (of, bits) not in world.sets[of]:
            raise Refused("the witness of a goal names other things than the goal does")
        env, e = {**env, name: (of, bits)}, body
    return kind, e, env


def _on_boxes(core: Core, claim: Json, goal: Json, entry: Json) -> str:
    """A tree shows the goal, or that an assumption fails, for all params; or the denied goal for those given."""
    empty: Json = {"constants": [], "params": [], "modes": [], "vars": []}
    scope = Scope(core, core.automata.get(claim["on"], empty), False)
    if scope.params and not entry["params"]:
        raise Refused("no admissible values of the params are given")
    given = {p: const(number(q)) for p, q in entry["params"].items()}
    if entry["verdict"] == "refuted":
        f = Instant(scope, None, given).formula(goal["condition"], True)
    else:
        at = Instant(scope, None, {})
        excuses = [at.formula(a, True) for a in (*core.data["assumptions"], *claim["assume"])]
        f = disj([at.formula(goal["condition"]), *excuses])
    bernstein.replay(entry["proof"], f, {v: scope.box[v] for v in variables(f)})
    return "refuted" if entry["verdict"] == "refuted" else "proved"
