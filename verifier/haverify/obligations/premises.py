"""Premises: lists of formulas whose common points a proof excludes, and their JSON (docs/core.md section 9)."""

from __future__ import annotations

from collections.abc import Sequence
from math import gcd
from typing import Any

from haverify.maths.digits import rational_text
from haverify.maths.polynomial import Polynomial
from haverify.obligations.formula import Formula, Junction, Literal, conjunction, disjunction, literal
from haverify.obligations.functions import Functions, factors
from haverify.text.record import record

Json = Any


@record
class Premises:
    """Formulas, none a conjunction or true, none twice, their literals primitive; only ever extended at the end."""

    functions: Functions
    entries: tuple[Formula, ...] = ()

    def with_(self, *formulas: Formula) -> Premises:
        """These and more."""
        found, seen = list(self.entries), set(self.entries)
        for f in formulas:
            for member in members(primitive(f), is_and=True):
                if member is not True and member not in seen:
                    seen.add(member)
                    found.append(member)
        return Premises(self.functions, tuple(found))

    def conjunction(self) -> Formula:
        """All of them."""
        return conjunction(self.entries)

    def mapped(self, values: dict[str, Polynomial]) -> Premises:
        """All entries with names replaced; they keep their places."""

        def put(f: Formula) -> Formula:
            return primitive(mapped(f, values, self.functions))

        return Premises(self.functions, tuple(put(f) for f in self.entries))


def mapped(f: Formula, values: dict[str, Polynomial], functions: Functions) -> Formula:
    """A formula with names replaced, also inside of functions."""
    if isinstance(f, Literal):
        return literal(f.op, functions.substitute(f.polynomial, values))
    if isinstance(f, Junction):
        return (conjunction if f.is_and else disjunction)([mapped(m, values, functions) for m in f.members])
    return f


def primitive(f: Formula) -> Formula:
    """The formula with coprime integer coefficients in each literal."""
    if isinstance(f, Literal):
        return literal(f.op, whole(f.polynomial))
    if isinstance(f, Junction):
        return (conjunction if f.is_and else disjunction)([primitive(m) for m in f.members])
    return f


def whole(p: Polynomial) -> Polynomial:
    """The positive multiple of a polynomial with coprime integer coefficients."""
    common = gcd(*p.whole.values()) or 1
    return Polynomial({m: c // common for m, c in p.whole.items()}, 1)


def polynomial_json(p: Polynomial) -> Json:
    """A POLY."""
    return [[rational_text(c), *factors(m)] for m, c in sorted(p.terms.items())]


def formula_json(f: Formula) -> Json:
    """A FORMULA."""
    if isinstance(f, bool):
        return f
    if isinstance(f, Literal):
        return [f.op, polynomial_json(f.polynomial)]
    return ["and" if f.is_and else "or", *(formula_json(m) for m in f.members)]


def members(f: Formula, *, is_and: bool) -> Sequence[Formula]:
    """The members of a conjunction (disjunction), else the formula alone."""
    return f.members if isinstance(f, Junction) and f.is_and is is_and else (f,)
