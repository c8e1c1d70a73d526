"""Cuts that bound single names, kept as products of bounds show at a glance: no program is asked."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from haverify.analyses.induction.refute import Effort, refute
from haverify.analyses.synthesis.bounded import between, ramps
from haverify.analyses.synthesis.candidates import below, extremes, fits
from haverify.analyses.synthesis.keep import Rule, boundary
from haverify.analyses.synthesis.search import CHEAP, Search
from haverify.analyses.synthesis.system import Cut
from haverify.maths.polynomial import Polynomial, variable
from haverify.obligations.formula import Literal
from haverify.obligations.formula import literal as at_zero

ROUNDS = 3
GLANCE = Effort(leaves=8)


def glances(search: Search) -> None:
    """Bounds of names, and of names less what they gain with a clock, at the starts or between these and the unsafe."""
    field = search.system.field
    sides = [variable(v).scaled(Fraction(s)) for v in field if field[v].whole for s in (1, -1)]
    sides += [p.scaled(Fraction(s)) for p in ramps(search) for s in (1, -1)]
    for _ in range(ROUNDS):
        left = [p for p in sides if not _is_bounded(search, p)]
        if len(left) == len(sides) or search.is_done(CHEAP):
            return
        sides = left


def _is_bounded(search: Search, p: Polynomial) -> bool:
    """Whether a bound of p was added."""
    for q in _bounds(search, p):
        if search.is_over():
            return False
        if fits(q, search.samples) and search.is_relevant(q):
            rule = _kept(search, q)
            if rule is not None and search.starts_with(q):
                search.cuts.append(Cut((q,), rule))
                return True
    return False


def _bounds(search: Search, p: Polynomial) -> Iterator[Literal]:
    ends = extremes(p, search.samples.starts, search.samples.names)
    if ends is None:
        return
    exact = Fraction(ends[1]).limit_denominator(1000)
    if abs(float(exact) - ends[1]) <= 1e-9 * (1 + abs(ends[1])):
        yield below(p, exact)
    yield from (below(p, c) for c in between(search, p, ends[1]))


def _kept(search: Search, q: Literal) -> Rule | None:
    """The name does not grow beyond the bound, or moves back strictly from it."""
    premises, rate = search.premises(), search.premises().functions.derivative(q.polynomial, search.system.field)
    proof = refute(premises.with_(Literal("<", -q.polynomial), at_zero("<", -rate)), GLANCE)
    if proof is not None:
        return {"rule": "growth", "cofactor": [], "band": None, "proof": proof}
    proof = refute(boundary(premises, [q], 0, search.system.field), GLANCE)
    return None if proof is None else {"rule": "barrier", "proofs": [proof]}
