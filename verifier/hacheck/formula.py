"""Formulas in negation normal form over literals `p < 0`, `p <= 0`, `p == 0`, `p != 0`.

A formula is True, False, ("and", f, ...), ("or", f, ...) or a literal (op, polynomial with integer coefficients).
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Iterator
from fractions import Fraction
from typing import Any

from hacheck.polynomial import Poly, names, scale

Formula = Any  # bool | tuple, as above
NEGATED = {"<": ">=", "<=": ">", ">": "<=", ">=": "<", "==": "!=", "!=": "=="}
CLOSED = {"<": "<=", "<=": "<=", ">": ">=", ">=": ">=", "==": "=="}  # `!=` becomes true (S6)
_COMPARED = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "==": operator.eq,
    "!=": operator.ne,
}


def sign_fits(op: str, sign: int | Fraction) -> bool:
    """Does a number of that sign satisfy `op 0`?"""
    return bool(_COMPARED[op](sign, 0))


def literal(op: str, p: Poly) -> Formula:
    """`p op 0` for any comparison, decided where p is a constant."""
    if not p.terms or (len(p.terms) == 1 and () in p.terms):
        return sign_fits(op, p.terms.get((), 0))
    whole = p if p.unit == 1 else Poly(p.terms, 1, p.bits - p.unit.bit_length() + 1)
    return ("<" + op[1:], scale(whole, -1)) if op[0] == ">" else (op, whole)


def _join(word: str, neutral: bool, members: Iterable[Formula]) -> Formula:
    out: list[Formula] = []
    for f in members:
        if f is (not neutral):
            return f
        if f is not neutral:
            out.extend(f[1:] if f[0] == word else (f,))
    return neutral if not out else out[0] if len(out) == 1 else (word, *out)


def conj(members: Iterable[Formula]) -> Formula:
    """The conjunction, with truth constants folded."""
    return _join("and", True, members)


def disj(members: Iterable[Formula]) -> Formula:
    """The disjunction, with truth constants folded."""
    return _join("or", False, members)


def replace(f: Formula, change: Callable[[str, Poly], Formula]) -> Formula:
    """The formula with every literal changed; sound for proofs where the new one implies the old."""
    if isinstance(f, bool):
        return f
    if f[0] in ("and", "or"):
        return (conj if f[0] == "and" else disj)(replace(g, change) for g in f[1:])
    return change(f[0], f[1])


def literals(f: Formula) -> Iterator[tuple[str, Poly]]:
    """All literals."""
    if not isinstance(f, bool):
        yield from (x for g in f[1:] for x in literals(g)) if f[0] in ("and", "or") else (f,)


def variables(f: Formula) -> set[str]:
    """The variables of all literals."""
    return {v for _, p in literals(f) for v in names(p)}


def true(f: Formula, holds: Callable[[str, Poly], bool]) -> bool:
    """Is the formula true when only literals with `holds` are known to be?"""
    if isinstance(f, bool):
        return f
    if f[0] == "and":
        return all(true(g, holds) for g in f[1:])
    if f[0] == "or":
        return any(true(g, holds) for g in f[1:]) or _exhaustive(f[1:])
    return holds(f[0], f[1])


def _exhaustive(members: tuple[Formula, ...]) -> bool:
    """Is one of a few alternatives the negation of another?"""
    found = [f for f in members if f[0] not in ("and", "or")][:16]
    return any(_denied(f) in found for f in found)


def _denied(f: Formula) -> Formula:
    op, p = f
    return (NEGATED[op], p) if op in ("==", "!=") else ("<=" if op == "<" else "<", scale(p, -1))
