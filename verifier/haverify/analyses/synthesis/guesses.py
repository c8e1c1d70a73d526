"""Bounds worth trying in a mode of several: of names, of polynomials in sight in any mode, of first integrals."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from haverify.analyses.synthesis.candidates import below, closures, extremes, shapes, simple_between
from haverify.analyses.synthesis.integrals import first_integrals
from haverify.analyses.synthesis.samples import Samples
from haverify.analyses.synthesis.system import Hybrid, System
from haverify.maths.polynomial import Polynomial
from haverify.obligations.formula import Literal, literals

MOST_SHAPES = 16
MOST_INTEGRALS = 4


def guesses(system: System, samples: Samples, hybrid: Hybrid, mode: str) -> list[Literal]:
    """Literals that may hold in all states of a mode."""
    found = list(literals(system.goal))
    for p in _polynomials(hybrid, mode):
        found += _bounds(p, samples)
    return [q for q in dict.fromkeys(found) if q.op in ("<", "<=") and q.polynomial.variables]


def _polynomials(hybrid: Hybrid, mode: str) -> list[Polynomial]:
    system = hybrid.systems[mode]
    found = []
    for s in (system, *(o for m, o in hybrid.systems.items() if m != mode)):
        for names in closures(s.field):
            for degree in (1, 2, 3) if len(names) <= 4 else (1,):
                fresh = [
                    p
                    for p in first_integrals(s.field, names, degree)
                    if any(s.field[v].whole for v in p.variables if v in s.field)
                ]
                if fresh:
                    found += fresh[:MOST_INTEGRALS]
                    break
        found += shapes(s)
    for j in hybrid.jumps:
        if mode in (j.source, j.target):
            found += [
                q.polynomial
                for e in j.known.entries
                for q in literals(e)
                if set(q.polynomial.variables) <= set(system.field)
            ]
    return list(dict.fromkeys(p for p in found if p.variables and p.total_degree() <= 4))[: 2 * MOST_SHAPES]


def _bounds(p: Polynomial, samples: Samples) -> Iterator[Literal]:
    """The sign of a polynomial, and bounds at and a little beyond the sampled states."""
    import numpy

    states = samples.states
    states = states[numpy.abs(states).max(axis=1, initial=0) < 1e4]
    ends = extremes(p, states, samples.names)
    if ends is None:
        yield below(p)
        yield below(-p)
        return
    spread = max(ends[1] - ends[0], 1e-3)
    for sign, top in ((1, ends[1]), (-1, -ends[0])):
        signed = p.scaled(Fraction(sign))
        if top <= 1e-6 * (1 + spread):
            yield below(signed)
        room = 1e-6 * (1 + abs(top))
        c = Fraction(top + room).limit_denominator(20)
        yield below(signed, c if c >= top - room else c + Fraction(1, 20))
        exact = Fraction(top).limit_denominator(1000)
        if abs(exact - Fraction(top)) <= room:
            yield below(signed, exact)
        yield below(signed, simple_between(top + spread / 16, top + spread / 8))
        yield below(signed, simple_between(top + spread / 3, top + spread / 2))
