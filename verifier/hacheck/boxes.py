"""`for which`: the range of params is cut, and the claim shown on each piece as if that were the declared range."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from hacheck.core import Core
from hacheck.obligations import Setting, goals_shown
from hacheck.polynomial import constant
from hacheck.rational import Beyond, Refused, number, spend
from hacheck.scope import Scope

Json = Any
Box = dict[str, tuple[Fraction, Fraction]]
MOST = 200  # pieces


def shown_by_boxes(claim: Json, certificate: Json, setting: Setting) -> tuple[str, str | None, Any]:
    """The verdict, none within rounding, and the verdict of each piece."""
    if certificate["rounding"] is not None:
        raise Refused("nothing is shown of rounding piece by piece")
    if any(g["kind"] not in ("always", "reach", "stl") for g in claim["goals"]):
        raise Beyond("`for which` beside goals about some run")
    box = {w["name"]: _within(setting.model.scope, w) for w in claim["which"]}
    if len(box) != len(claim["which"]):
        raise Refused("`for which` names a param twice")
    found: list[tuple[str, str, str]] = []
    _tree(claim, certificate["boxes"], setting, box, found)
    words = {word for _, _, word in found}
    verdict = "refuted" if "refuted" in words else "proved" if words == {"proved"} else None
    if verdict is None or verdict != certificate["verdict"]:
        raise Refused("its certificate does not establish its verdict")
    return verdict, None, found


def _within(scope: Scope, w: Json) -> tuple[Fraction, Fraction]:
    """The range to be cut, which lies in the declared one."""
    p = scope.ranges.get(w["name"])
    if p is None:
        raise Refused("`for which` names no param")
    ends = [constant(scope.base.poly(e)) for e in (p["low"], w["low"], w["high"], p["high"])]
    if None in ends or ends != sorted(ends):  # type: ignore[type-var]
        raise Beyond("`for which` beyond the declared range, or with ends that are no rationals")
    return ends[1], ends[2]  # type: ignore[return-value]


def _tree(claim: Json, tree: Json, setting: Setting, box: Box, found: list[tuple[str, str, str]]) -> None:
    where = ", ".join(f"{n} in [{low}, {high}]" for n, (low, high) in box.items())
    if len(found) >= MOST:
        raise Beyond("very many pieces")
    if isinstance(tree, list) and tree[0] == "at":
        _, values, leaf = tree
        at = {n: number(q) for n, q in values.items()}
        if at.keys() != box.keys() or not all(low <= at[n] <= high for n, (low, high) in box.items()):
            raise Refused("a point is not in its piece")
        point = ", ".join(f"{n} = {at[n]}" for n in box)
        found += [(where, "", "unknown"), (point, "", _piece(claim, leaf, setting, {n: (q, q) for n, q in at.items()}))]
        if found[-1][2] != "refuted":
            raise Refused("at a point of a piece the claim is not refuted")
        return
    if isinstance(tree, list):
        word, name, cut, low, high = tree
        q = number(cut)
        if word != "split" or name not in box or not box[name][0] < q < box[name][1]:
            raise Refused("a cut is not inside of its piece")
        _tree(claim, low, setting, {**box, name: (box[name][0], q)}, found)
        _tree(claim, high, setting, {**box, name: (q, box[name][1])}, found)
        return
    found.append((where, "", "unknown" if tree is None else _piece(claim, tree, setting, box)))


def _piece(claim: Json, leaf: Json, setting: Setting, box: Box) -> str:
    """The verdict on a piece; it is refuted where the claim is false for every point of it."""
    data = setting.core.data
    spend(100 * (len(data["params"]) + len(data["automata"])))
    own = [_narrowed(setting.a["params"], box)]
    top = _narrowed(data["params"], {n: i for n, i in box.items() if all(p["name"] != n for p in setting.a["params"])})
    automata = [{**a, "params": own[0]} if a is setting.a else a for a in data["automata"]]
    core = Core({**data, "params": top, "automata": automata})
    narrow = Setting(core, core.automata[setting.a["name"]], False, setting.load, setting.lemma)
    verdict: str = goals_shown({**claim, "which": []}, leaf, narrow)[0]
    wide = {n for n, (low, high) in box.items() if low < high}
    if verdict == "refuted" and wide and any(entry.get("kind") == "flow_run" for entry in leaf["goals"]):
        raise Beyond("a flow that violates the claim for all of a piece")
    if verdict == "refuted" and not all(_is_for_all(entry, wide) for entry in leaf["goals"]):
        raise Refused("a piece is refuted for some of its points only")
    return verdict


def _is_for_all(entry: Json, wide: set[str]) -> bool:
    return not wide or entry == {} or (entry["kind"] == "start" and wide.isdisjoint(entry["start"]["params"]))


def _narrowed(params: Json, box: Box) -> Json:
    return [{**p, "low": str(box[p["name"]][0]), "high": str(box[p["name"]][1])} if p["name"] in box else p
            for p in params]  # fmt: skip
