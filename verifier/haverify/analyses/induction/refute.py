"""Why premises have no common point: a PROOF of docs/core.md section 9, or None where none was found."""

from __future__ import annotations

from typing import Any

from haverify.analyses.induction.boxes import on_boxes
from haverify.analyses.induction.identities import cancelled, glance
from haverify.analyses.induction.inverses import reduced
from haverify.analyses.induction.signs import absurd
from haverify.maths.polynomial import Polynomial
from haverify.obligations.formula import Formula, Junction, Literal
from haverify.obligations.functions import PARTIAL, SERIES
from haverify.obligations.induction import names_of
from haverify.obligations.premises import Premises, formula_json
from haverify.text.record import record

Json = Any


@record
class Effort:
    """How much may be tried: leaves of one tree of boxes, cases of disjunctions; `is_deep`: programs as well."""

    leaves: int = 200
    cases: int = 64
    is_deep: bool = False


MOST_KNOWN = 2000
_KNOWN: dict[tuple[tuple[Formula, ...], Effort], Json] = {}  # the name of a function says all about it


def refute(premises: Premises, effort: Effort) -> Json | None:
    """A proof that the premises have no common point.

    The same is asked again and again: for other orders of cuts, and for other values of params that are not in it.
    """
    key = premises.entries, effort
    if key not in _KNOWN:
        if len(_KNOWN) >= MOST_KNOWN:
            _KNOWN.clear()
        _KNOWN[key] = _refute(premises, effort)
    return _KNOWN[key]


def _refute(premises: Premises, effort: Effort) -> Json | None:
    if absurd(premises.entries):
        return "t"
    put = solvable(premises)
    if put is not None:
        i, name, value = put
        inner = refute(premises.mapped({name: value}), effort)
        return None if inner is None else ["put", i, name, inner]
    told = _meaning(premises)
    if told is not None:
        inner = refute(premises.with_(premises.functions.meaning(told)), effort)
        return None if inner is None else ["fact", "meaning", told, inner]
    product = reduced(premises)
    if product is not None:
        formula, proof = product
        if formula is False:
            return proof
        inner = refute(premises.with_(formula), effort)
        return None if inner is None else ["cut", formula_json(formula), inner, proof]
    pinned = _pinned(premises)
    if pinned is not None:
        inner = refute(premises.with_(pinned), effort)
        return None if inner is None else ["cut", formula_json(pinned), inner, "t"]
    factor = cancelled(premises)
    if factor is not None:
        formula, proof = factor
        inner = refute(premises.with_(formula), effort)
        return None if inner is None else ["cut", formula_json(formula), inner, proof]
    found = glance(premises.entries)
    return found or _cases(premises, effort) or on_boxes(premises, effort.leaves) or _with_series(premises, effort)


def _meaning(premises: Premises) -> str | None:
    """A root, a logarithm or an inverse of which nothing has been said yet."""
    known = premises.functions.known
    read = {n for f in premises.entries for n in names_of(f) if n in known and known[n][0] in PARTIAL}
    size = len(premises.entries)
    new = (n for n in sorted(read) if len(premises.with_(premises.functions.meaning(n)).entries) > size)
    return next(new, None)


def _with_series(premises: Premises, effort: Effort) -> Json | None:
    """The same with the first bounds of the series of functions, where there are new ones."""
    told = premises
    steps: list[tuple[str, int]] = []
    for name in sorted(
        {n for f in premises.entries for n in names_of(f) if premises.functions.known.get(n, (None,))[0] in SERIES}
    ):
        for n in (2,) if name.startswith("exp") else (1, 2):
            more = told.with_(premises.functions.series(name, n))
            steps += [(name, n)] if len(more.entries) > len(told.entries) else []
            told = more
    proof = glance(told.entries) if steps else None
    for name, n in reversed(steps):
        proof = proof and ["fact", "series", name, n, proof]
    return proof


def solvable(premises: Premises) -> tuple[int, str, Polynomial] | None:
    """An equation that says what a name is, without that name inside of a function on its other side."""
    for i, f in enumerate(premises.entries):
        if not isinstance(f, Literal) or f.op != "==":
            continue
        p = f.polynomial
        for v in p.variables:
            alone = [m for m in p.terms if any(w == v for w, _ in m)]
            if v not in premises.functions.known and alone == [((v, 1),)]:
                rest = p - Polynomial({((v, 1),): p.whole[((v, 1),)]}, p.divisor)
                if v not in set(premises.functions.support(rest.variables)):
                    return i, v, rest.scaled(-1 / p.terms[((v, 1),)])
    return None


def _pinned(premises: Premises) -> Literal | None:
    """An equation between two inequalities that meet."""
    found = {f.polynomial for f in premises.entries if isinstance(f, Literal) and f.op == "<="}
    known = set(premises.entries)
    pairs = (Literal("==", p) for p in sorted(found, key=str) if -p in found)
    return next((f for f in pairs if f not in known and Literal("==", -f.polynomial) not in known), None)


def _cases(premises: Premises, effort: Effort) -> Json | None:
    """A proof for each member of a disjunction that says something new."""
    for i, f in enumerate(premises.entries):
        if isinstance(f, Junction) and not f.is_and and 1 < len(f.members) <= effort.cases:
            known = set(premises.entries)
            if any(set(premises.with_(m).entries) == known for m in f.members):
                continue
            less = Effort(max(8, effort.leaves // len(f.members)), effort.cases // len(f.members))
            proofs = []
            for m in f.members:
                found = refute(premises.with_(m), less)
                if found is None:
                    return None
                proofs.append(found)
            return ["or", i, proofs]
    return None
