"""Claims without time (`holds`): each goal decided by what it speaks of, fuzzy systems or finite rules."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from haverify.evidence.certificate import certificate
from haverify.evidence.evidence import Evidence, PartResult
from haverify.evidence.verdict import Proved, Refuted, Unknown, Verdict
from haverify.model.claim import Claim, Goal
from haverify.model.expression import nodes
from haverify.model.spec import Spec
from haverify.text.record import field, holder

Json = Any
METHOD = "holds"
FUZZY = frozenset({"covered", "max_firing", "strength", "fuzzy", "is", "fuzzyinput"})


@holder
class Held:
    """What was found out about one goal: the certificate's entry, the names and values that decide it, facts."""

    verdict: Verdict
    entry: Json = field(default_factory=dict)
    text: str = ""
    witness: tuple[tuple[str, str], ...] = ()
    facts: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()


def decide_holds(spec: Spec, claim: Claim, core: Mapping[str, Json], units: int) -> Evidence:
    """A claim whose goals are all `holds`: proved if all are, refuted if one is (LANGUAGE S26)."""
    found = [_goal(spec, claim, goal, core, units) for goal in claim.goals]
    parts = tuple(PartResult(i, "holds", "", "", h.text, h.verdict, facts=h.facts) for i, h in enumerate(found))
    notes = tuple(dict.fromkeys(n for h in found for n in h.notes))
    verdict = _combined(found)
    if isinstance(verdict, Unknown):
        return Evidence(verdict, parts, METHOD, notes=notes)
    word = "proved" if isinstance(verdict, Proved) else "refuted"
    witness = next((h.witness for h in found if isinstance(h.verdict, type(verdict)) and h.witness), ())
    entries = [h.entry for h in found]
    return Evidence(verdict, parts, METHOD, certificate(claim.name, word, entries, None), notes=notes, witness=witness)


def _goal(spec: Spec, claim: Claim, goal: Goal, core: Mapping[str, Json], units: int) -> Held:
    if is_fuzzy(goal):
        from haverify.analyses.fuzzy import decide_fuzzy

        return decide_fuzzy(spec, claim, goal, core, units)
    from haverify.analyses.finite import decide_finite

    return decide_finite(spec, claim, goal, core, units)


def is_fuzzy(goal: Goal) -> bool:
    """Does a goal speak of fuzzy systems?"""
    return any(n.op in FUZZY for n in nodes(goal.condition))


def _combined(found: list[Held]) -> Verdict:
    for kind in (Refuted, Unknown):
        first = next((h.verdict for h in found if isinstance(h.verdict, kind)), None)
        if first is not None:
            return first
    margins = [h.verdict.margin for h in found if isinstance(h.verdict, Proved) and h.verdict.margin is not None]
    return Proved(min(margins, key=lambda m: m.low, default=None))
