"""Proofs that premises have no common point, in the form of a certificate."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from time import monotonic
from typing import Any

from haverify.maths.polynomial import Polynomial, constant, variable
from haverify.obligations.formula import Formula, Junction, Literal
from haverify.obligations.premises import Premises
from haverify.solvers.positivity import linear_search, semidefinite
from haverify.solvers.positivity.ansatz import Found, error, rescaled
from haverify.solvers.positivity.identity import Identity
from haverify.solvers.positivity.levels import Level, Question, ansatz, names_of
from haverify.text.record import record

Proof = Any
"""A PROOF of `docs/core.md`, section 9."""
MOST_BRANCHES = 64


@record
class Effort:
    """The levels to try, in order, and an instant (of the monotonic clock) to stop at."""

    levels: tuple[Level, ...]
    until: float

    def is_over(self) -> bool:
        """Whether the time is up."""
        return monotonic() > self.until

    def seconds(self) -> float:
        """The time that is left, at least a little."""
        return max(0.2, self.until - monotonic())


def refute(premises: Premises, effort: Effort) -> Proof | None:
    """Why the premises have no common point, or None where that was not found."""
    return _refute(premises, effort, MOST_BRANCHES)


def _refute(premises: Premises, effort: Effort, branches: int) -> Proof | None:
    if is_absurd(premises.entries):
        return "t"
    split = next((i for i, e in enumerate(premises.entries) if _is_open(e, premises.entries)), None)
    if split is None:
        return _linear(premises, effort)
    chosen = premises.entries[split]
    assert isinstance(chosen, Junction)
    if len(chosen.members) > branches:
        return None
    proofs = []
    for member in chosen.members:
        proof = _refute(premises.with_(member), effort, branches // len(chosen.members))
        if proof is None:
            return None
        proofs.append(proof)
    return ["or", split, proofs]


def _is_open(e: Formula, entries: Sequence[Formula]) -> bool:
    """Whether the entry is a disjunction none of whose members is known: there is something to split."""
    if not isinstance(e, Junction):
        return False
    return not any(
        all(p in entries for p in (m.members if isinstance(m, Junction) and m.is_and else (m,))) for m in e.members
    )


_SIGNS = {"<": frozenset("-"), "<=": frozenset("-0"), "==": frozenset("0"), "!=": frozenset("-+")}
_MIRROR = {"-": "+", "+": "-", "0": "0"}
Signs = dict[Polynomial, frozenset[str]]


def is_absurd(entries: Sequence[Formula]) -> bool:
    """Whether an entry is false given the signs that the literals among all entries leave to polynomials."""
    left: Signs = {}
    for e in entries:
        if isinstance(e, Literal):
            for poly, signs in ((e.polynomial, _SIGNS[e.op]), (-e.polynomial, _mirrored(_SIGNS[e.op]))):
                left[poly] = left.get(poly, signs) & signs
    return any(_is_false(e, left) for e in entries)


def _mirrored(signs: frozenset[str]) -> frozenset[str]:
    return frozenset(_MIRROR[s] for s in signs)


def _is_false(e: Formula, left: Signs) -> bool:
    if isinstance(e, bool):
        return not e
    if isinstance(e, Junction):
        return (any if e.is_and else all)(_is_false(m, left) for m in e.members)
    return not left.get(e.polynomial, _SIGNS[e.op]) & _SIGNS[e.op]


def _linear(premises: Premises, effort: Effort) -> Proof | None:
    """Solves equations for a name that they contain once, linearly; then searches an identity."""
    for i, e in enumerate(premises.entries):
        name = _solvable(e, premises)
        if name is not None:
            assert isinstance(e, Literal)
            rest = premises.mapped({name: _solved(e.polynomial, name)})
            proof = "t" if is_absurd(rest.entries) else _linear(rest, effort)
            return None if proof is None else ["put", i, name, proof]
    found = identity(premises, effort)
    return None if found is None else found.proof()


def _solvable(e: Formula, premises: Premises) -> str | None:
    """A name that a linear equation gives as a combination of the others."""
    if not isinstance(e, Literal) or e.op != "==" or e.polynomial.total_degree() != 1:
        return None
    if any(v in premises.functions.known for v in e.polynomial.variables):
        return None
    terms = e.polynomial.terms
    return max(e.polynomial.variables, key=lambda v: (abs(terms[((v, 1),)]) == 1, v))


def _solved(poly: Polynomial, name: str) -> Polynomial:
    return variable(name) - poly.scaled(1 / poly.terms[((name, 1),)])


def identity(premises: Premises, effort: Effort) -> Identity | None:
    """An identity that shows that the literals among the premises have no common point."""
    entries = premises.entries
    question = Question(entries, places_of(entries))
    for level in effort.levels:
        found = answer(question, level, effort)
        if found is not None:
            result = _identity(found)
            assert not result.total(entries).whole
            return result
        if effort.is_over():
            return None
    return None


def places_of(entries: Sequence[Formula]) -> tuple[int, ...]:
    """Where the literals are."""
    return tuple(i for i, e in enumerate(entries) if isinstance(e, Literal))


def answer(question: Question, level: Level, effort: Effort) -> Found | None:
    """A solution for the multipliers of a level."""
    wanted = ansatz(question, level)
    scale = scales(question)
    inner = rescaled(wanted, scale)
    try:
        if level.method == "squares":
            found = semidefinite.solve(inner, effort.seconds())
        else:
            found = linear_search.solve(inner, level.method == "pairs")
    except OverflowError:  # a coefficient beyond the floats in which the search is made
        return None
    if found is None:
        return None
    back = {v: variable(v) * constant(1 / s) for v, s in scale.items()}
    cones = {k: [(c, q.substitute(back)) for c, q in sums] for k, sums in found.cones.items()}
    result = Found(found.free, cones, found.strict)
    return None if error(wanted, result).whole else result


def scales(question: Question) -> dict[str, Fraction]:
    """A power of two for each name of the order of the bounds that the premises give it."""
    bounds: dict[str, Fraction] = {}
    for i in question.places:
        q = question.premises[i]
        if isinstance(q, Literal) and len(q.polynomial.variables) == 1 and q.polynomial.total_degree() == 1:
            (v,) = q.polynomial.variables
            size = abs(q.polynomial.terms.get((), Fraction(0)) / q.polynomial.terms[((v, 1),)])
            bounds[v] = max(bounds.get(v, Fraction(0)), size)
    return {v: _power_of_two(bounds.get(v, Fraction(1)) or Fraction(1)) for v in names_of(question)}


def _power_of_two(x: Fraction) -> Fraction:
    return Fraction(2) ** (x.numerator.bit_length() - x.denominator.bit_length())


def _identity(found: Found) -> Identity:
    """The solution as an identity; the first strict product with a weight is the strict one, others are cones."""
    strict = [(places, weight) for places, weight in found.strict.items() if weight]
    cones = [(tuple(sums), places) for places, sums in found.cones.items() if sums]
    cones += [(((w, constant(1)),), p) for p, w in strict[1:]]
    return Identity(tuple(cones), ideal_of(found.free), strict[0][1], strict[0][0])


def ideal_of(free: Mapping[tuple[Any, ...], Fraction]) -> tuple[tuple[int, Polynomial], ...]:
    """The multipliers of equations, by place."""
    sums: dict[int, Polynomial] = {}
    for (place, m), value in free.items():
        if value:
            sums[place] = sums.get(place, constant(0)) + m.scaled(value)
    return tuple(sorted(sums.items(), key=lambda x: x[0]))
