"""`holds` goals about fuzzy systems: proved by a tree of regions, refuted by a point (docs/core.md section 6)."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from haverify.analyses.fuzzy_meaning import Meaning, one_sided
from haverify.analyses.fuzzy_telling import told
from haverify.analyses.holds import Held
from haverify.analyses.regions import Truth, both, denied, either, holds_at
from haverify.analyses.regions_round import Point, rounded
from haverify.analyses.regions_search import SpentError, settle
from haverify.evidence.verdict import Proved, Refuted, Unknown
from haverify.maths.digits import rational_text
from haverify.model.claim import Claim, Goal
from haverify.model.core import goal_to_json
from haverify.model.spec import Spec
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import record

Json = Any
MODEL = ("constants", "params", "enums", "assumptions", "cellular", "relations", "fuzzy", "tables")
NODES = 500  # nodes of formulas on regions that one unit of work pays for


def obligation(core: Mapping[str, Json], claim: Claim, goal: Goal) -> str:
    """The hash of a goal's obligation (docs/core.md section 6)."""
    listed = next(c for c in core["claims"] if c["name"] == claim.name)
    value = ["haverify.obligation/1", {k: core[k] for k in MODEL}, goal_to_json(goal), listed["assume"], claim.on]
    text = json.dumps(value, sort_keys=True, separators=(",", ":"), ensure_ascii=False)
    return hashlib.sha256(text.encode("utf-8", "surrogatepass")).hexdigest()


@record
class Question:
    """A goal over real inputs: what is assumed, where it is certainly true and certainly false, on which box."""

    meaning: Meaning
    assumed: Truth
    wanted: Truth
    missed: Truth
    ranges: Mapping[str, tuple[Fraction, Fraction]]


def question(spec: Spec, claim: Claim, goal: Goal) -> Question:
    """The goal of a claim; assumptions that bound a side of a fuzzy input's range stand for that side."""
    meaning = Meaning(spec, claim.on)
    assumed = [meaning.truth(a) for a in (*spec.assumptions, *claim.assume)]
    wanted, missed = meaning.truth(goal.condition), meaning.denial(goal.condition)
    sides = {k: q for k, q in one_sided(assumed).items() if meaning.kinds[k[0]] == "fuzzyinput"}
    ranges = {v: (sides.get((v, False), low), sides.get((v, True), high)) for v, (low, high) in meaning.ranges.items()}
    return Question(meaning, both(assumed), wanted, missed, ranges)


def decide_fuzzy(spec: Spec, claim: Claim, goal: Goal, core: Mapping[str, Json], units: int) -> Held:
    """The verdict on one goal with its certificate's entry, or why it is not known."""
    if claim.which:
        return Held(Unknown("fragment", "`for which` beside fuzzy systems", next_step="a param with that range"))
    try:
        asked = question(spec, claim, goal)
        return _decided(asked, obligation(core, claim, goal), units * NODES)
    except OutsideFragmentError as e:
        return Held(Unknown("fragment", str(e)))
    except SpentError:
        reason = "the inputs fall into more regions than were looked at"
        return Held(Unknown("budget", reason, next_step="a larger --budget, or assumptions that narrow the inputs"))


def _decided(asked: Question, digest: str, nodes: int) -> Held:
    start = admissible(asked, nodes)
    if start is None:
        return Held(Unknown("vacuous", "no input keeps what is assumed", next_step="weaken the assumptions"))
    violates = both([asked.assumed, asked.missed])
    found = settle(either([denied(asked.assumed), asked.wanted]), asked.ranges, nodes)
    if not isinstance(found, dict):
        return Held(Proved(), {"kind": "regions", "hash": digest, "point": _numbers(start), "tree": found})
    if not holds_at(asked.missed, found):
        undefined, found = found, settle(denied(violates), asked.ranges, nodes)
        if not isinstance(found, dict):
            return Held(_undefined(asked, undefined))
    found.update(
        {v: high for v, (_, high) in asked.ranges.items() if not isinstance(violates, bool) and v not in violates.names}
    )
    point = rounded(found, asked.ranges, lambda p: holds_at(violates, p))
    entry = {"kind": "point", "hash": digest, "point": _numbers(point)}
    witness, facts = told(asked.meaning, point)
    return Held(Refuted(), entry, asked.meaning.on or "", witness, facts)


def admissible(asked: Question, nodes: int) -> Point | None:
    """A point of the box that keeps what is assumed, the middle where that does; None where there is none."""
    if any(low > high for low, high in asked.ranges.values()):
        return None
    middle = {v: (low + high) / 2 for v, (low, high) in asked.ranges.items()}
    if holds_at(asked.assumed, middle):
        return middle
    found = settle(denied(asked.assumed), asked.ranges, nodes)
    return found if isinstance(found, dict) else None


def _undefined(asked: Question, found: Mapping[str, Fraction]) -> Unknown:
    """Where the claim is neither true nor false."""
    witness, _ = told(asked.meaning, dict(found))
    where = ", ".join(f"{n} = {v}" for n, v in witness)
    reason = f"something in the claim is not defined at {where}: no rule fires, or a table is read outside its axis"
    return Unknown("fragment", reason, next_step="assume max_firing(...) > 0, or use it as the premise of an `implies`")


def _numbers(point: Mapping[str, Fraction]) -> dict[str, str]:
    return {v: rational_text(q) for v, q in sorted(point.items())}
