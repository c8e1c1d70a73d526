"""Conditions as disjunctions of conjunctions of polynomial literals.

What is no polynomial (a sine, a table, an interval of pi) becomes an unknown of its own, equal terms the same one. So
what has no solution here has none at all; a solution counts only where no such stand-in is involved.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from fractions import Fraction
from functools import reduce
from itertools import product
from math import prod
from operator import mul

from haverify.maths.polynomial import NOUGHT, Polynomial, constant, total, variable
from haverify.model.expression import Expr, operands
from haverify.model.hybrid import Range
from haverify.solvers.frame import Frame
from haverify.text.record import record

MAX_CASES = 64
MAX_POWER = 12
MAX_MONOMIALS = 200
STAND_IN = "?"  # starts the names of unknowns that stand for something else
QUOTIENT = "/"  # starts the names of unknowns that are defined by an equation
PI = "pi"
INVERSE = "1/pi"


class TooManyCasesError(Exception):
    """A condition has more cases than are worth writing out."""


@record
class Literal:
    """`poly relation 0`, relation one of `< <= == !=`; `origin` is the written condition it comes from."""

    poly: Polynomial
    relation: str
    origin: Expr | None = None


Case = tuple[Literal, ...]
Term = tuple[Case, Polynomial]  # a value, and the condition under which the term has it

_NEGATED = {"<": ">=", "<=": ">", ">": "<=", ">=": "<", "==": "!=", "!=": "=="}


def cases(e: Expr, frame: Frame, holds: bool = True) -> list[Case]:
    """The disjuncts of `e` (of `not e` where `holds` is False), strictness as written.

    Raises
    ------
    TooManyCasesError       past MAX_CASES disjuncts, or with polynomials past MAX_MONOMIALS monomials
    """
    reader = _READERS.get(e.op)
    if reader is not None:
        return _limited(reader(e, frame, holds))
    if e.op in _NEGATED:
        return _limited(_comparison(e, frame, holds))
    return _atom(e, frame, holds)


def _limited(found: Iterable[Case]) -> list[Case]:
    result: list[Case] = []
    for case in found:
        result.append(case)
        if len(result) > MAX_CASES:
            raise TooManyCasesError
    return result


def both(left: Iterable[Case], right: Iterable[Case]) -> list[Case]:
    """The disjuncts of a conjunction."""
    others = list(right)
    return _limited(a + b for a in left for b in others)


def _all(parts: Iterable[list[Case]]) -> list[Case]:
    result: list[Case] = [()]
    for part in parts:
        result = both(result, part)
    return result


def _any(parts: Iterable[list[Case]]) -> list[Case]:
    return [case for part in parts for case in part]


def _and(e: Expr, frame: Frame, holds: bool) -> list[Case]:
    parts = (cases(c, frame, holds) for c in e.children)
    return _all(parts) if holds == (e.op == "and") else _any(parts)


def _implies(e: Expr, frame: Frame, holds: bool) -> list[Case]:
    premise, conclusion = e.children
    left, right = cases(premise, frame, not holds), cases(conclusion, frame, holds)
    return left + right if holds else both(left, right)


def _not(e: Expr, frame: Frame, holds: bool) -> list[Case]:
    return cases(e.children[0], frame, not holds)


def _if(e: Expr, frame: Frame, holds: bool) -> list[Case]:
    condition, yes, no = e.children
    first = both(cases(condition, frame), cases(yes, frame, holds))
    return first + both(cases(condition, frame, holds=False), cases(no, frame, holds))


def _truth(e: Expr, _frame: Frame, holds: bool) -> list[Case]:
    return [()] if (e.op == "true") == holds else []


def _at(e: Expr, frame: Frame, holds: bool) -> list[Case]:
    if frame.mode is None:
        return _atom(e, frame, holds)
    return [()] if (frame.mode.name == e.name) == holds else []


def _jump(e: Expr, frame: Frame, holds: bool) -> list[Case]:
    if frame.jump is None:
        return _atom(e, frame, holds)
    is_true = frame.jump != "" if e.op == "jumped" else frame.jump == e.name
    return [()] if is_true == holds else []


def _let(e: Expr, frame: Frame, holds: bool) -> list[Case]:
    expr = frame.let(e.name)
    return cases(expr, frame, holds) if expr is not None else _atom(e, frame, holds)


def _const(e: Expr, frame: Frame, holds: bool) -> list[Case]:
    found = frame.scope.constants.get(e.name)
    if found is None or isinstance(found.value, Range):
        return _atom(e, frame, holds)
    return cases(found.value, frame, holds)


_READERS: dict[str, Callable[[Expr, Frame, bool], list[Case]]] = {
    "and": _and,
    "or": _and,
    "implies": _implies,
    "not": _not,
    "if": _if,
    "true": _truth,
    "false": _truth,
    "at": _at,
    "jump": _jump,
    "jumped": _jump,
    "let": _let,
    "const": _const,
}


def _comparison(e: Expr, frame: Frame, holds: bool) -> Iterable[Case]:
    relation = e.op if holds else _NEGATED[e.op]
    pairs = product(terms(e.children[0], frame), terms(e.children[1], frame))
    return ((*a, *b, _literal(p, relation, q, e)) for (a, p), (b, q) in pairs)


def _literal(left: Polynomial, relation: str, right: Polynomial, origin: Expr) -> Literal:
    if relation in (">", ">="):
        return Literal(right - left, relation.replace(">", "<"), origin)
    return Literal(left - right, relation, origin)


def _atom(e: Expr, frame: Frame, holds: bool) -> list[Case]:
    """A truth value that is not decided here: a variable, or a stand-in that is 0 or 1."""
    target = constant(1 if holds else 0)
    return _limited((*case, Literal(p - target, "==", e)) for case, p in terms(e, frame))


# ---- terms ---------------------------------------------------------------------


def terms(e: Expr, frame: Frame) -> list[Term]:
    """The values of `e`, each with the case in which it is the value."""
    reader = _TERMS.get(e.op)
    result = reader(e, frame) if reader else _stand_in(e, frame)
    if len(result) > MAX_CASES or any(len(p.whole) > MAX_MONOMIALS for _, p in result):
        raise TooManyCasesError
    return result


def number_of(e: Expr, frame: Frame) -> Fraction | None:
    """The value of an expression that has the same one everywhere; None for others."""
    if e.op == "num":
        return e.args[0] if isinstance(e.args[0], Fraction) else None
    try:
        found = terms(e, frame)
    except TooManyCasesError:
        return None
    return found[0][1].constant if len(found) == 1 else None


def _number(e: Expr, _frame: Frame) -> list[Term]:
    value = e.args[0]
    return [((), constant(value if isinstance(value, Fraction) else Fraction(0)))]


def _term_const(e: Expr, frame: Frame) -> list[Term]:
    """The value of a constant, the same in all modes: worked out once."""
    found = frame.scope.constants.get(e.name)
    if found is None or isinstance(found.value, Range):
        return _stand_in(e, frame)
    known, place = frame.scope.known, ("", e.name)  # no mode is called like that
    if place not in known:
        known[place] = terms(found.value, frame)
    value: list[Term] = known[place]
    return value


def _term_let(e: Expr, frame: Frame) -> list[Term]:
    """The value of an output; where it is polynomial, it is worked out once for the mode and values are put in."""
    expr = frame.let(e.name)
    if expr is None:
        return _stand_in(e, frame)
    known, place = frame.scope.known, (frame.mode.name if frame.mode else None, e.name)
    if place not in known:
        known[place] = terms(expr, Frame(frame.scope, frame.mode))
    found: list[Term] = known[place]
    if frame.jump is None and not frame.values:
        return found
    if any(_is_stand_in(v) for case, p in found for q in (p, *(x.poly for x in case)) for v in q.variables):
        return terms(expr, frame)
    return [(tuple(_put(x, frame) for x in case), p.substitute(frame.values)) for case, p in found]


def _is_stand_in(name: str) -> bool:
    return name.startswith((STAND_IN, QUOTIENT))


def _put(x: Literal, frame: Frame) -> Literal:
    return Literal(x.poly.substitute(frame.values), x.relation, x.origin)


def _term_sym(e: Expr, frame: Frame) -> list[Term]:
    enum = frame.scope.enums[str(e.args[0])]
    return [((), constant(enum.values.index(str(e.args[1])) + (enum.low or 0)))]


def _term_scale(e: Expr, frame: Frame) -> list[Term]:
    factor, exponent, inner = e.args
    if (
        not (isinstance(factor, Fraction) and isinstance(exponent, Fraction) and isinstance(inner, Expr))
        or exponent < 0
    ):
        return _stand_in(e, frame)
    by = (variable(PI) ** int(exponent)).scaled(factor)
    return [(case, by * p) for case, p in terms(inner, frame)]


def _each(e: Expr, frame: Frame) -> Iterable[tuple[Term, ...]]:
    """Every choice of one term for each argument; each of them makes a case of the whole."""
    parts = [terms(c, frame) for c in e.children]
    if prod(map(len, parts)) > MAX_CASES:
        raise TooManyCasesError
    return product(*parts)


def _sum(e: Expr, frame: Frame) -> list[Term]:
    return [
        (tuple([x for case, _ in chosen for x in case]), total([p for _, p in chosen])) for chosen in _each(e, frame)
    ]


def _difference(e: Expr, frame: Frame) -> list[Term]:
    return [((*a, *b), p - q) for (a, p), (b, q) in _each(e, frame)]


def _product(e: Expr, frame: Frame) -> list[Term]:
    return [
        (tuple([x for case, _ in chosen for x in case]), reduce(mul, [p for _, p in chosen]))
        for chosen in _each(e, frame)
    ]


def _negative(e: Expr, frame: Frame) -> list[Term]:
    return [(case, -p) for case, p in terms(e.children[0], frame)]


def _quotient(e: Expr, frame: Frame) -> list[Term]:
    return [_divided((*a, *b), p, q) for (a, p), (b, q) in _each(e, frame)]


def _divided(case: Case, p: Polynomial, q: Polynomial) -> Term:
    value = q.constant
    if value:
        return case, p.scaled(1 / value)
    if value is not None:  # a division by zero has no value: the case is impossible
        return (*case, Literal(constant(1), "<=")), NOUGHT
    result = variable(f"{QUOTIENT}({p})/({q})")
    return (*case, Literal(result * q - p, "=="), Literal(q, "!=")), result


def _power(e: Expr, frame: Frame) -> list[Term]:
    base, exponent = e.children
    n = exponent.args[0] if exponent.op == "num" else None
    if not isinstance(n, Fraction) or n.denominator != 1 or not 0 <= n <= MAX_POWER:
        return _stand_in(e, frame)
    return [(case, p ** int(n)) for case, p in terms(base, frame)]


def _abs(e: Expr, frame: Frame) -> list[Term]:
    inner = terms(e.children[0], frame)
    result: list[Term] = [((*case, Literal(-p, "<=")), p) for case, p in inner]
    return result + [((*case, Literal(p, "<")), -p) for case, p in inner]


def _extreme(e: Expr, frame: Frame) -> list[Term]:
    sign = 1 if e.op == "max" else -1
    result: list[Term] = []
    for chosen in _each(e, frame):
        condition = tuple(literal for case, _ in chosen for literal in case)
        for k, (_, p) in enumerate(chosen):
            worse = (Literal((q - p).scaled(Fraction(sign)), "<=") for j, (_, q) in enumerate(chosen) if j != k)
            result.append(((*condition, *worse), p))
    return result


def _clamp(e: Expr, frame: Frame) -> list[Term]:
    inner, low, high = e.children
    return terms(Expr("min", (Expr("max", (inner, low)), high)), frame)


def _choice(e: Expr, frame: Frame) -> list[Term]:
    condition, yes, no = e.children
    first = product(cases(condition, frame), terms(yes, frame))
    second = product(cases(condition, frame, holds=False), terms(no, frame))
    return [((*a, *b), p) for branch in (first, second) for a, (b, p) in branch]


def _stand_in(e: Expr, frame: Frame) -> list[Term]:
    parts = [terms(c, frame) for c in operands(e) if c.op not in _TRUTH]
    names = [str(a) for a in e.args if not isinstance(a, Expr | tuple)]
    names += [f"{c!r} with {dict(frame.values)!r}" for c in operands(e) if c.op in _TRUTH]
    result: list[Term] = []
    for chosen in product(*parts):
        label = ", ".join([*names, *(str(p) for _, p in chosen)])
        condition = tuple(literal for case, _ in chosen for literal in case)
        result.append((condition, variable(f"{STAND_IN}{e.op}({label})")))
    return result


_TRUTH = frozenset({*_NEGATED, "and", "or", "not", "implies", "globally", "eventually", "until", "forall", "exists"})

_TERMS: dict[str, Callable[[Expr, Frame], list[Term]]] = {
    "num": _number,
    "true": lambda _e, _f: [((), constant(1))],
    "false": lambda _e, _f: [((), NOUGHT)],
    "pi": lambda _e, _f: [((), variable(PI))],
    "time": lambda _e, _f: [((), variable("time"))],
    "var": lambda e, f: [((), f.variable(e.name))],
    "param": lambda e, _f: [((), variable(e.name))],
    "input": lambda e, _f: [((), variable(e.name))],
    "const": _term_const,
    "let": _term_let,
    "sym": _term_sym,
    "scale": _term_scale,
    "+": _sum,
    "-": _difference,
    "*": _product,
    "neg": _negative,
    "/": _quotient,
    "^": _power,
    "abs": _abs,
    "min": _extreme,
    "max": _extreme,
    "clamp": _clamp,
    "if": _choice,
}
