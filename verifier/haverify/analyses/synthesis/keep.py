"""Show that a flow keeps a conjunction of literals, by the rules of `docs/core.md`, section 9."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from haverify.maths.elimination import echelon
from haverify.maths.polynomial import Monomial, Polynomial, constant, total
from haverify.obligations.formula import Literal
from haverify.obligations.formula import literal as at_zero
from haverify.obligations.premises import Premises, polynomial_json, whole
from haverify.solvers.positivity.ansatz import Free, Key, monomials
from haverify.solvers.positivity.identity import Identity
from haverify.solvers.positivity.levels import Question
from haverify.solvers.positivity.refute import Effort, answer, connected, ideal_of, is_absurd, refute

Rule = dict[str, Any]
Field = dict[str, Polynomial]
MOST_EQUATIONS = 12
COFACTOR = -1


def keep(premises: Premises, cut: Sequence[Literal], field: Field, effort: Effort) -> Rule | None:
    """A RULE for the conjunction `cut`, primitive literals, under the premises; None where none was found."""
    if all(q.op == "==" for q in cut):
        return darboux(premises, cut, field)
    if len(cut) == 1:
        found = darboux(premises, cut, field)
        if found is None and cut[0].op in ("<", "<="):
            found = growth(premises, cut[0], field, effort)
        if found is not None:
            return found
    return barrier(premises, cut, field, effort) if all(q.op in ("<", "<=") for q in cut) else None


def darboux(premises: Premises, cut: Sequence[Literal], field: Field) -> Rule | None:
    """Derivatives that are combinations of the polynomials themselves and of equations among the premises."""
    rates = [premises.functions.derivative(q.polynomial, field) for q in cut]
    names = names_in([*(q.polynomial for q in cut), *rates])
    known = [(i, e) for i, e in enumerate(premises.entries) if isinstance(e, Literal) and e.op == "=="]
    columns = [((0, k), q.polynomial) for k, q in enumerate(cut)]
    columns += [((1, i), e.polynomial) for i, e in known[-MOST_EQUATIONS:]]
    matrix, ideal = [], []
    for rate in rates:
        found = combination(rate, columns, names)
        if found is None:
            return None
        matrix.append([polynomial_json(found.get((0, k), constant(0))) for k in range(len(cut))])
        ideal.append([[i, polynomial_json(m)] for (kind, i), m in sorted(found.items()) if kind == 1])
    return {"rule": "darboux", "matrix": matrix, "ideal": ideal}


def names_in(polys: Sequence[Polynomial]) -> tuple[str, ...]:
    """The names of the polynomials, sorted."""
    return tuple(sorted({v for p in polys for v in p.variables}))


def combination(
    target: Polynomial, columns: Sequence[tuple[tuple[int, int], Polynomial]], names: tuple[str, ...]
) -> dict[tuple[int, int], Polynomial] | None:
    """Multipliers with `target = sum multiplier * column`, of degrees at most that of the target."""
    if not target.whole:
        return {}
    unknowns: list[tuple[tuple[int, int], Polynomial]] = []
    rows: dict[Monomial, dict[int, Fraction]] = {m: {} for m in target.whole}
    for key, poly in columns:
        for m in monomials(names, max(0, target.total_degree() - poly.total_degree())):
            for n, c in (m * poly).terms.items():
                rows.setdefault(n, {})[len(unknowns)] = c
            unknowns.append((key, m))
    solved = echelon((row, target.terms.get(m, Fraction(0))) for m, row in rows.items())
    if solved is None:
        return None
    found: dict[tuple[int, int], Polynomial] = {}
    for k, value in solved.solution({}).items():
        key, m = unknowns[k]
        found[key] = found.get(key, constant(0)) + m.scaled(value)
    return found


def growth(premises: Premises, q: Literal, field: Field, effort: Effort) -> Rule | None:
    """A cofactor c for which `p' - c p <= 0` just outside of `p <= 0` (inside of `p < 0`)."""
    p, rate = q.polynomial, premises.functions.derivative(q.polynomial, field)
    given = premises.with_(Literal("<", -p if q.op == "<=" else p))
    names = names_in([p, rate])
    slopes = [field[v].total_degree() - 1 for v in p.variables if v in field]
    room = max([0, rate.total_degree() - p.total_degree(), *slopes])
    free = tuple(Free((COFACTOR, m), -(m * p)) for m in monomials(names, room))
    question = Question(given.entries, connected(given.entries, names), rate, free)
    for level in effort.levels:
        found = answer(question, level, effort)
        if found is not None:
            cofactor = total(k[1].scaled(v) for k, v in found.free.items() if k[0] == COFACTOR)
            own: dict[Key, Fraction] = {k: v for k, v in found.free.items() if k[0] != COFACTOR}
            cones = tuple((tuple(s), places) for places, s in found.cones.items() if s)
            return _growth_rule(given, rate - cofactor * p, cofactor, cones, ideal_of(own))
        if effort.is_over():
            return None
    return None


def _growth_rule(given: Premises, excess: Polynomial, cofactor: Polynomial, cones: Any, ideal: Any) -> Rule:
    """The rule, its proof an identity whose strict premise is `excess > 0`."""
    known = given.with_(at_zero("<", -excess))
    proof: Any = "t"
    if (excess.constant or 0) > 0:  # the premises themselves have no common point
        proof = Identity(cones, ideal, excess.constant or Fraction(0), ()).proof()
    elif not is_absurd(known.entries):
        place = next(i for i, e in enumerate(known.entries) if is_multiple(e, -excess))
        last = known.entries[place]
        assert isinstance(last, Literal)
        m = next(iter(last.polynomial.whole))
        factor = last.polynomial.terms[m] / -excess.terms[m]
        scaled = tuple((tuple((c * factor, r) for c, r in s), places) for s, places in cones)
        shown = Identity(scaled, tuple((i, a.scaled(factor)) for i, a in ideal), Fraction(1), (place,))
        assert not shown.total(known.entries).whole
        proof = shown.proof()
    return {"rule": "growth", "cofactor": polynomial_json(cofactor), "band": None, "proof": proof}


def is_multiple(e: object, poly: Polynomial) -> bool:
    """Whether an entry is `poly < 0`, up to a positive factor."""
    return isinstance(e, Literal) and e.op == "<" and e.polynomial == whole(poly)


def barrier(premises: Premises, cut: Sequence[Literal], field: Field, effort: Effort) -> Rule | None:
    """For each literal: at its boundary, with the others kept, the flow points inwards strictly."""
    proofs = []
    for j in range(len(cut)):
        proof = refute(boundary(premises, cut, j, field), effort)
        if proof is None:
            return None
        proofs.append(proof)
    return {"rule": "barrier", "proofs": proofs}


def boundary(premises: Premises, cut: Sequence[Literal], j: int, field: Field) -> Premises:
    """What holds where literal j of the cut is about to fail."""
    others = [Literal("<=", o.polynomial) for k, o in enumerate(cut) if k != j]
    rate = premises.functions.derivative(cut[j].polynomial, field)
    return premises.with_(*others, Literal("==", cut[j].polynomial), at_zero("<=", -rate))
