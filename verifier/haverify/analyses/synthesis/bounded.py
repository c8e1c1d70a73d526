"""Cuts that bound a polynomial: first integrals, forms that decrease, boxes whose sides the flow enters."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction

from haverify.analyses.synthesis.barriers import trap
from haverify.analyses.synthesis.candidates import (
    below,
    closures,
    extremes,
    fits,
    says_nothing,
    shapes,
    simple_between,
)
from haverify.analyses.synthesis.integrals import first_integrals
from haverify.analyses.synthesis.keep import boundary
from haverify.analyses.synthesis.lyapunov import forms
from haverify.analyses.synthesis.samples import branches, inside
from haverify.analyses.synthesis.search import CHEAP, MEDIUM, Search
from haverify.maths.polynomial import Polynomial, total, variable
from haverify.obligations.formula import Literal, literals, negation, variables
from haverify.obligations.premises import Premises
from haverify.solvers.positivity.levels import AFFINE, NUMBERS, SQUARES, Level
from haverify.solvers.positivity.refute import is_absurd, refute

RATES = (Fraction(1), Fraction(1, 4), Fraction(4))
LARGEST = 8


def decreasing(search: Search) -> None:
    """Quadratic forms that decrease near an equilibrium, bounded between starts and unsafe states."""
    field, linked = search.system.field, search.linked(search.open)
    for group in closures(field):
        names = tuple(v for v in group if v in field and field[v].whole)
        if set(names) <= linked:
            for p in forms(field, names, search.samples):
                _bounded(search, p)


def integrals(search: Search) -> None:
    """First integrals, bounded between starts and unsafe states."""
    found = []
    for names in closures(search.system.field):
        for degree in _degrees(len(names)):
            fresh = [p for p in first_integrals(search.system.field, names, degree) if p not in found]
            moving = [
                p for p in fresh if any(search.system.field[v].whole for v in p.variables if v in search.system.field)
            ]
            found += moving[:6]
            if moving:
                break
    for p in found[:12]:
        _bounded(search, p)


def rounds(search: Search) -> None:
    """Sums of squares of what moves, bounded between starts and unsafe states."""
    field = search.system.field
    for names in closures(field):
        moving = [v for v in names if v in field and field[v].whole and v != "time"]
        if len(moving) > 1:
            _bounded(search, total(variable(v) * variable(v) for v in moving), (NUMBERS, AFFINE, SQUARES))


def traps(search: Search) -> None:
    """Quadratic forms that decrease where they are large, bounded beyond the starts."""
    field = search.system.field
    for names in closures(field):
        moving = [v for v in names if v in field and field[v].whole]
        if not 1 < len(moving) <= LARGEST or "time" in names:
            continue
        domain = [e for e in search.premises().entries if isinstance(e, Literal) and variables(e) <= set(names)]
        for rate in RATES:
            p = None if search.is_over() else trap(domain, field, names, rate, 5.0)
            known = len(search.cuts)
            if p is not None:
                _bounded(search, p, (NUMBERS, AFFINE, SQUARES))
            if len(search.cuts) > known:
                break


def _degrees(names: int) -> tuple[int, ...]:
    return (1, 2, 3, 4) if names <= 3 else (1, 2) if names <= 9 else (1,)


def _bounded(search: Search, p: Polynomial, levels: tuple[Level, ...] = MEDIUM) -> None:
    """Cuts `p = c`, `p <= c`, `p >= c` with c between the starts and the unsafe states."""
    at_start = extremes(p, search.samples.starts, search.samples.names)
    if at_start is None:
        return
    low, high = at_start
    if high - low <= 1e-9 * (1 + abs(high)):
        value = Fraction(high).limit_denominator(10**4)
        if search.attempt([below(p, value, "==")], levels):
            return
    for sign, top in ((1, high), (-1, -low)):
        for c in between(search, p.scaled(Fraction(sign)), top):
            if search.attempt([below(p.scaled(Fraction(sign)), c)], levels):
                break


def between(search: Search, p: Polynomial, top: float) -> Iterator[Fraction]:
    """Bounds above the starts' greatest value, those below the least value of the unsafe states first."""
    spread = max(abs(top), 1e-3)
    for case in branches([*search.premises().entries, negation(search.system.goal)], 6):
        unsafe = extremes(p, inside(case, search.samples.names, 40), search.samples.names)
        if unsafe is not None and unsafe[0] > top:
            yield simple_between(top, unsafe[0])
            yield simple_between(top, top + (unsafe[0] - top) / 4)
    yield simple_between(top + spread / 50, top + spread / 10)
    yield simple_between(top + spread / 8, top + spread / 4)


