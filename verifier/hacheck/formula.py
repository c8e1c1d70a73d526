"""Formulas in negation normal form over literals `p < 0`, `p <= 0`, `p == 0`, `p != 0`.

A formula is True, False, ("and", f, ...), ("or", f, ...) or a literal (op, polynomial with integer coefficients).
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Iterator, Mapping
from fractions import Fraction
from typing import Any

from hacheck.polynomial import Env, Poly, derivative, mul, names, scale, substitute, total

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
        if f is True or f is False:
            if f is not neutral:
                return f
        elif f[0] == word:
            out += f[1:]
        else:
            out.append(f)
    return (word, *out) if len(out) > 1 else out[0] if out else neutral


def conj(members: Iterable[Formula]) -> Formula:
    """The conjunction, with truth constants folded."""
    return _join("and", True, members)


def disj(members: Iterable[Formula]) -> Formula:
    """The disjunction, with truth constants folded."""
    return _join("or", False, members)


def replace(f: Formula, change: Callable[[str, Poly], Formula], turn: bool = False) -> Formula:
    """The formula with every literal changed, and `and` and `or` exchanged where it is turned."""
    if isinstance(f, bool):
        return f is not turn
    if f[0] in ("and", "or"):
        return (conj if (f[0] == "and") is not turn else disj)(replace(g, change, turn) for g in f[1:])
    return change(f[0], f[1])


def negated(f: Formula) -> Formula:
    """The negation."""
    return replace(f, lambda op, p: literal(NEGATED[op], p), True)


def placed(f: Formula, env: Env) -> Formula:
    """The formula with variables replaced at once."""
    return replace(f, lambda op, p: literal(op, substitute(p, env))) if env else f


def soon(f: Formula, rates: Mapping[str, Poly]) -> Formula:
    """Where f is true at all times in (0, e) from now, for some e: signs are those of the first slope that is not 0."""

    def after(op: str, p: Poly) -> Formula:
        slope = total((1, mul(derivative(p, v), rates[v])) for v in sorted(names(p) & rates.keys()))
        if not slope.terms:
            return literal(op, p)
        if op in ("==", "!="):
            return (conj if op == "==" else disj)([literal(op, p), after(op, slope)])
        return disj([literal("<", p), conj([literal("<=", p), after(op, slope)])])

    return replace(f, after)


def members(f: Formula, word: str) -> tuple[Formula, ...]:
    """The members of a conjunction or disjunction, else the formula alone."""
    return f[1:] if not isinstance(f, bool) and f[0] == word else (f,)


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
    found = [g for g in members if g[0] not in ("and", "or")][:16]
    return any(negated(g) in found for g in found)
