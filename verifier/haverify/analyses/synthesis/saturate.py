"""Differential saturation: prove cuts one after the other, from cheap to dear, until domain and cuts imply the goal."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from time import monotonic

from haverify.analyses.synthesis.candidates import (
    below,
    closures,
    extremes,
    fits,
    says_nothing,
    shapes,
    simple_between,
)
from haverify.analyses.synthesis.integrals import darboux_polynomials, first_integrals
from haverify.analyses.synthesis.keep import boundary, keep
from haverify.analyses.synthesis.samples import Samples, branches, inside, sample
from haverify.analyses.synthesis.system import Cut, System
from haverify.maths.polynomial import Polynomial
from haverify.obligations.formula import Literal, literals, negation
from haverify.obligations.premises import Premises, whole
from haverify.solvers.positivity.levels import MONOMIALS, NUMBERS, PAIRS, PRODUCTS, SQUARES, Level
from haverify.solvers.positivity.refute import Effort, is_absurd, refute
from haverify.text.record import holder

CHEAP: tuple[Level, ...] = (NUMBERS, MONOMIALS)
MEDIUM: tuple[Level, ...] = (NUMBERS, SQUARES, PAIRS)
DEAR: tuple[Level, ...] = (NUMBERS, SQUARES, PAIRS, PRODUCTS)


@holder
class Search:
    """The cuts so far, and the time that is left."""

    system: System
    samples: Samples
    until: float
    cuts: list[Cut]
    tried: set[object]

    def effort(self, levels: tuple[Level, ...], seconds: float) -> Effort:
        """Levels within so many seconds, and within the time that is left."""
        return Effort(levels, min(self.until, monotonic() + seconds))

    def premises(self) -> Premises:
        """What holds at all times, and the cuts."""
        return self.system.common.with_(*(q for c in self.cuts for q in c.literals))

    def is_over(self) -> bool:
        """Whether the time is up."""
        return monotonic() > self.until

    def attempt(self, cut: Sequence[Literal], levels: tuple[Level, ...]) -> bool:
        """Adds the conjunction as a cut if it holds at the starts and is kept."""
        cut = [Literal(q.op, whole(q.polynomial)) for q in cut]
        key = (tuple(cut), levels, len(self.cuts))
        if key in self.tried or self.is_over():
            return False
        self.tried.add(key)
        premises = self.premises()
        if not all(fits(q, self.samples) for q in cut):
            return False
        if all(is_absurd(premises.with_(negation(q)).entries) or says_nothing(q, self.samples) for q in cut):
            return False
        rule = keep(premises, cut, self.system.field, self.effort(levels, 4))
        if rule is None or not all(self.starts_with(q) for q in cut):
            return False
        self.cuts.append(Cut(tuple(cut), rule))
        return True

    def starts_with(self, q: Literal) -> bool:
        """Whether the literal was shown at all starts."""
        key = ("start", q)
        if key in self.tried:
            return True
        effort = self.effort(MEDIUM, 4)
        done = all(refute(s.with_(negation(q)), effort) is not None for s in self.system.starts)
        if done:
            self.tried.add(key)
        return done

    def is_done(self, levels: tuple[Level, ...]) -> bool:
        """Whether domain and cuts imply the goal."""
        return refute(self.premises().with_(negation(self.system.goal)), self.effort(levels, 8)) is not None


def invent(system: System, seconds: float) -> list[Cut] | None:
    """Cuts that, with the common premises, imply the goal, each kept under those before it; None if not found."""
    until = monotonic() + seconds
    search = Search(system, sample(system), until, [], set())
    for stage in (_goal_itself, _equations, _constants, _integrals, _signs, _boxes):
        stage(search)
        if search.is_done(MEDIUM):
            return search.cuts
        if search.is_over():
            return None
    for levels in (MEDIUM, DEAR):
        for stage in (_signs, _boxes):
            stage(search, levels)
            if search.is_done(DEAR):
                return search.cuts
            if search.is_over():
                return None
    return None


def _goal_itself(search: Search) -> None:
    """The goal may be inductive."""
    for q in literals(search.system.goal):
        search.attempt([q], CHEAP)


def _equations(search: Search) -> None:
    """Equations that hold at the starts: one by one, then all that are left together."""
    if len(search.system.starts) != 1:
        return
    found = [e for e in search.system.starts[0].entries if isinstance(e, Literal) and e.op == "=="]
    left = found
    for _ in range(3):
        now = [q for q in left if not search.attempt([q], CHEAP)]
        if len(now) == len(left):
            break
        left = now
    fitting = [q for q in left if fits(q, search.samples)]
    if len(fitting) > 1:
        search.attempt(fitting, CHEAP)


def _constants(search: Search) -> None:
    """What the starts say of names that never change."""
    field = search.system.field
    if len(search.system.starts) == 1:
        for e in search.system.starts[0].entries:
            if isinstance(e, Literal) and not any(field[v].whole for v in e.polynomial.variables if v in field):
                search.attempt([e], CHEAP)


def _integrals(search: Search) -> None:
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
        for c in _between(search, p.scaled(Fraction(sign)), top):
            if search.attempt([below(p.scaled(Fraction(sign)), c)], levels):
                break


def _between(search: Search, p: Polynomial, top: float) -> Iterator[Fraction]:
    """Bounds above the starts' greatest value, those below the least value of the unsafe states first."""
    spread = max(abs(top), 1e-3)
    for case in branches([*search.premises().entries, negation(search.system.goal)], 6):
        unsafe = extremes(p, inside(case, search.samples.names, 40), search.samples.names)
        if unsafe is not None and unsafe[0] > top:
            yield simple_between(top, unsafe[0])
            yield simple_between(top, top + (unsafe[0] - top) / 4)
    yield simple_between(top + spread / 50, top + spread / 10)


