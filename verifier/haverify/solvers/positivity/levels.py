"""Which multipliers to try for an identity, from few to many."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from collections.abc import Set as Names
from fractions import Fraction
from itertools import combinations

from haverify.maths.polynomial import Polynomial, constant, variable
from haverify.obligations.formula import Literal
from haverify.solvers.positivity.ansatz import Ansatz, Cone, Free, monomials
from haverify.solvers.positivity.identity import nonnegative, positive
from haverify.text.record import record

MOST_PREMISES = 14
MOST_BOUNDS = 40
MOST_STRICT = 6


@record
class Level:
    """How far to search: products of so many premises, multipliers up to a total degree, how they are solved for."""

    products: int
    degree: int  # beyond that of the premises
    method: str  # "numbers", "monomials", "pairs": linear programs; "squares", "affine": semidefinite ones


NUMBERS = Level(2, 0, "numbers")
MONOMIALS = Level(2, 0, "monomials")
PAIRS = Level(1, 0, "pairs")
AFFINE = Level(1, 0, "affine")
SQUARES = Level(1, 0, "squares")
PRODUCTS = Level(2, 0, "squares")
HIGHER = Level(1, 2, "squares")
HIGHEST = Level(2, 4, "squares")


@record
class Question:
    """Literals at places of a list of premises, and what else an identity has to contain."""

    premises: tuple[object, ...]
    places: tuple[int, ...]
    target: Polynomial | None = None  # None: a product of strict premises, or 1
    free: tuple[Free, ...] = ()


def names_of(question: Question) -> tuple[str, ...]:
    """The unknowns of the premises that are used, sorted."""
    found = {v for _, q in _literals(question) for v in q.polynomial.variables}
    if question.target is not None:
        found |= set(question.target.variables)
    return tuple(sorted(found))


def _literals(question: Question) -> list[tuple[int, Literal]]:
    found = []
    for i in question.places:
        q = question.premises[i]
        assert isinstance(q, Literal)
        found.append((i, q))
    return found


def affine_names(question: Question) -> frozenset[str]:
    """Names that only bounds of their own and one other literal (or the target) have, there with degree 1 together."""
    polys = [q.polynomial for _, q in _literals(question)]
    polys += [] if question.target is None else [question.target]
    joint = [p for p in polys if len(p.variables) > 1]
    named = {v for p in polys for v in p.variables if p.degree(v) > 1 and len(p.variables) == 1}
    found: set[str] = set()
    for v in names_of(question):
        is_once = v not in named and sum(v in p.variables for p in joint) == 1
        if is_once and all(degree_in(p, {*found, v}) <= 1 for p in joint):
            found.add(v)
    return frozenset(found) if set(names_of(question)) - found else frozenset()


def degree_in(p: Polynomial, names: Names[str]) -> int:
    """The degree in some names together."""
    return max((sum(e for v, e in m if v in names) for m in p.whole), default=0)


def ansatz(question: Question, level: Level) -> Ansatz:
    """The multipliers of a level; keys are tuples of places, of free ones a place and a monomial."""
    literals = _literals(question)
    linear = affine_names(question) if level.method == "affine" else frozenset()
    names = tuple(v for v in names_of(question) if v not in linear)
    polys = [q.polynomial for _, q in literals] + ([] if question.target is None else [question.target])
    top = max((degree_in(p, set(names)) for p in polys), default=0)
    degree = top + top % 2 + level.degree
    signed = [i for i, q in literals if q.op in ("<", "<=")][-(MOST_BOUNDS if linear else MOST_PREMISES) :]
    cones = list(_cones(question.premises, signed, names, degree, level))
    free = [f for f in question.free if degree_in(f.poly, linear) <= 1]
    for i, q in literals:
        if q.op == "==":
            room = max(degree - degree_in(q.polynomial, set(names)), 0) if level.method != "numbers" else 1
            factors = monomials(names, room)
            if not degree_in(q.polynomial, linear):
                factors += [m * variable(v) for v in sorted(linear) for m in monomials(names, room)]
            free += [Free((i, m), m * q.polynomial) for m in factors]
    strict = _strict(question.premises, literals, degree) if question.target is None else ()
    target = Polynomial({}) if question.target is None else question.target
    return Ansatz(target, tuple(free), tuple(cones), strict)


def _cones(
    premises: Sequence[object], signed: list[int], names: tuple[str, ...], degree: int, level: Level
) -> Iterator[Cone]:
    for count in range(level.products + 1):
        for places in combinations(signed, count):
            factor = nonnegative(premises, places)
            room = degree - degree_in(factor, set(names))
            if room >= 0 or (count == 1 and level.method == "numbers"):
                half = 0 if level.method == "numbers" and count else max(room, 0) // 2
                yield Cone(places, factor, tuple(monomials(names, half)))


def _strict(premises: Sequence[object], literals: list[tuple[int, Literal]], degree: int) -> tuple[Free, ...]:
    """1, and products of up to two strict premises."""
    places = [i for i, q in literals if q.op in ("<", "!=")][-MOST_STRICT:]
    found = [Free((), constant(Fraction(1)))]
    for count in (1, 2):
        for chosen in combinations(places, count):
            poly = positive(premises, chosen)
            if poly.total_degree() <= degree:
                found.append(Free(chosen, poly))
    return tuple(found)
