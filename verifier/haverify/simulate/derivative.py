"""The derivative of an expression along a flow, as an expression (LANGUAGE S11)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction

from haverify.model.expression import Expr, number, operands
from haverify.obligations.translate import OutsideFragmentError

ZERO = number(0)
APPLIED = ("fuzzy", "table")  # what stands for an expression of its arguments

Definition = Callable[[Expr], Expr]


def derivative(e: Expr, rates: Mapping[str, Expr], definition: Definition) -> Expr:
    """How fast `e` changes where variables change at `rates`; at a corner the slope of the branch that is taken.

    `definition` gives what a let, a constant or an application stands for.

    Raises
    ------
    OutsideFragmentError    if no derivative of an operation is known
    """

    def of(x: Expr) -> Expr:
        return derivative(x, rates, definition)

    if e.op in ("num", "pi", "param", "const", "sym", "input"):
        return ZERO
    if e.op == "time":
        return number(1)
    if e.op == "var":
        return rates.get(e.name, ZERO)
    if e.op in ("let", *APPLIED):
        return of(definition(e))
    if e.op == "if":
        condition, yes, no = operands(e)
        return Expr("if", (condition, of(yes), of(no)))
    if e.op == "scale":
        q, k, inner = e.args
        return Expr("scale", (q, k, of(inner))) if isinstance(inner, Expr) else ZERO
    if e.op in ("+", "-", "neg"):
        return Expr(e.op, tuple(of(c) for c in e.children))
    if e.op == "der":
        return of(of(e.children[0]))
    return _of_function(e, of)


def _of_function(e: Expr, of: Callable[[Expr], Expr]) -> Expr:
    if e.op == "*":
        parts = [times(*e.children[:i], of(c), *e.children[i + 1 :]) for i, c in enumerate(e.children)]
        return plus(*parts)
    if e.op == "/":
        a, b = e.children
        return over(minus(times(of(a), b), times(a, of(b))), times(b, b))
    if e.op == "^":
        base, exponent = e.children
        if exponent.op != "num":
            raise OutsideFragmentError("the derivative of a power whose exponent is no number")
        n = Fraction(str(exponent.args[0]))
        return ZERO if n == 0 else times(number(n), Expr("^", (base, number(n - 1))), of(base))
    if e.op in _SLOPES:
        return times(_SLOPES[e.op](e, e.children[0]), of(e.children[0]))
    if e.op == "abs":
        (a,) = e.children
        return Expr("if", (Expr(">=", (a, ZERO)), of(a), Expr("neg", (of(a),))))
    if e.op in ("min", "max"):
        return _of_least(e, of)
    if e.op == "clamp":
        a, low, high = e.children
        return of(Expr("min", (Expr("max", (a, low)), high)))
    raise OutsideFragmentError(f"the derivative of `{e.op}`")


def _of_least(e: Expr, of: Callable[[Expr], Expr]) -> Expr:
    first, *rest = e.children
    if not rest:
        return of(first)
    other = Expr(e.op, tuple(rest)) if len(rest) > 1 else rest[0]
    return Expr("if", (Expr("<=" if e.op == "min" else ">=", (first, other)), of(first), of(other)))


def times(*factors: Expr) -> Expr:
    return ZERO if ZERO in factors else Expr("*", factors)


def plus(*terms: Expr) -> Expr:
    kept = tuple(t for t in terms if t != ZERO)
    return ZERO if not kept else kept[0] if len(kept) == 1 else Expr("+", kept)


def minus(a: Expr, b: Expr) -> Expr:
    return a if b == ZERO else Expr("-", (a, b))


def over(a: Expr, b: Expr) -> Expr:
    return ZERO if a == ZERO else Expr("/", (a, b))


def _one_and_square(sign: str, a: Expr) -> Expr:
    return Expr(sign, (number(1), times(a, a)))


_SLOPES: dict[str, Callable[[Expr, Expr], Expr]] = {
    "sqrt": lambda e, a: over(number(Fraction(1, 2)), e),
    "exp": lambda e, a: e,
    "log": lambda e, a: over(number(1), a),
    "sin": lambda e, a: Expr("cos", (a,)),
    "cos": lambda e, a: Expr("neg", (Expr("sin", (a,)),)),
    "tan": lambda e, a: Expr("+", (number(1), times(e, e))),
    "sinh": lambda e, a: Expr("cosh", (a,)),
    "cosh": lambda e, a: Expr("sinh", (a,)),
    "tanh": lambda e, a: _one_and_square("-", e),
    "atan": lambda e, a: over(number(1), _one_and_square("+", a)),
    "asin": lambda e, a: over(number(1), Expr("sqrt", (_one_and_square("-", a),))),
    "acos": lambda e, a: over(number(-1), Expr("sqrt", (_one_and_square("-", a),))),
}
