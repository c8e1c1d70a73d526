"""Proofs that premises have no common point, in the form of a certificate."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from time import process_time
from typing import Any

from haverify.maths.polynomial import Polynomial, constant, variable
from haverify.obligations.formula import Formula, Junction, Literal, negation
from haverify.obligations.premises import Premises, formula_json
from haverify.solvers.positivity import linear_search, semidefinite
from haverify.solvers.positivity.ansatz import Found, Free, error
from haverify.solvers.positivity.identity import Identity
from haverify.solvers.positivity.levels import Level, Question, affine_names, ansatz, names_of
from haverify.solvers.positivity.powers import is_tall, lowered, powers, why
from haverify.text.record import record

Proof = Any
"""A PROOF of `docs/core.md`, section 9."""
MOST_BRANCHES = 64


@record
class Effort:
    """The levels to try, in order, and an instant of CPU time to stop at."""

    levels: tuple[Level, ...]
    until: float

    def is_over(self) -> bool:
        """Whether the time is up."""
        return process_time() > self.until

    def seconds(self) -> float:
        """The time that is left, at least a little."""
        return max(0.2, self.until - process_time())


def refute(premises: Premises, effort: Effort) -> Proof | None:
    """Why the premises have no common point, or None where that was not found."""
    return _refute(premises, effort, MOST_BRANCHES)


def _refute(premises: Premises, effort: Effort, branches: int) -> Proof | None:
    if is_absurd(premises.entries):
        return "t"
    tall = _unbounded_tall(premises)
    if tall is not None:
        return _bounded_first(premises, effort, branches, *tall)
    split = next((i for i, e in enumerate(premises.entries) if _is_open(e, premises.entries)), None)
    if split is None:
        return _linear(premises, effort)
    if branches == MOST_BRANCHES:  # perhaps the literals do without the disjunctions
        alone = _linear(premises, Effort(effort.levels[:1], effort.until))
        if alone is not None:
            return alone
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


def _unbounded_tall(premises: Premises) -> tuple[int, int, Literal] | None:
    """The place of a tall literal, one of the bounds that it implies, and which one, that is not among the entries."""
    for place, e in enumerate(premises.entries):
        if isinstance(e, Literal) and is_tall(e):
            for k, bound in enumerate(lowered(e)):
                if bound not in premises.entries:
                    return place, k, bound
    return None


def _bounded_first(
    premises: Premises, effort: Effort, branches: int, place: int, k: int, bound: Literal
) -> Proof | None:
    """The proof that cuts with a bound that a tall literal implies."""
    rest = _refute(premises.with_(bound), effort, branches)
    if rest is None:
        return None
    against = premises.with_(negation(bound)).entries
    shown = why(against, place, len(premises.entries), k)
    assert not shown.total(against).whole
    return ["cut", formula_json(bound), rest, shown.proof()]


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
    groups = components(entries)
    for level in effort.levels:
        for places in groups:
            found = answer(Question(entries, places), level, effort)
            if found is not None:
                result = _identity(found)
                assert not result.total(entries).whole
                return result
            if effort.is_over():
                return None
    return None


def components(entries: Sequence[Formula]) -> list[tuple[int, ...]]:
    """The places of literals that are connected by names they share, the groups with late ones first."""
    groups: list[tuple[set[str], list[int]]] = []
    for i, e in enumerate(entries):
        if isinstance(e, Literal) and not is_tall(e):
            names, places = set(e.polynomial.variables), [i]
            for group in [g for g in groups if g[0] & names]:
                names |= group[0]
                places += group[1]
                groups.remove(group)
            groups.append((names, places))
    return sorted((tuple(sorted(places)) for _, places in groups), key=lambda p: -p[-1])


def connected(entries: Sequence[Formula], names: Sequence[str]) -> tuple[int, ...]:
    """The places of the literals that are connected with names."""
    linked = [p for p in components(entries) if any(_mentions(entries[i], names) for i in p)]
    return tuple(sorted(i for p in linked for i in p))


def _mentions(e: Formula, names: Sequence[str]) -> bool:
    return isinstance(e, Literal) and any(v in names for v in e.polynomial.variables)


def answer(question: Question, level: Level, effort: Effort) -> Found | None:
    """A solution for the multipliers of a level."""
    if level.method == "affine" and not affine_names(question):
        return None
    there, back = coordinates(question)
    wanted = ansatz(moved(question, there), level)
    try:
        if level.method in ("squares", "affine"):
            found = semidefinite.solve(wanted, effort.seconds())
        else:
            found = linear_search.solve(wanted, level.method == "pairs")
    except OverflowError:  # a coefficient beyond the floats in which the search is made
        return None
    if found is None or error(wanted, found).whole:
        return None
    own = {f.key for f in question.free}
    free = {k if k in own else (k[0], k[1].substitute(back)): v for k, v in found.free.items()}
    cones = {k: [(c, q.substitute(back)) for c, q in sums] for k, sums in found.cones.items()}
    return Found(free, cones, found.strict)


Map = dict[str, Polynomial]


def moved(question: Question, there: Map) -> Question:
    """The question in other coordinates."""
    premises = tuple(
        Literal(e.op, e.polynomial.substitute(there)) if isinstance(e, Literal) else e for e in question.premises
    )
    target = None if question.target is None else question.target.substitute(there)
    return Question(
        premises, question.places, target, tuple(Free(f.key, f.poly.substitute(there)) for f in question.free)
    )


def coordinates(question: Question) -> tuple[Map, Map]:
    """Names as affine functions of coordinates in which the premises are of the order of 1, and the inverse."""
    known = [q for i in question.places if isinstance(q := question.premises[i], Literal)]
    bounds = bounds_of(known)
    there, back = {}, {}
    for v in names_of(question):
        middle, size = _frame(*bounds.get(v, (None, None)))
        there[v] = variable(v).scaled(size) + constant(middle)
        back[v] = (variable(v) - constant(middle)).scaled(1 / size)
    return there, back


def _frame(low: Fraction | None, high: Fraction | None) -> tuple[Fraction, Fraction]:
    """A middle, 0 where that is not far off, and a power of two for the size."""
    if low is None or high is None or high < low:
        end = high if low is None else low
        return Fraction(0), _power_of_two(abs(end) if end else Fraction(1))
    half, middle = (high - low) / 2, (low + high) / 2
    if abs(middle) > 2 * half:
        return middle, _power_of_two(half or Fraction(1))
    return Fraction(0), _power_of_two(max(abs(low), abs(high)) or Fraction(1))


def bounds_of(known: Sequence[Literal]) -> dict[str, tuple[Fraction | None, Fraction | None]]:
    """The bounds of names that the literals give by themselves, those of balls and ellipsoids rounded to floats."""
    found: dict[str, tuple[Fraction | None, Fraction | None]] = {}
    for q in known:
        p = q.polynomial
        if q.op != "!=" and len(p.variables) == 1 and p.total_degree() == 1:
            slope = p.terms[((p.variables[0], 1),)]
            bound = -p.terms.get((), Fraction(0)) / slope
            ends = (bound if slope < 0 or q.op == "==" else None, bound if slope > 0 or q.op == "==" else None)
            _narrow(found, p.variables[0], ends)
        elif q.op in ("<", "<="):
            for v, ends in ball(p).items():
                _narrow(found, v, ends)
    return found


Ends = tuple[Fraction | None, Fraction | None]


def _narrow(found: dict[str, Ends], v: str, ends: Ends) -> None:
    low, high = found.get(v, (None, None))
    lows, highs = [x for x in (low, ends[0]) if x is not None], [x for x in (high, ends[1]) if x is not None]
    found[v] = (max(lows, default=None), min(highs, default=None))


def ball(p: Polynomial) -> dict[str, tuple[Fraction, Fraction]]:
    """The box around `sum a (x - m)^n <= r` with even n and a > 0, if `p <= 0` says that; empty for anything else."""
    known = powers(p)
    if known is None:
        return {}
    found = {}
    for s in known[0]:
        reach = Fraction(float(known[1] / s.weight) ** (1 / s.exponent) * 1.000001)
        found[s.name] = (s.middle - reach, s.middle + reach)
    return found


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
