"""Cuts by signs: the goal itself, equations of the starts, constants, polynomials in sight or with `p' = c p`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction

from haverify.analyses.synthesis.candidates import below, closures, extremes, shapes, simple_between
from haverify.analyses.synthesis.equations import kept_together
from haverify.analyses.synthesis.integrals import darboux_polynomials
from haverify.analyses.synthesis.search import CHEAP, Search
from haverify.maths.polynomial import Polynomial, variable
from haverify.obligations.formula import Literal, literals
from haverify.solvers.positivity.levels import Level


def goal_itself(search: Search) -> None:
    """The goal may be inductive."""
    for q in literals(search.system.goal):
        search.attempt([q], CHEAP)


def equations(search: Search) -> None:
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


def constants(search: Search) -> None:
    """What the starts say of names that never change."""
    field = search.system.field
    if len(search.system.starts) == 1:
        for e in search.system.starts[0].entries:
            if isinstance(e, Literal) and not any(field[v].whole for v in e.polynomial.variables if v in field):
                search.attempt([e], CHEAP)


def signs(search: Search, levels: tuple[Level, ...] = CHEAP) -> None:
    """Polynomials in sight, and those with `p' = c p`, by their signs and by bounds from starts and goal."""
    if not search.found:
        search.found += [*shapes(search.system), *_darboux(search, (1, 2), 20)]
    _sign_all(search, search.found, levels)


def higher(search: Search) -> None:
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