def boxes(search: Search, levels: tuple[Level, ...] = CHEAP) -> None:
    """The greatest part of many bounds that the flow keeps as a whole, strictly."""
    found: list[Literal] = []
    for p in [*shapes(search.system)[:12], *ramps(search)]:
        found += _bounds(search, p)
    found = [q for q in dict.fromkeys(found) if fits(q, search.samples)]
    premises = search.premises()
    found = [q for q in found if not says_nothing(q, search.samples)]
    found = [q for q in found if not is_absurd(premises.with_(negation(q)).entries) and search.starts_with(q)]
    while found and not search.is_over():
        kept = [q for q in found if _is_inward(search, premises, q, found, levels)]
        if len(kept) == len(found):
            break
        found = kept
    if found:
        search.attempt(found, levels)


def ramps(search: Search) -> Iterator[Polynomial]:
    """Names less what they gain at most, in the sampled states, with a clock of the system; and the reverse."""
    field, samples = search.system.field, search.samples
    clocks = [v for v, p in field.items() if p.constant == 1 and v != "time"]
    for v in [v for v, p in field.items() if clocks and not (p.constant or not p.whole)]:
        ends = extremes(field[v], samples.states, samples.names)
        if ends is not None:
            room = max(abs(ends[0]), abs(ends[1]), 1e-2) / 4
            for k in (
                simple_between(ends[1] + room / 2, ends[1] + room),
                simple_between(ends[0] - room, ends[0] - room / 2),
            ):
                yield variable(v) - variable(clocks[0]).scaled(k)


def _is_inward(
    search: Search, premises: Premises, q: Literal, cut: Sequence[Literal], levels: tuple[Level, ...]
) -> bool:
    known = boundary(premises, cut, list(cut).index(q), search.system.field)
    return refute(known, search.effort(levels, 1.5)) is not None


def _bounds(search: Search, p: Polynomial) -> list[Literal]:
    """Several bounds for p: beyond the starts, beyond the sampled states, before the unsafe ones."""
    import numpy

    names, samples = search.samples.names, search.samples
    at_start = extremes(p, samples.starts, names)
    states = samples.states[numpy.abs(samples.states).max(axis=1, initial=0) < 1e4]
    reached = extremes(p, states, names)
    if at_start is None or reached is None:
        return []
    found: list[Literal] = []
    spread = max(reached[1] - reached[0], 1e-3)
    width = min(spread, max(at_start[1] - at_start[0], (1 + abs(at_start[1])) / 20))
    for sign, start, top in ((1, at_start[1], reached[1]), (-1, -at_start[0], -reached[0])):
        signed = p.scaled(Fraction(sign))
        tops = [simple_between(top, top + width / 16), simple_between(top + width / 8, top + width / 4)]
        tops += [simple_between(top + spread / 8, top + spread / 4)] if spread > 2 * width else []
        tops += [simple_between(top + 2 * spread, top + 4 * spread)] if p.total_degree() == 2 else []
        if start < 0 <= top + 1e-9 or abs(top) < spread / 8:
            tops.append(Fraction(0))
        found += [below(signed, c) for c in tops]
    for q in literals(search.system.goal):
        if q.polynomial in (p, -p):
            found += [below(q.polynomial), below(-q.polynomial)]
    return found
