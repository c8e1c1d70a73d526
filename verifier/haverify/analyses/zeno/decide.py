"""Claims about runs whose jumps accumulate: shown by a time to go that ends them all."""

from __future__ import annotations

from typing import Any

from haverify.analyses.induction.decide import entry_of, parts_of, start_of
from haverify.analyses.induction.refutation import Start, admissible
from haverify.analyses.induction.refute import Effort
from haverify.analyses.zeno.closing import Closing
from haverify.analyses.zeno.closings import closings, shown_by
from haverify.analyses.zeno.tail import Bracket, bracket
from haverify.analyses.zeno.telling import ending
from haverify.analyses.zeno.unmet import alone, missed, numbers
from haverify.evidence.certificate import certificate
from haverify.evidence.evidence import Evidence, PartResult
from haverify.evidence.verdict import Proved, Refuted, Verdict
from haverify.maths.exact import significant
from haverify.model.claim import Claim, Goal
from haverify.model.expression import Expr, nodes
from haverify.model.hybrid import HybridAutomaton
from haverify.model.spec import Spec
from haverify.obligations.induction import TIME, Induction
from haverify.obligations.obligation import hashes
from haverify.text.record import record

Json = Any
METHOD = "accumulation"


@record
class Found:
    """What was shown of one goal: its verdict, its entry, its parts, and what is to be said of it."""

    verdict: Verdict
    entry: Json
    parts: list[PartResult]
    note: str


def decide_closing(spec: Spec, automaton: HybridAutomaton, claim: Claim, core: Json, effort: Effort) -> Evidence | None:
    """What a time to go shows of a claim, None where that is not all of it.

    Raises
    ------
    OutsideFragmentError    if the automaton or the claim is not of the kind that invariants are shown of
    """
    if claim.inductive or not automaton.edges or spec.assumptions or claim.assume or claim.which:
        return None
    found = []
    for number, goal in enumerate(claim.goals):
        one = _goal(spec, automaton, claim, goal, number, core, effort)
        if one is None:
            return None
        found.append(one)
    is_refuted = any(isinstance(f.verdict, Refuted) for f in found)
    word = "refuted" if is_refuted else "proved"
    told = certificate(claim.name, word, [f.entry for f in found], None)
    parts = tuple(p for f in found for p in f.parts)
    notes = tuple(dict.fromkeys(f.note for f in found))
    return Evidence(Refuted() if is_refuted else Proved(), parts, METHOD, told, notes=notes)


def _goal(
    spec: Spec, automaton: HybridAutomaton, claim: Claim, goal: Goal, number: int, core: Json, effort: Effort
) -> Found | None:
    if goal.kind in ("always", "can_reach"):
        return _by_closing(Induction(spec, automaton, claim, goal, _used(spec, claim)), number, core, effort)
    if goal.kind == "reach" and not claim.using:
        return _never(spec, automaton, claim, goal, number, effort)
    return None


def _used(spec: Spec, claim: Claim) -> tuple[Expr, ...]:
    return tuple(c.goals[0].condition for c in spec.claims if c.name in claim.using)


def _by_closing(induction: Induction, number: int, core: Json, effort: Effort) -> Found | None:
    """A goal that holds always, or never."""
    induction.check()
    start = None
    for closing in closings(induction):
        shown = shown_by(induction, closing, effort)
        start = start or (admissible(induction) if shown.is_proved() else None)
        if start is None or not shown.is_proved():
            continue
        known = hashes(induction.spec, induction.automaton, core)
        used = [c for c in induction.spec.claims if c.name in induction.claim.using]
        entry = entry_of(shown, known, [c.name for c in used], [c.goals[0] for c in used], start)
        verdict: Verdict = Proved() if induction.goal.kind == "always" else Refuted()
        return Found(verdict, entry, parts_of(shown, number), ending(induction, closing, _bracket(induction, closing)))
    return None


def _bracket(induction: Induction, closing: Closing) -> Bracket | None:
    """When jumps accumulate, from both sides, for goals that speak of the time."""
    if not any(n.op == TIME for n in nodes(induction.goal.condition)):
        return None
    return bracket(induction.spec, induction.automaton, induction.claim, closing.end)


def _never(
    spec: Spec, automaton: HybridAutomaton, claim: Claim, goal: Goal, number: int, effort: Effort
) -> Found | None:
    """A start from which the goal is never met, whatever the run does."""
    never, other = missed(claim, goal)
    wide = Induction(spec, automaton, never, other)
    wide.check()
    if any(v.type != "real" for v in automaton.vars) or next(closings(wide), None) is None:
        return None
    start = admissible(wide)
    if not isinstance(start, Start):
        return None
    told = start_of(wide, start)
    values = numbers(told)
    if values is None or told.get("jumps"):
        return None
    narrow, own = alone(spec, automaton, start.mode, values, {n: values[n] for n in told["params"]})
    from haverify.model.core import to_core

    found = _by_closing(Induction(narrow, own, never, other), number, to_core(narrow), effort)
    if found is None:
        return None
    at = ", ".join(f"{n} = {significant(q)}" for n, q in values.items())
    fact = f"no run from {at} meets it, however it ends"
    part = PartResult(number, "start", start.mode, "", f"start in mode {start.mode}", Refuted(), facts=(fact,))
    return Found(Refuted(), {"kind": "unmet", "start": told, "invariant": found.entry}, [part], found.note)
