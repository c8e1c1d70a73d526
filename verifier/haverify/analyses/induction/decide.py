"""Claims that hold for all time because an invariant says so, and what stands in the way of others.

The invariant is the claim itself, or what `proposals` add to it. Every part is proved on its own; where one is not, a
state is looked for that the invariant allows and that leaves it. Exact: the trust is `checked`.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import Any

from haverify.analyses.induction.invented import invent
from haverify.analyses.induction.keep import Keeper
from haverify.analyses.induction.points import satisfying
from haverify.analyses.induction.prove import prove
from haverify.analyses.induction.refute import Effort
from haverify.evidence.certificate import certificate, start_json
from haverify.evidence.evidence import Evidence, PartResult
from haverify.evidence.verdict import Proved, Refuted, Unknown, Verdict
from haverify.model.claim import Claim, Goal
from haverify.model.hybrid import HybridAutomaton
from haverify.model.spec import Spec
from haverify.obligations.induction import Induction, Invariant, Obligation
from haverify.obligations.obligation import Hashes, hashes
from haverify.obligations.premises import formula_json, primitive
from haverify.text.record import holder

Q = Fraction
Json = Any
METHOD = "induction"
SECONDS = 20.0  # for the search for an invariant


@holder
class Shown:
    """What was shown of one invariant: a proof for each part, None where none was found."""

    induction: Induction
    formulas: Invariant
    parts: list[tuple[Obligation, Json]]

    def is_proved(self) -> bool:
        """Whether every part has a proof."""
        return all(proof is not None for _, proof in self.parts)


def decide_invariant(spec: Spec, automaton: HybridAutomaton, claim: Claim, core: Json) -> Evidence:
    """What induction shows of a claim.

    Raises
    ------
    OutsideFragmentError    if the automaton or the claim is not of the kind that invariants are shown of
    """
    known = hashes(spec, automaton, core)
    answers = [_goal(spec, automaton, claim, goal, known, number) for number, goal in enumerate(claim.goals)]
    verdict = _combined([v for v, _, _ in answers])
    parts = tuple(p for _, _, found in answers for p in found)
    if isinstance(verdict, Unknown):
        return Evidence(verdict, parts, METHOD)
    word = "proved" if isinstance(verdict, Proved) else "refuted"
    return Evidence(verdict, parts, METHOD, certificate(claim.name, word, [e for _, e, _ in answers], None))


def _combined(verdicts: list[Verdict]) -> Verdict:
    refuted = next((v for v in verdicts if isinstance(v, Refuted)), None)
    unknown = next((v for v in verdicts if isinstance(v, Unknown)), None)
    return refuted or unknown or Proved()


def _goal(
    spec: Spec, automaton: HybridAutomaton, claim: Claim, goal: Goal, known: Hashes, number: int
) -> tuple[Verdict, Json, list[PartResult]]:
    used = [c for c in spec.claims if c.name in claim.using]
    using = tuple(c.goals[0].condition for c in used)
    induction = Induction(spec, automaton, claim, goal, using)
    induction.check()
    start = _start(induction)
    if start is None:
        return Unknown("vacuous", "no admissible start was found, so nothing is shown"), {}, []
    shown = _shown(induction)
    if not shown.is_proved():
        return _open(shown), {}, _parts(shown, number)
    entry = _entry(shown, known, [c.name for c in used], [c.goals[0] for c in used], start)
    return (Proved() if goal.kind == "always" else Refuted()), entry, _parts(shown, number)


def _shown(induction: Induction) -> Shown:
    """An invariant with all its proofs, or the claim itself with those that were found."""
    for effort in (Effort(), Effort(is_deep=True)):
        for formulas in candidates(induction):
            shown = attempt(induction, formulas, effort)
            if shown.is_proved():
                return shown
        found = None if induction.claim.inductive or effort.is_deep else _invented(induction)
        if found is not None:
            return found
    return shown


def candidates(induction: Induction) -> Iterator[Invariant]:
    """Formulas that may be invariants: nothing beyond what is taken for granted, the goal itself."""
    if not induction.claim.inductive:
        yield {m.name: True for m in induction.automaton.modes}
    yield {m.name: primitive(induction.aim(m.name)) for m in induction.automaton.modes}


def _invented(induction: Induction) -> Shown | None:
    """What was shown of an invariant that was found, if all of it."""
    found = invent(induction, SECONDS)
    if found is None:
        return None
    shown = attempt(induction, {found.mode: found.formula}, Effort(is_deep=True), {found.mode: found.flow})
    return shown if shown.is_proved() else None


def attempt(induction: Induction, formulas: Invariant, effort: Effort, flows: Json = None) -> Shown:
    """A proof of each part, as far as they are found; `flows` are those of flows that are known."""
    parts = []
    for ob in induction.parts(formulas):
        if ob.kept is None:
            proof = prove(ob.premises, effort)
        elif flows is not None and ob.mode in flows:
            proof = flows[ob.mode]
        else:
            proof = Keeper(induction.field(ob.mode), effort, induction.functions, []).flow(ob.premises, ob.kept)
        parts.append((ob, proof))
    return Shown(induction, formulas, parts)


def _start(induction: Induction) -> Json | None:
    """An admissible start, as certificates name it."""
    a = induction.automaton
    names = [*(v.name for v in a.vars), *(n for n, (low, high) in induction.params.items() if low < high)]
    for line, mode, _ in induction.lines():
        windows = [f for v in a.vars for f in induction.window(v.name)]
        told = induction.premises(*induction.common(mode), *induction.starts(line, mode), *windows)
        found = satisfying(told, [*names, "time"])
        if found is not None:
            params = {n: found.get(n, low) for n, (low, _) in induction.params.items()}
            return start_json(mode, {v.name: found[v.name] for v in a.vars}, params)
    return None


def _entry(shown: Shown, known: Hashes, using: list[str], used: list[Goal], start: Json) -> Json:
    claim, goal = shown.induction.claim, shown.induction.goal
    told = known.goal(claim, goal, used) if used else known.goal(claim, goal)
    parts = [
        {"kind": ob.kind, "where": ob.where, "hash": known.part(told, ob.kind, ob.where, ""), "proof": proof}
        for ob, proof in shown.parts
    ]
    modes = None if claim.inductive else {m: formula_json(f) for m, f in shown.formulas.items()}
    return {"kind": "invariant", "start": start, "using": using, "modes": modes, "parts": parts}


WORDS = {"init": "holds at the start in", "edge": "kept by the jump", "flow": "kept by the flow of", "use": "claim in"}


def _parts(shown: Shown, number: int) -> list[PartResult]:
    found = []
    for ob, proof in shown.parts:
        verdict: Verdict = Proved() if proof is not None else Unknown("not inductive", "no proof was found")
        text = f"{WORDS[ob.kind]} {'mode ' if ob.kind != 'edge' else ''}{ob.where}"
        found.append(PartResult(number, ob.kind, f"{ob.kind} {ob.where}", "", text, verdict))
    return found


def _open(shown: Shown) -> Unknown:
    """What is not shown, and a state that may be why."""
    failed = "; ".join(f"{ob.kind} {ob.where}" for ob, proof in shown.parts if proof is None)
    if shown.induction.claim.inductive:
        return Unknown("not inductive", f"not shown: {failed}")
    return Unknown("invariant", f"no invariant was found that shows it; of the claim itself is not shown: {failed}")
