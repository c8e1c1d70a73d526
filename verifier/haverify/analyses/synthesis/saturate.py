"""Differential saturation: prove cuts one after the other, from cheap to dear, until domain and cuts imply the goal."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from time import process_time

from haverify.analyses.synthesis.barriers import Shape, barrier
from haverify.analyses.synthesis.candidates import (
    below,
    closures,
    extremes,
    fits,
    says_nothing,
    shapes,
    simple_between,
)
from haverify.analyses.synthesis.equations import kept_together
from haverify.analyses.synthesis.integrals import darboux_polynomials, first_integrals
from haverify.analyses.synthesis.keep import boundary, keep
from haverify.analyses.synthesis.lyapunov import forms
from haverify.analyses.synthesis.samples import Samples, branches, inside, sample
from haverify.analyses.synthesis.system import Cut, System
from haverify.analyses.synthesis.used import used
from haverify.maths.polynomial import Polynomial, variable
from haverify.obligations.formula import Formula, Literal, literals, negation, variables
from haverify.obligations.premises import Premises, members, whole
from haverify.solvers.positivity.levels import HIGHER, MONOMIALS, NUMBERS, PAIRS, PRODUCTS, SQUARES, Level
from haverify.solvers.positivity.refute import Effort, is_absurd, refute
from haverify.text.record import field, holder, replace

CHEAP: tuple[Level, ...] = (NUMBERS, MONOMIALS)
MEDIUM: tuple[Level, ...] = (NUMBERS, SQUARES, PAIRS)
DEAR: tuple[Level, ...] = (NUMBERS, SQUARES, PAIRS, HIGHER, PRODUCTS)
RATES = (Fraction(0), Fraction(-1), Fraction(1), Fraction(-5), Fraction(-1, 10))
FIRST = tuple(Shape(d, d + 2, r) for d in (2, 4) for r in RATES)
LATER = tuple(Shape(d, d + 4, r) for d in (2, 4, 6) for r in RATES)


@holder
class Search:
    """The cuts so far, and the time that is left."""

    system: System
    samples: Samples
    until: float
    cuts: list[Cut]
    tried: set[object]
    found: list[Polynomial]
    open: list[Formula]
    needed: set[Literal] = field(default_factory=set)

    def effort(self, levels: tuple[Level, ...], seconds: float) -> Effort:
        """Levels within so many seconds, and within the time that is left."""
        return Effort(levels, min(self.until, process_time() + seconds))

    def premises(self) -> Premises:
        """What holds at all times, and the cuts."""
        return self.system.common.with_(*(q for c in self.cuts for q in c.literals))

    def is_over(self) -> bool:
        """Whether the time is up."""
        return process_time() > self.until

    def attempt(self, cut: Sequence[Literal], levels: tuple[Level, ...]) -> bool:
        """Adds the conjunction as a cut if it holds at the starts and is kept."""
        cut = [Literal(q.op, whole(q.polynomial)) for q in cut]
        key = (tuple(cut), levels, len(self.cuts))
        if key in self.tried or self.is_over():
            return False
        self.tried.add(key)
        premises = self.premises()
        if not all(self.is_relevant(q) and fits(q, self.samples) for q in cut):
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
        """Whether domain and cuts imply the goal; what they imply of it need not be asked again."""
        premises = self.premises()
        for part in list(self.open):
            known = premises.with_(part)
            proof = refute(known, self.effort(levels, 6))
            if proof is not None:
                self.open.remove(part)
                self.needed |= used(proof, known)
        return not self.open

    def is_relevant(self, q: Literal) -> bool:
        """Whether the literal says something of names that unsafe states are still linked with."""
        return not self.linked(self.open).isdisjoint(q.polynomial.variables)

    def linked(self, parts: Sequence[Formula]) -> set[str]:
        """The names that unsafe states are linked with."""
        return linked_names(self.system, parts)


def linked_names(system: System, parts: Sequence[Formula]) -> set[str]:
    """The names of formulas, of the rates of these, and of what starts and domain say of them."""
    names = {v for part in parts for v in variables(part)}
    entries = [variables(e) for p in (system.common, *system.starts) for e in p.entries]
    entries += [{v, *p.variables} for v, p in system.field.items()]
    for _ in entries:
        more = {v for e in entries if e & names for v in e}
        if more <= names:
            break
        names |= more
    return names


def invent(system: System, seconds: float) -> list[Cut] | None:
    """Cuts that, with the common premises, imply the goal, each kept under those before it; None if not found."""
    unsafe = [negation(g) for g in members(system.goal, is_and=True)]
    linked = linked_names(system, unsafe)
    system = replace(system, field={v: p for v, p in system.field.items() if v in linked})
    search = Search(system, sample(system), process_time() + seconds, [], set(), [], unsafe)
    for stage, levels in STAGES:
        stage(search)
        if search.is_done(levels):
            return pruned(search)
        if search.is_over():
            return None
    return None


def pruned(search: Search) -> list[Cut]:
    """The cuts that the goal rests on, their rules found anew; all cuts where that fails."""
    needed, kept = set(search.needed), list[Cut]()
    for k in reversed(range(len(search.cuts))):
        cut = search.cuts[k]
        if needed & set(cut.literals):
            kept.insert(0, cut)
            before = search.system.common.with_(*(q for c in search.cuts[:k] for q in c.literals))
            needed |= used(cut.rule, before)
    unsafe = [negation(g) for g in members(search.system.goal, is_and=True)]
    again = Search(search.system, search.samples, process_time() + 10, [], set(), [], unsafe)
    for cut in kept:
        rule = keep(again.premises(), cut.literals, search.system.field, again.effort(DEAR, 4))
        if rule is None:
            return search.cuts
        again.cuts.append(Cut(cut.literals, rule))
    return again.cuts if again.is_done(DEAR) else search.cuts


def _decreasing(search: Search) -> None:
    """Quadratic forms that decrease near an equilibrium, bounded between starts and unsafe states."""
    field, linked = search.system.field, search.linked(search.open)
    for group in closures(field):
        names = tuple(v for v in group if v in field and field[v].whole)
        if set(names) <= linked:
            for p in forms(field, names, search.samples):
                _bounded(search, p)


def _barriers(search: Search, shapes: Sequence[Shape]) -> None:
    """A barrier between the starts and each kind of unsafe states."""
    domain = [e for e in search.premises().entries if isinstance(e, Literal)]
    starts = [b for s in search.system.starts for b in branches(s.entries)]
    for part in list(search.open):
        linked = search.linked([part])
        names = tuple(v for v in search.samples.names if v in linked)
        for unsafe in branches([part]):
            for shape in shapes:
                if search.is_over() or (
                    len(starts) == 1 and _is_separated(search, domain, starts[0], unsafe, names, shape)
                ):
                    break


def _is_separated(
    search: Search,
    domain: Sequence[Literal],
    start: Sequence[Literal],
    unsafe: Sequence[Literal],
    names: tuple[str, ...],
    shape: Shape,
) -> bool:
    seconds = max(0.5, (search.until - process_time()) / 3)
    about = [[q for q in side if set(q.polynomial.variables) <= set(names)] for side in (domain, start, unsafe)]
    p = barrier(about[0], about[1], [*about[0], *about[2]], search.system.field, names, shape, seconds)
    return p is not None and search.attempt([below(p)], (SQUARES, HIGHER))


def _goal_itself(search: Search) -> None:
    """The goal may be inductive."""
    for q in literals(search.system.goal):
        search.attempt([q], CHEAP)


def _equations(search: Search) -> None:
    """Equations that hold at the starts: one by one, then all combinations that are kept together."""
    if len(search.system.starts) != 1:
        return
    known = [e for e in search.system.starts[0].entries if isinstance(e, Literal)]
    found = [e for e in known if e.op == "==" and search.is_relevant(e)]
    for q in found:
        search.attempt([q], CHEAP)
    kept = kept_together([q.polynomial for q in found], search.system.field)
    if kept:
        search.attempt([Literal("==", p) for p in kept], CHEAP)


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
    if not search.found:
        search.found += [*shapes(search.system), *_darboux(search, (1, 2), 20)]
    _sign_all(search, search.found, levels)


def _higher(search: Search) -> None:
    """Polynomials of higher degrees with `p' = c p`, and what was missed of the lower ones."""
    polys = [p for p in _darboux(search, (2, 3, 4), 60) if p not in search.found]
    search.found += polys
    _sign_all(search, polys, CHEAP)


def _sign_all(search: Search, polys: Sequence[Polynomial], levels: tuple[Level, ...]) -> None:
    for _ in range(3):
        before = len(search.cuts)
        for q in literals(search.system.goal):
            search.attempt([q], levels)
        for degree in sorted({p.total_degree() for p in polys}):
            known = len(search.cuts)
            for p in polys:
                for q in _signed(search, p) if p.total_degree() == degree else ():
                    search.attempt([q], levels)
            if len(search.cuts) > known and search.is_done(CHEAP):
                return
        if len(search.cuts) == before or search.is_over():
            return


def _darboux(search: Search, degrees: Sequence[int], tries: int) -> Iterator[Polynomial]:
    """Polynomials with `p' = c p`, constants replaced as the cuts say."""
    values = _constant_values(search)
    field = {v: p.substitute(values) for v, p in search.system.field.items() if v not in values}
    seen: set[Polynomial] = set()
    for names in closures(field):
        for degree in degrees if len(names) <= 6 else ():
            for p, _ in darboux_polynomials(field, names, degree, tries):
                if p not in seen and -p not in seen and max(map(abs, p.whole.values())) < 10**4:
                    seen.add(p)
                    yield p


def _constant_values(search: Search) -> dict[str, Polynomial]:
    """Constant names as combinations of others, by equations among the cuts."""
    found: dict[str, Polynomial] = {}
    field = search.system.field
    for e in search.premises().entries:
        if isinstance(e, Literal) and e.op == "==" and e.polynomial.total_degree() == 1:
            p = e.polynomial.substitute(found)
            if p.variables and not any(field[v].whole for v in p.variables if v in field):
                name = p.variables[0]
                value = variable(name) - p.scaled(1 / p.terms[((name, 1),)])
                found = {k: v.substitute({name: value}) for k, v in found.items()} | {name: value}
    return found


def _signed(search: Search, p: Polynomial) -> Iterator[Literal]:
    """Literals that bound p: strictly by 0, and by its extremes at the starts."""
    at_start = extremes(p, search.samples.starts, search.samples.names)
    if at_start is None:
        return
    low, high = at_start
    for signed, least in ((p, low), (-p, -high)):
        if least > 0:
            yield below(-signed, op="<")
        if -1e-9 < least < (high - low) / 4 + 1e-9:
            yield below(-signed)
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
    for sign, top in ((1, at_start[1]), (-1, -at_start[0])):
        room = max(at_start[1] - at_start[0], 1e-3)
        yield below(p.scaled(Fraction(sign)), simple_between(top + room / 8, top + room / 3))


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


STAGES: tuple[tuple[Callable[[Search], None], tuple[Level, ...]], ...] = (
    (_equations, CHEAP),
    (_constants, CHEAP),
    (_goal_itself, CHEAP),
    (_integrals, MEDIUM),
    (_signs, MEDIUM),
    (_boxes, MEDIUM),
    (_decreasing, MEDIUM),
    (_higher, MEDIUM),
    (lambda s: _barriers(s, FIRST), DEAR),
    (lambda s: _signs(s, MEDIUM), DEAR),
    (lambda s: _boxes(s, MEDIUM), DEAR),
    (lambda s: _barriers(s, LATER), DEAR),
)
