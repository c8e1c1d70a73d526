"""Premises in which a product of an inverse and its argument is replaced by 1, and why that may be done."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from haverify.maths.digits import rational_text
from haverify.maths.polynomial import NOUGHT, Monomial, Polynomial
from haverify.obligations.formula import Formula, Literal, literal, negation
from haverify.obligations.functions import factors
from haverify.obligations.premises import Premises, polynomial_json, whole
from haverify.text.record import record

Q = Fraction
Json = Any
MOST = 200  # replacements in one polynomial


@record
class Relation:
    """Entry `place` says `lead = rest`, with `lead` a product of an inverse and the first term of its argument."""

    place: int
    said: Polynomial
    lead: Monomial
    size: Q


def reduced(premises: Premises) -> tuple[Formula, Json] | None:
    """An inequality or equation without such products, if it is new, and a proof that it cannot fail."""
    relations = [r for i, f in enumerate(premises.entries) if (r := _relation(premises, i, f)) is not None]
    known = set(premises.entries)
    places = {r.place for r in relations}
    for i, f in enumerate(premises.entries) if relations else ():
        if not isinstance(f, Literal) or f.op == "!=" or i in places:
            continue
        rest, taken = _divided(f.polynomial, relations)
        short = literal(f.op, whole(rest)) if taken else True
        if short is not True and short not in known and negation(short) not in known:
            return short, _proof(i, f, rest, taken, len(premises.entries))
    return None


def _relation(premises: Premises, i: int, f: Formula) -> Relation | None:
    if not isinstance(f, Literal) or f.op != "==":
        return None
    known = premises.functions.known
    for v in f.polynomial.variables:
        if v in known and known[v][0] == "inv" and f.polynomial.degree(v) == 1:
            p = f.polynomial
            lead = max((m for m in p.terms if v in dict(m)), key=_order)
            if all(v in dict(m) or not m for m in p.terms) and len(lead) > 1:
                return Relation(i, p, lead, p.terms[lead])
    return None


def _order(m: Monomial) -> tuple[int, tuple[str, ...]]:
    return sum(e for _, e in m), tuple(sorted(factors(m), reverse=True))


def _divided(p: Polynomial, relations: list[Relation]) -> tuple[Polynomial, dict[int, Polynomial]]:
    """What is left of a polynomial, and what multiples of relations were taken off."""
    taken: dict[int, Polynomial] = {}
    for _ in range(MOST):
        step = next(((m, r) for m in p.whole for r in relations if _divides(r.lead, m)), None)
        if step is None:
            return p, taken
        m, r = step
        less = tuple((v, e - dict(r.lead).get(v, 0)) for v, e in m if e > dict(r.lead).get(v, 0))
        factor = Polynomial({less: 1}, 1).scaled(p.terms[m] / r.size)
        p = p - factor * r.said
        taken[r.place] = taken.get(r.place, NOUGHT) + factor
    return p, {}


def _divides(lead: Monomial, m: Monomial) -> bool:
    has = dict(m)
    return all(has.get(v, 0) >= e for v, e in lead)


def _proof(i: int, f: Literal, rest: Polynomial, taken: dict[int, Polynomial], place: int) -> Json:
    """The identity `rest + sum of multiples - f = 0`; the denied literal about `rest` is entry `place`."""
    is_number = rest.constant is not None
    c = rest.constant or Q(0)
    size = Q(1) if is_number else rest.terms[min(rest.terms)] / whole(rest).terms[min(rest.terms)]
    if f.op == "==":
        shown = rest if is_number else whole(rest)
        equal = [[i, polynomial_json(-shown)], *([k, polynomial_json(p * shown)] for k, p in taken.items())]
        last = [rational_text(c * c), []] if is_number else [rational_text(size), [place]]
        return ["psatz", [], equal, last]
    equal = [[k, polynomial_json(p)] for k, p in taken.items()]
    mine = [rational_text(c), []] if is_number else [rational_text(size), [place]]
    if f.op == "<":
        return ["psatz", [mine] if c or not is_number else [], equal, ["1", [i]]]
    return ["psatz", [["1", [i]]], equal, mine]
