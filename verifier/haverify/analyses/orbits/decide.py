"""`cycle through P [within T] [attracting]`: a periodic orbit proved by Newton's method in intervals (LANGUAGE S23).

An orbit in floats gives a plane across the flow. The return map of the plane and its derivative are enclosed on a small
box by flowpipes of the variational equations, which cross guards by their saltation matrices; Krawczyk's operator shows
that the box has one fixed point. All of that orbit passes P where the flowpipe does. It is attracting where the return
map contracts a box, into which all runs from P certainly come. Refuted where no run from P returns to its start, or
where the orbit repels. Trust: `enclosed`.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import Any

from haverify.analyses.hybrid.goal import reads_time
from haverify.analyses.hybrid.inputs import fields
from haverify.analyses.hybrid.model import HybridModel, hybrid_model
from haverify.analyses.hybrid.record import record_name
from haverify.analyses.orbits.basin import Arrivals, Part, basin, parts
from haverify.analyses.orbits.guesses import Guesses
from haverify.analyses.orbits.linear import Disc, discs
from haverify.analyses.orbits.newton import Fixed
from haverify.analyses.orbits.orbit import Passed, Plane
from haverify.analyses.orbits.passing import Section, sections
from haverify.analyses.orbits.recorded import recorded_orbit
from haverify.analyses.orbits.telling import entry_of, told
from haverify.analyses.orbits.unreturned import never_returns
from haverify.evidence.certificate import certificate
from haverify.evidence.evidence import Evidence, PartResult
from haverify.evidence.verdict import Proved, Refuted, Unknown, Verdict
from haverify.maths.interval import Fault
from haverify.model.claim import Claim, Goal
from haverify.model.hybrid import HybridAutomaton
from haverify.model.spec import Spec
from haverify.obligations.obligation import hashes
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import record, replace

Q = Fraction
Json = Any
METHOD = "periodic-orbit"
MOST = 4  # orbits that are tried


@record
class Found:
    """What was found about a goal: the verdict, the part in words, its entry in the certificate."""

    verdict: Verdict
    text: str = ""
    entry: Json = None
    notes: tuple[str, ...] = ()
    files: Json = None


@record
class Proof:
    """A periodic orbit that is proved, and where it passes P; its multipliers."""

    plane: Plane
    fixed: Fixed
    passed: Passed
    multipliers: tuple[Disc, ...]


def decide_cycle(spec: Spec, automaton: HybridAutomaton, claim: Claim, core: Json) -> Evidence:
    """What return maps show of a claim with one goal, `cycle through P`.

    Raises
    ------
    OutsideFragmentError    if the automaton or the claim is not of that kind
    """
    goal = _goal(spec, claim)
    longest, model = None, _model(spec, automaton, goal)
    if goal.within is not None:
        longest = model.values.number(goal.within)
    try:
        found = _found(model, goal, longest, record_name(claim.name, 0))
    except Fault as e:
        found = Found(Unknown("orbit", f"an enclosure failed: {e}"))
    where = model.automaton.modes[0].name
    part = PartResult(0, "flow", where, "", found.text, found.verdict)
    if isinstance(found.verdict, Unknown):
        return Evidence(found.verdict, (part,), METHOD, notes=found.notes)
    known = hashes(spec, automaton, core)
    entry = {**found.entry, "hash": known.part(known.goal(claim, goal), "flow", where, "")}
    word = "proved" if isinstance(found.verdict, Proved) else "refuted"
    stated = certificate(claim.name, word, [entry], None)
    return Evidence(found.verdict, (part,), METHOD, stated, cells=found.files or {}, notes=found.notes)


def _goal(spec: Spec, claim: Claim) -> Goal:
    if len(claim.goals) != 1 or claim.using or claim.time is not None or claim.jumps is not None:
        raise OutsideFragmentError(
            "`cycle through` beside other goals, a horizon or `using`; write a property for it alone"
        )
    if claim.assume or spec.assumptions:
        raise OutsideFragmentError("`cycle through` beside assumptions")
    return claim.goals[0]


def _model(spec: Spec, automaton: HybridAutomaton, goal: Goal) -> HybridModel:
    """The automaton with all modes; runs may be anywhere, since P may be a state that no start leads to."""
    everywhere = replace(
        automaton, init=(*automaton.init, *(replace(automaton.init[0], mode=m.name) for m in automaton.modes))
    )
    model = hybrid_model(spec, everywhere, [goal.condition])
    if not model.is_plain:
        raise OutsideFragmentError("`cycle through` beside discrete variables, or corners in flows and resets")
    if reads_time(model, goal):
        raise OutsideFragmentError("`cycle through` beside `time`; make it a clock of the model")
    if any(fields(model, m)[1] for m in model.modes):
        raise OutsideFragmentError("`cycle through` beside inputs or inclusions")
    return replace(model, automaton=automaton)


def _found(model: HybridModel, goal: Goal, longest: Q | None, name: str) -> Found:
    pinned = sections(model, goal.condition)
    if not pinned:
        return Found(Unknown("vacuous", "no state is on the section"))
    guesses = Guesses(model.spec, model.automaton)
    areas, unbounded = _areas(model, goal, pinned)
    late = list[str]()
    for proof in _proofs(model, guesses, pinned, areas, longest):
        end = proof.fixed.lap.time
        if longest is not None and not Q(end.high) <= longest:
            late.append(
                f"a periodic orbit was proved, with a period of {end.midpoint:.15g}, but a shorter one is claimed"
            )
            continue
        return _recorded(_judged(goal, proof, areas, unbounded), goal, proof, areas, name)
    gone = (never_returns(model, goal.condition, a, longest) for a in areas if longest is not None)
    if areas and longest is not None and all(gone):
        return Found(Refuted(), "no run from the section returns to its start in time", {"kind": "cycle"})
    reason = late[0] if late else "no periodic orbit was found that could be proved"
    return Found(Unknown("orbit", reason, next_step="`haverify simulate --orbit` shows what runs come to"))


def _areas(model: HybridModel, goal: Goal, pinned: Sequence[Section]) -> tuple[list[Part], str]:
    """Boxes with all states that have P; or why there are none."""
    try:
        return parts(model, goal.condition, pinned), ""
    except OutsideFragmentError as e:
        return [], str(e)


def _proofs(
    model: HybridModel, guesses: Guesses, pinned: list[Section], areas: Sequence[Part], longest: Q | None
) -> Iterator[Proof]:
    """Orbits that are proved, and pass P."""
    names = model.names[:-1]
    starts = [(a.mode, {n: float(low + high) / 2 for n, (low, high) in zip(names, a.box, strict=True)}) for a in areas]
    for number, orbit in enumerate(guesses.orbits(longest, starts)):
        if number >= MOST:
            return
        try:
            plane = Plane(model, guesses, orbit)
            fixed = plane.fixed()
            passed = None if fixed is None else plane.passed(pinned, dict(fixed.box))
            if fixed is not None and passed is not None:
                yield Proof(plane, fixed, passed, tuple(discs(fixed.lap.slopes)))
        except Fault:
            continue


def _recorded(found: Found, goal: Goal, proof: Proof, areas: Sequence[Part], name: str) -> Found:
    """What is proved, with a record for the checker where it can follow one."""
    if not isinstance(found.verdict, Proved):
        return found
    made = recorded_orbit(proof.plane, proof.fixed, proof.passed, areas, goal.attracting, name)
    if made is None:
        return found
    low, high = (float(Q(q)) for q in made.entry["period"])
    more = f"the certificate is about a period from {low:.6g} to {high:.6g}; digits and multipliers are enclosed"
    return replace(found, entry={"kind": "cycle", **made.entry}, files=made.files, notes=(*found.notes, more))


def _judged(goal: Goal, proof: Proof, areas: Sequence[Part], unbounded: str) -> Found:
    """The verdict where an orbit is proved: `attracting` is more."""
    text, entry = told(proof.plane, proof.fixed, proof.passed, proof.multipliers), entry_of(proof.plane, proof.fixed)
    if not goal.attracting:
        return Found(Proved(), text, entry, (text,))
    if _repels(proof.multipliers):
        return Found(Refuted(), f"it repels: {text}", entry, (f"the orbit repels: {text}",))
    if any(d.largest() >= 1 for d in proof.multipliers):
        return Found(
            Unknown("orbit", "a periodic orbit was proved, but not whether near runs come to it"), text, None, (text,)
        )
    if not areas:
        return Found(Unknown("orbit", f"a periodic orbit was proved; {unbounded}"), text, None, (text,))
    found = basin(proof.plane, proof.fixed)
    if found is None or not all(map(Arrivals(proof.plane, found).come_in, areas)):
        reason = "a periodic orbit was proved to which near runs come, but not that all runs from the section do"
        return Found(Unknown("orbit", reason, next_step="claim it of a smaller section"), text, None, (text,))
    more = f"all runs from the section come to where a lap contracts by {found.factor:.3g} at least"
    return Found(Proved(), text, {**entry, "radius": str(Q(found.radius))}, (text, more))


def _repels(multipliers: Sequence[Disc]) -> bool:
    """Whether one multiplier is certainly larger than one: that of a disc which touches none with smaller ones."""
    inner = [d for d in multipliers if d.least() <= 1]
    return any(d.least() > 1 and all(d.is_apart(e) for e in inner) for d in multipliers)
