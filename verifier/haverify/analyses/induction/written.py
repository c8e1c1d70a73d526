"""Formulas that were found, as `.ha` text that says the same."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction

from haverify.elaborate.notation import quantity
from haverify.maths.polynomial import Monomial
from haverify.model.hybrid import HybridAutomaton, Param
from haverify.model.unit import ONE
from haverify.obligations.formula import Formula, Junction, Literal
from haverify.obligations.functions import Functions

_MIRRORED = {"<": ">", "<=": ">=", "==": "==", "!=": "!="}


def written(
    f: Formula, automaton: HybridAutomaton, params: Iterable[Param] = (), functions: Functions | None = None
) -> str:
    """A condition in the automaton's variables and `params`; what has a unit is divided by 1 of it."""
    names = {p.name: _plain(p.name, p.unit) for p in (*params, *automaton.params)}
    names |= {v.name: _plain(v.name, v.unit) for v in automaton.vars}
    for name, (op, a) in sorted((functions.known if functions is not None else {}).items(), key=lambda k: len(k[0])):
        terms = sorted(a.terms.items(), key=lambda t: (-sum(e for _, e in t[0]), t[0]))
        names[name] = f"{op}({_sum(terms, names)})"
    return _text(f, names)


def standing(mode: str) -> str:
    """That a run is in a mode; in one of a system put together, that all its parts are."""
    return " and ".join(f"at({m})" for m in mode.split(", "))


def _plain(name: str, unit: object) -> str:
    return name if unit is None or unit is ONE or str(unit) == "1" else f"({name} / (1 {unit}))"


def _text(f: Formula, names: dict[str, str]) -> str:
    if isinstance(f, bool):
        return "true" if f else "false"
    if isinstance(f, Junction):
        parts = [f"({_text(m, names)})" if isinstance(m, Junction) else _text(m, names) for m in f.members]
        return (" and " if f.is_and else " or ").join(parts)
    return _comparison(f, names)


def _comparison(q: Literal, names: dict[str, str]) -> str:
    """What is added on the left, what is subtracted on the right."""
    terms = sorted(q.polynomial.terms.items(), key=lambda t: (-sum(e for _, e in t[0]), t[0]))
    left = [(m, c) for m, c in terms if c > 0 and m]
    right = [(m, -c) for m, c in terms if c < 0 and m]
    c = q.polynomial.terms.get((), Fraction(0))
    if left:
        return f"{_sum(left, names)} {q.op} {_sum([*right, *_constant(-c, right)], names)}"
    return f"{_sum(right, names)} {_MIRRORED[q.op]} {_sum(_constant(c, []), names)}"


def _constant(c: Fraction, others: list[tuple[Monomial, Fraction]]) -> list[tuple[Monomial, Fraction]]:
    return [((), c)] if c or not others else []


def _sum(terms: list[tuple[Monomial, Fraction]], names: dict[str, str]) -> str:
    first, *rest = terms
    text = _term(*first, names) if first[1] >= 0 else f"-{_term(first[0], -first[1], names)}"
    for m, c in rest:
        text += f" {'+' if c > 0 else '-'} {_term(m, abs(c), names)}"
    return text


def _term(m: Monomial, c: Fraction, names: dict[str, str]) -> str:
    powers = [names.get(v, v) + (f"^{e}" if e > 1 else "") for v, e in m]
    number = [] if c == 1 and powers else [quantity(c, None)[1]]
    return " * ".join([*number, *powers])
