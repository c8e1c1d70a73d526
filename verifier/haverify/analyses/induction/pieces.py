"""One start that violates a claim whatever the value of a param in its range."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from haverify.analyses.induction.boxes import enclosed
from haverify.analyses.induction.decide import started
from haverify.analyses.induction.points import Point, farthest, satisfying
from haverify.analyses.induction.refutation import Start, Way, ways
from haverify.evidence.certificate import certificate
from haverify.evidence.evidence import Evidence, PartResult
from haverify.evidence.run import Run, Step
from haverify.evidence.verdict import Proved, Refuted, Verdict
from haverify.maths.bernstein import bounds
from haverify.maths.polynomial import constant, variable
from haverify.model.claim import Claim
from haverify.model.hybrid import HybridAutomaton
from haverify.model.spec import Spec
from haverify.obligations.formula import Literal, by_bounds, compare, truth
from haverify.obligations.induction import Induction
from haverify.obligations.obligation import hashes
from haverify.obligations.premises import Premises
from haverify.obligations.translate import OutsideFragmentError

Q = Fraction


def everywhere(spec: Spec, automaton: HybridAutomaton, claim: Claim, name: str) -> Evidence | None:
    """The refutation of a claim for all values of a param, None where no start was found that does it."""
    known = hashes(spec, automaton)
    for goal in claim.goals if len(claim.goals) == 1 else ():
        induction = Induction(spec, automaton, claim, goal)
        try:
            induction.check()
        except OutsideFragmentError:
            return None
        for way in ways(induction):
            found = next(_starts(induction, way, name), None)
            if found is None:
                continue
            entry = started(induction, found, known.part(known.goal(claim, goal), "start", found.mode, ""))
            params = {n: Q(q) for n, q in entry["start"]["params"].items()}
            del entry["start"]["params"][name]
            state = tuple((v.name, found.point[v.name]) for v in automaton.vars)
            steps = tuple(Step(Q(0), k, chosen) for k, chosen in found.jumps)
            verdict: Verdict = Refuted() if goal.kind == "always" else Proved()
            run = Run(found.mode, state, tuple(params.items()), steps, Q(0))
            part = PartResult(0, "start", found.mode, "", f"start in mode {found.mode}", verdict, run)
            word = "refuted" if goal.kind == "always" else "proved"
            return Evidence(verdict, (part,), "induction", certificate(claim.name, word, [entry], None))
    return None


def _starts(induction: Induction, way: Way, name: str) -> Iterator[Start]:
    """Starts with a value for all names but one that are admissible, and violate the goal, for all values of that."""
    low, high = induction.params[name]
    names = [n for n in way.names(induction) if n != name]
    for end in (low, high):
        at_end = way.told.with_(compare("==", variable(name) - constant(end)))
        for goal in (at_end.with_(way.wrong), at_end):
            first = satisfying(goal, way.names(induction), 200)
            if first is None:
                continue
            for point in farthest(at_end, first, names):
                if _holds(way.told.with_(way.wrong), {n: point[n] for n in names}, name, (low, high)):
                    yield way.start({**point, name: end})


def _holds(told: Premises, point: Point, name: str, ends: tuple[Q, Q]) -> bool:
    """Whether premises hold at a point for all values of a name in its range."""
    values = {n: constant(q) for n, q in point.items()}

    def known(leaf: Literal) -> bool | None:
        p = told.functions.substitute(leaf.polynomial, values)
        return by_bounds(leaf.op, *bounds(p, enclosed(told.functions, [Literal(leaf.op, p)], {name: ends})))

    return all(truth(f, known) is True for f in told.entries)
