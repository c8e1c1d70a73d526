"""Claims without time: each `holds` goal shown by what it speaks of, fuzzy systems or finite rules."""

from __future__ import annotations

import hashlib
import json
from functools import lru_cache
from typing import Any

from hacheck.core import Core
from hacheck.expressions import nodes
from hacheck.rational import Refused

Json = Any
FUZZY = {"covered", "max_firing", "strength", "fuzzy", "is", "fuzzyinput"}
MODEL = ("constants", "params", "enums", "assumptions", "cellular", "relations", "fuzzy", "tables")


def obligation(core: Core, claim: Json, goal: Json) -> str:
    """The hash of a goal: of all rules, fuzzy systems and numbers of the core, the goal and what the claim assumes."""
    said = ",".join(map(_text, (goal, claim["assume"], claim["on"])))
    text = f'["haverify.obligation/1",{_model(core)},{said}]'
    return hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()


@lru_cache(maxsize=1)  # all goals of a core share it
def _model(core: Core) -> str:
    return _text({k: core.data[k] for k in MODEL})


def _text(value: Json) -> str:
    return json.dumps(value, sort_keys=True, separators=(",", ":"), ensure_ascii=False)


def held(core: Core, claim: Json, certificate: Json) -> tuple[str, str | None, list[tuple[str, str, str]]]:
    """The verdict and the verdicts of the goals that a certificate establishes."""
    given = certificate["goals"]
    if not isinstance(given, list) or len(given) != len(claim["goals"]) or certificate["rounding"] is not None:
        raise Refused("its certificate does not have one entry for each goal")
    found = [_goal(core, claim, goal, entry) for goal, entry in zip(claim["goals"], given, strict=True)]
    shown = "refuted" if "refuted" in found else "proved" if set(found) == {"proved"} else None
    if shown is None or shown != certificate["verdict"]:
        raise Refused(f"its certificate does not establish the verdict {certificate['verdict']!a}")
    return shown, None, [("", "", v) for v in found]


def _goal(core: Core, claim: Json, goal: Json, entry: Json) -> str:
    """`proved`, `refuted`, or `unknown` for an entry that shows nothing."""
    if entry == {}:
        return "unknown"
    if entry.get("hash") != obligation(core, claim, goal):
        raise Refused("a goal has another hash than the obligation derived from the core")
    if any(n[0] in FUZZY for n in nodes(goal["condition"])):
        from hacheck.fuzzy import fuzzy_goal

        return fuzzy_goal(core, claim, goal, entry)
    from hacheck.finite_goals import shown

    return shown(core, claim, goal, entry)