def _signs(search: Search, levels: tuple[Level, ...] = CHEAP) -> None:
    """Polynomials in sight, and those with `p' = c p`, by their signs and by bounds from starts and goal."""
    polys = shapes(search.system)
    polys += list(_darboux(search))
    for _ in range(3):
        before = len(search.cuts)
        for q in literals(search.system.goal):
            search.attempt([q], levels)
        for p in polys:
            for q in _signed(search, p):
                search.attempt([q], levels)
        if len(search.cuts) == before or search.is_done(CHEAP):
            return


def _darboux(search: Search) -> Iterator[Polynomial]:
    seen: set[Polynomial] = set()
    for names in closures(search.system.field):
        if len(names) > 6:
            continue
        for degree in (1, 2):
            for p, _ in darboux_polynomials(search.system.field, names, degree, 20):
                if p not in seen and -p not in seen and max(map(abs, p.whole.values())) < 10**4:
                    seen.add(p)
                    yield p


def _signed(search: Search, p: Polynomial) -> Iterator[Literal]:
    """Literals that bound p: strictly by 0, and by its extremes at the starts."""
    at_start = extremes(p, search.samples.starts, search.samples.names)
    if at_start is None:
        return
    low, high = at_start
    if low > 0:
        yield below(-p, op="<")
    elif low > -1e-9:
        yield below(-p)
    if high < 0:
        yield below(p, op="<")
    elif high < 1e-9:
        yield below(p)
    yield from _box_of(search, p)


def _box_of(search: Search, p: Polynomial) -> Iterator[Literal]:
    """Bounds of p at the starts, where they are simple numbers."""
    at_start = extremes(p, search.samples.starts, search.samples.names)
    assert at_start is not None
    for sign, top in ((1, at_start[1]), (-1, -at_start[0])):
        c = Fraction(top + 1e-7 * (1 + abs(top))).limit_denominator(20)
        if abs(float(c) - top) < 0.1 * (1 + abs(top)):
            bound = c if c >= Fraction(top - 1e-6) else c + Fraction(1, 20)
            yield below(p.scaled(Fraction(sign)), bound)


def _boxes(search: Search, levels: tuple[Level, ...] = CHEAP) -> None:
    """The greatest part of many bounds that the flow keeps as a whole, strictly."""
    found: list[Literal] = []
    for p in shapes(search.system)[:12]:
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
    for sign, start, top in ((1, at_start[1], reached[1]), (-1, -at_start[0], -reached[0])):
        signed = p.scaled(Fraction(sign))
        tops = [simple_between(top, top + spread / 50), simple_between(top + spread / 8, top + spread / 4)]
        if start < 0 <= top + 1e-9 or abs(top) < spread / 8:
            tops.append(Fraction(0))
        found += [below(signed, c) for c in tops]
    for q in literals(search.system.goal):
        if q.polynomial in (p, -p):
            found += [below(q.polynomial), below(-q.polynomial)]
    return found
