"""A goal that is to be reached and is not: an invariant of the runs from one start excludes it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from hacheck.core import Core
from hacheck.invariants import Induction
from hacheck.rational import Beyond, Refused, number, spend

if TYPE_CHECKING:
    from hacheck.obligations import Question

Json = Any


def shown_unmet(question: Question, entry: Json) -> tuple[str, list[tuple[str, str, str]]]:
    """The goal is refuted: the start is admissible, and no run from it, however it ends, meets the goal in time."""
    from hacheck.obligations import Question as Asked
    from hacheck.obligations import Setting

    setting, claim, start, inner = question.setting, question.claim, entry["start"], entry["invariant"]
    if question.assume or question.scope.rounding or claim["using"]:
        raise Beyond("a goal that is never met, beside assumptions")
    if any(v["type"] != "real" for v in setting.a["vars"]) or setting.a["inputs"] or setting.core.data["inputs"]:
        raise Beyond("a goal that is never met, beside discrete variables or inputs")
    if "jumps" in start or not isinstance(inner, dict) or inner.get("kind") != "invariant":
        raise Refused("a goal that is never met is shown by a start and an invariant")
    spend(100 * (len(setting.core.data["params"]) + len(setting.core.data["automata"])))
    never = {**question.goal, "kind": "always", "condition": ["not", question.condition]}
    free = {**claim, "goals": [never], "horizon": {"time": None, "jumps": None}, "inductive": False}
    Induction(Asked(setting, free, never), [], None).start(start)
    numbers = {n: str(number(q)) for n, q in {**start["values"], **start["params"]}.items()}
    line = {"mode": start["mode"], "where": True,
            "with": [{"var": v["name"], "to": numbers[v["name"]]} for v in setting.a["vars"]]}  # fmt: skip
    own = {**setting.a, "init": [line], "params": _fixed(setting.a["params"], numbers)}
    hidden = {p["name"] for p in setting.a["params"]}
    top = _fixed(setting.core.data["params"], {n: q for n, q in numbers.items() if n not in hidden})
    automata = [own if a is setting.a else a for a in setting.core.data["automata"]]
    core = Core({**setting.core.data, "params": top, "automata": automata})
    core.check_automaton(own)  # that of a system is none of the core's
    alone = Setting(core, own, False, setting.load)
    verdict, _ = Asked(alone, free, never).verdict(inner)
    if verdict != "proved":
        raise Refused("the invariant does not exclude the goal")
    return "refuted", [(start["mode"], "", "refuted")]


def _fixed(params: Json, numbers: dict[str, str]) -> Json:
    return [{**p, "low": numbers[p["name"]], "high": numbers[p["name"]]} if p["name"] in numbers else p
            for p in params]  # fmt: skip
