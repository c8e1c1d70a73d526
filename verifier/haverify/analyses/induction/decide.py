"""Claims that hold for all time because an invariant says so, and what stands in the way of others.

The invariant is the claim itself, or what `proposals` add to it. Every part is proved on its own; where one is not, a
state is looked for that the invariant allows and that leaves it. Exact: the trust is `checked`.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import Any

from haverify.analyses.hybrid.record import record_name
from haverify.analyses.induction.brackets import Bracketed
from haverify.analyses.induction.counterexample import Leaving, leaving, state_text
from haverify.analyses.induction.excluding import excluding
from haverify.analyses.induction.invented import applies, invent
from haverify.analyses.induction.keep import Keeper
from haverify.analyses.induction.portrait import portrait
from haverify.analyses.induction.prove import is_defined, prove
from haverify.analyses.induction.reached import nearest, reached_text
from haverify.analyses.induction.refutation import Admissible, Start, admissible, at_once, by_jump, by_run
from haverify.analyses.induction.refute import Effort
from haverify.analyses.induction.rooted import by_rooted_run
from haverify.analyses.induction.written import standing, written
from haverify.evidence.certificate import certificate, run_json, start_json
from haverify.evidence.evidence import Evidence, PartResult
from haverify.evidence.run import Run, Step
from haverify.evidence.verdict import Proved, Refuted, Unknown, Verdict
from haverify.maths.digits import rational_text
from haverify.model.claim import Claim, Goal
from haverify.model.expression import Expr
from haverify.model.hybrid import HybridAutomaton
from haverify.model.spec import Spec
from haverify.obligations.induction import Induction, Invariant, Obligation
from haverify.obligations.obligation import Hashes, hashes
from haverify.obligations.premises import formula_json, polynomial_json, primitive
from haverify.text.record import holder

Q = Fraction
ONE = Fraction(1)
Json = Any
METHOD = "induction"
FEW = 200  # points that are tried first
SECONDS = 40.0  # for the search for an invariant
MODES_SECONDS = 15.0  # where there are several modes or edges


@holder
class Shown:
    """What was shown of one invariant: a proof for each part, None where none was found."""

    induction: Induction
    formulas: Invariant
    parts: list[tuple[Obligation, Json]]

    def is_proved(self) -> bool:
        """Whether every part has a proof."""
        return all(proof is not None for _, proof in self.parts)


def decide_invariant(
    spec: Spec, automaton: HybridAutomaton, claim: Claim, core: Json, scale: Fraction = ONE
) -> Evidence:
    """What induction shows of a claim; `scale` says how long an invariant is searched for, 1 being usual.

    Raises
    ------
    OutsideFragmentError    if the automaton or the claim is not of the kind that invariants are shown of
    """
    known = hashes(spec, automaton, core)
    seconds = SECONDS * float(scale)
    drawn: list[Json] = []
    cells: dict[str, Json] = {}
    asked = ((Induction(spec, automaton, claim, g, _conditions(spec, claim)), n) for n, g in enumerate(claim.goals))
    answers = [_goal(induction, known, number, seconds, drawn, cells) for induction, number in asked]
    verdict = _combined([v for v, _, _ in answers])
    parts = tuple(p for _, _, found in answers for p in found)
    if isinstance(verdict, Unknown):
        return Evidence(verdict, parts, METHOD, flowpipe=next((d for d in drawn if d is not None), None))
    word = "proved" if isinstance(verdict, Proved) else "refuted"
    return Evidence(verdict, parts, METHOD, certificate(claim.name, word, [e for _, e, _ in answers], None), cells)


def _combined(verdicts: list[Verdict]) -> Verdict:
    refuted = next((v for v in verdicts if isinstance(v, Refuted)), None)
    unknown = next((v for v in verdicts if isinstance(v, Unknown)), None)
    return refuted or unknown or Proved()


def _used(spec: Spec, claim: Claim) -> list[Claim]:
    return [c for c in spec.claims if c.name in claim.using]


def _conditions(spec: Spec, claim: Claim) -> tuple[Expr, ...]:
    return tuple(c.goals[0].condition for c in _used(spec, claim))


def _goal(
    induction: Induction, known: Hashes, number: int, seconds: float, drawn: list[Json], cells: dict[str, Json]
) -> tuple[Verdict, Json, list[PartResult]]:
    """The verdict on a goal, its entry, its parts; figures of open ones go to `drawn`, recorded flows to `cells`."""
    induction.check()
    start = admissible(induction)
    if start is None:
        return Unknown("vacuous", "no admissible start was found, so nothing is shown"), {}, []
    shown = _quickly(induction)
    if not shown.is_proved():
        refuted = _refuted(induction, shown, known, number)
        if refuted is None and isinstance(start, Bracketed):
            refuted = _rooted(induction, known, number, cells)
        if refuted is not None:
            return refuted
        shown = _shown(induction, shown, seconds)
    if not shown.is_proved():
        return _open(shown, drawn), {}, parts_of(shown, number)
    used = _used(induction.spec, induction.claim)
    entry = entry_of(shown, known, [c.name for c in used], [c.goals[0] for c in used], start)
    return (Proved() if induction.goal.kind == "always" else Refuted()), entry, parts_of(shown, number)


def _refuted(
    induction: Induction, shown: Shown, known: Hashes, number: int
) -> tuple[Verdict, Json, list[PartResult]] | None:
    """A start, or a run, that violates the goal; what was `shown` of the goal as an invariant says where to look."""
    told = known.goal(induction.claim, induction.goal)
    verdict: Verdict = Refuted() if induction.goal.kind == "always" else Proved()
    start = _start_refuting(induction, {ob.kind for ob, proof in shown.parts if proof is None})
    if start is not None:
        entry = started(induction, start, known.part(told, "start", start.mode, ""))
        steps = tuple(Step(Q(0), k, chosen) for k, chosen in start.jumps)
        run = Run(start.mode, _pairs(entry["start"]["values"]), _pairs(entry["start"]["params"]), steps, Q(0))
        part = PartResult(number, "start", start.mode, "", f"start in mode {start.mode}", verdict, run)
        return verdict, entry, [part]
    found = by_run(induction)
    if found is None:
        return None
    entry = {"kind": "flow_run", "run": run_json(found), "hash": known.part(told, "flow", found.mode, "")}
    return verdict, entry, [PartResult(number, "flow", found.mode, "", f"flow of mode {found.mode}", verdict, found)]


def _rooted(
    induction: Induction, known: Hashes, number: int, cells: dict[str, Json]
) -> tuple[Verdict, Json, list[PartResult]] | None:
    """A run from a start without rational values that violates the goal, and its record."""
    found = by_rooted_run(induction)
    if found is None:
        return None
    told, run = known.goal(induction.claim, induction.goal), found.run
    verdict: Verdict = Refuted() if induction.goal.kind == "always" else Proved()
    entry = {**found.entry, "hash": known.part(told, "flow", run.mode, "")}
    if found.flow is not None:
        entry["flow"] = record_name(induction.claim.name, number)
        cells[entry["flow"]] = found.flow
    return verdict, entry, [PartResult(number, "flow", run.mode, "", f"flow of mode {run.mode}", verdict, run)]


def _start_refuting(induction: Induction, failed: set[str]) -> Start | None:
    """A start that violates the goal, or does after a jump, where that part of the goal was not shown."""
    found = at_once(induction, FEW) if "init" in failed else None
    found = found or (by_jump(induction) if failed & {"init", "edge"} else None)
    return found or (at_once(induction) if "init" in failed else None)


def started(induction: Induction, start: Start, digest: str) -> Json:
    """The entry for a start that violates the goal."""
    told = start_of(induction, start)
    if start.jumps:
        told["jumps"] = [{"edge": k, "values": {v: rational_text(q) for v, q in chosen}} for k, chosen in start.jumps]
    return {"kind": "start", "start": told, "hash": digest}


def _pairs(values: Json) -> tuple[tuple[str, Q], ...]:
    return tuple((n, Q(q)) for n, q in values.items())


def _quickly(induction: Induction) -> Shown:
    """A candidate with proofs that are found at a glance, or the claim itself with those."""
    return _tried(induction, Effort())


def _shown(induction: Induction, before: Shown, seconds: float) -> Shown:
    """An invariant that was found, or a candidate with all proofs that programs find; else what was shown before."""
    if not induction.claim.inductive and applies(induction):
        share = MODES_SECONDS / SECONDS if induction.automaton.edges else 1.0
        found = _invented(induction, seconds * share)
        if found is not None or not induction.automaton.edges:
            return found or before
    return _tried(induction, Effort(is_deep=True))


def _tried(induction: Induction, effort: Effort) -> Shown:
    """What is shown of the first candidate all parts of which have a proof, else of the last one."""
    *others, last = candidates(induction)
    for formulas in others:
        shown = attempt(induction, formulas, effort, is_whole=False)
        if shown.is_proved():
            return shown
    return attempt(induction, last, effort)


def candidates(induction: Induction) -> Iterator[Invariant]:
    """Formulas that may be invariants: nothing beyond what is taken for granted, the goal itself."""
    if not induction.claim.inductive:
        yield {m.name: True for m in induction.automaton.modes}
    yield {m.name: primitive(induction.aim(m.name)) for m in induction.automaton.modes}


def _invented(induction: Induction, seconds: float) -> Shown | None:
    """What was shown of an invariant that was found, if all of it."""
    found = invent(induction, seconds)
    if found is None:
        return None
    shown = attempt(induction, found.formulas, Effort(is_deep=True), found.flows)
    return shown if shown.is_proved() else None


def attempt(
    induction: Induction, formulas: Invariant, effort: Effort, flows: Json = None, is_whole: bool = True
) -> Shown:
    """A proof of each part, as far as they are found; `flows` are those of flows that are known.

    Unless it `is_whole`, parts after one without a proof are left out.
    """
    parts = list[tuple[Obligation, Json]]()
    for ob in induction.parts(formulas):
        if not is_defined(ob):
            proof = None
        elif ob.kept is None:
            proof = prove(ob.premises, effort)
        elif flows is not None and ob.mode in flows:
            proof = flows[ob.mode]
        else:
            keeper = Keeper(induction.field(ob.mode), effort, induction.functions, [], induction.has_inputs)
            proof = keeper.flow(ob.premises, ob.kept)
        parts.append((ob, proof))
        if proof is None and not is_whole:
            break
    return Shown(induction, formulas, parts)


def start_of(induction: Induction, start: Admissible) -> Json:
    """A start, as certificates name it."""
    ends = {n: low for n, (low, _) in induction.params.items()}
    states = [v.name for v in induction.automaton.vars]
    if isinstance(start, Bracketed):
        told = start_json(start.mode, start.point, {n: start.point.get(n, ends[n]) for n in ends})
        roots = {v: [rational_text(q) for q in pair] for v, pair in start.roots.items()}
        return {**told, "values": {v: roots[v] if v in roots else told["values"][v] for v in states}}
    if isinstance(start, Start):
        return start_json(
            start.mode, {v: start.point[v] for v in states}, {n: start.point.get(n, ends[n]) for n in ends}
        )
    told = {n: polynomial_json(p) if p.constant is None else rational_text(p.constant) for n, p in start.point.items()}
    known = {n: told.get(n, rational_text(low)) for n, low in ends.items()}
    return {"mode": start.mode, "values": {v: told[v] for v in states}, "params": known}


def entry_of(shown: Shown, known: Hashes, using: list[str], used: list[Goal], start: Admissible) -> Json:
    """The entry of a goal that an invariant shows."""
    claim, goal = shown.induction.claim, shown.induction.goal
    told = known.goal(claim, goal, used) if used else known.goal(claim, goal)
    parts = [
        {"kind": ob.kind, "where": ob.where, "hash": known.part(told, ob.kind, ob.where, ""), "proof": proof}
        for ob, proof in shown.parts
    ]
    modes = None if claim.inductive else {m: formula_json(f) for m, f in shown.formulas.items()}
    told_start = start_of(shown.induction, start)
    return {"kind": "invariant", "start": told_start, "using": using, "modes": modes, "parts": parts}


WORDS = {"init": "holds at the start in", "edge": "kept by the jump", "flow": "kept by the flow of", "use": "claim in"}


def parts_of(shown: Shown, number: int) -> list[PartResult]:
    """What the report says of each part."""
    found = []
    for ob, proof in shown.parts:
        verdict: Verdict = Proved() if proof is not None else Unknown("invariant", "no proof was found")
        text = f"{WORDS[ob.kind]} {'mode ' if ob.kind != 'edge' else ''}{ob.where}"
        found.append(PartResult(number, ob.kind, f"{ob.kind} {ob.where}", "", text, verdict))
    return found


def _open(shown: Shown, drawn: list[Json]) -> Unknown:
    """What is not shown, and a state that says why, if there is one."""
    induction = shown.induction
    failed = [ob for ob, proof in shown.parts if proof is None]
    places = "; ".join(f"{ob.kind} {ob.where}" for ob in failed)
    if not induction.claim.inductive:
        reason = f"no invariant was found that shows it; of the claim itself is not shown: {places}"
        return Unknown("invariant", reason)
    for ob in failed:
        found = leaving(induction, ob, shown.formulas[ob.mode])
        if found is not None:
            place = f"the jump {ob.where}" if ob.kind == "edge" else f"the {ob.kind} of mode {ob.where}"
            reason = f"not inductive: {place} breaks it at {state_text(induction, found)}"
            near = nearest(induction, found)
            drawn.append(portrait(induction, found, shown.formulas[ob.mode], near))
            return Unknown("inductive", reason, reached_text(induction, near), found.told, _cure(shown, found))
    return Unknown("invariant", f"not shown: {places}; no state that leaves it was found either")


def _cure(shown: Shown, found: Leaving) -> str:
    """What may be added to an invariant, as it is written."""
    induction = shown.induction

    def is_proved(formulas: Invariant, is_deep: bool) -> bool:
        return attempt(induction, formulas, Effort(is_deep=is_deep)).is_proved()

    added = excluding(induction, shown.formulas, found.mode, found.point, is_proved)
    if added is None:
        return "add a conjunct that excludes this state and holds on all runs, or leave out `inductive`"
    params = (*induction.spec.params,)
    texts = {m: written(f, induction.automaton, params, induction.functions) for m, f in added.items()}
    is_alone = len(induction.automaton.modes) == 1
    terms = [text if is_alone else f"({standing(m)} implies {text})" for m, text in texts.items()]
    return f"add `and {' and '.join(terms)}`: it excludes this state, and with it every part is proved"
