"""Why premises have no common point: the quick ways first, then, if asked for, linear and semidefinite programs."""

from __future__ import annotations

from time import process_time
from typing import TYPE_CHECKING, Any

from haverify.analyses.induction.refute import Effort, refute
from haverify.obligations.formula import Formula, Literal
from haverify.obligations.premises import Premises, members

if TYPE_CHECKING:
    from haverify.maths.polynomial import Polynomial
    from haverify.obligations.induction import Obligation
    from haverify.solvers.positivity.refute import Effort as Programs

Json = Any
SECONDS = 5.0
GLANCE = Effort(8, 8)


def prove(premises: Premises, effort: Effort) -> Json | None:
    """A PROOF, or None where none was found."""
    found = refute(premises, effort)
    if found is not None or not effort.is_deep:
        return found
    from haverify.solvers.positivity.refute import refute as by_programs

    return by_programs(premises, _programs())


def is_defined(ob: Obligation) -> bool:
    """Whether all roots and logarithms that a part evaluates certainly have values."""
    return all(refute(known, GLANCE) is not None for known in ob.undefined)


def rule_for(premises: Premises, kept: Formula, rates: dict[str, Polynomial], effort: Effort) -> Json | None:
    """A RULE for a conjunction of literals, by programs; functions are not understood there."""
    literals = [f for f in members(kept, is_and=True) if isinstance(f, Literal)]
    if not effort.is_deep or premises.functions.known or len(literals) < len(members(kept, is_and=True)):
        return None
    from haverify.analyses.synthesis.keep import keep

    return keep(premises, literals, rates, _programs())


def _programs() -> Programs:
    from haverify.solvers.positivity.levels import AFFINE, MONOMIALS, NUMBERS, PAIRS, PRODUCTS, SQUARES
    from haverify.solvers.positivity.refute import Effort as Found

    return Found((NUMBERS, MONOMIALS, AFFINE, SQUARES, PAIRS, PRODUCTS), process_time() + SECONDS)
