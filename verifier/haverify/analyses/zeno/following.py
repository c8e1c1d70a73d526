"""Claims about runs whose jumps accumulate, by flowpipes through some jumps and an end of all runs from there."""

from __future__ import annotations

from typing import Any

from haverify.analyses.induction.refute import Effort
from haverify.analyses.zeno.closings import closings, shown_by
from haverify.analyses.zeno.decide import METHOD
from haverify.analyses.zeno.followed import TRUE
from haverify.analyses.zeno.tail import Tail, by_tail
from haverify.analyses.zeno.telling import after_jumps
from haverify.evidence.certificate import certificate
from haverify.evidence.evidence import Evidence, PartResult
from haverify.evidence.verdict import Proved
from haverify.model.claim import Claim, Goal
from haverify.model.hybrid import HybridAutomaton
from haverify.model.spec import Spec
from haverify.obligations.induction import Induction
from haverify.obligations.obligation import hashes
from haverify.text.record import replace

Json = Any


def decide_following(
    spec: Spec, automaton: HybridAutomaton, claim: Claim, core: Json, effort: Effort
) -> Evidence | None:
    """What is proved so of a claim, None where that is not all of it. Trust: `enclosed`.

    Raises
    ------
    OutsideFragmentError    if the automaton or the claim is not of the kind that flowpipes and invariants are about
    """
    is_other = claim.inductive or spec.assumptions or claim.assume or claim.which or claim.using
    if is_other or not automaton.edges or any(v.type != "real" for v in automaton.vars):
        return None
    goal = Goal("always", TRUE)
    plain = Induction(spec, automaton, replace(claim, goals=(goal,), time=None, jumps=None), goal)
    end = next((c.end for c in closings(plain) if shown_by(plain, c, Effort()).is_proved()), None)
    if end is None:
        return None
    found = list[Tail]()
    for g in claim.goals:
        one = by_tail(spec, automaton, claim, g, end, effort)
        if one is None:
            return None
        found.append(one)
    known = hashes(spec, automaton, core)
    entries, parts = [], []
    for number, (g, tail) in enumerate(zip(claim.goals, found, strict=True)):
        digest = known.part(known.goal(claim, g), "flow", tail.mode, "")
        entries.append({"kind": "flowpipe", "start": tail.start, "hash": digest})
        text = f"holds along flowpipes through {tail.jumps} jumps, and after them"
        parts.append(PartResult(number, "flow", tail.mode, "", text, Proved()))
    told = certificate(claim.name, "proved", entries, None)
    notes = tuple(dict.fromkeys(after_jumps(t.jumps, t.high, spec.unitless) for t in found))
    return Evidence(Proved(), tuple(parts), METHOD, told, notes=notes)
