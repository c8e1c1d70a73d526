"""Builders of expressions in canonical form: exact numbers folded, sums and products and truth values flat.

Two texts that differ in grouping only give the same expression, and the text that `expand` prints of an expression
gives that expression again. A sum of three or more terms is one `+`, subtracted terms negated; a chain of `*` and `/`
is one product, or one quotient of products.
"""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction

from haverify.maths.exact import MAX_BITS, fits
from haverify.model.expression import FALSE, TRUE, Expr, number
from haverify.model.unit import Unit
from haverify.text.span import Span


class TooLarge(Exception):
    """An exact number is longer than numbers may be."""


class DividedByZero(Exception):
    """A quotient of exact numbers has no value."""


def literal(e: Expr) -> Fraction | None:
    """The value of a number node."""
    if e.op != "num":
        return None
    value = e.args[0]
    assert isinstance(value, Fraction)
    return value


def _bounded(q: Fraction) -> Fraction:
    if not fits(q):
        raise TooLarge
    return q


def scale(q: Fraction, k: int, e: Expr, unit: Unit | None) -> Expr:
    """`q pi^k e`, measured in `unit`."""
    if e.op == "scale":
        inner, power, operand = e.args
        assert isinstance(inner, Fraction) and isinstance(power, Fraction) and isinstance(operand, Expr)
        return scale(q * inner, k + int(power), operand, unit)
    if q == 1 and k == 0:
        return e if e.unit == unit else Expr(e.op, e.args, unit, e.span)
    value = literal(e)
    if value is not None and k == 0:
        return number(_bounded(value * q), unit, e.span)
    return Expr("scale", (q, Fraction(k), e), unit, e.span)


def negate(e: Expr, span: Span | None = None) -> Expr:
    """`-e`."""
    value = literal(e)
    if value is not None:
        return number(-value, e.unit, span or e.span)
    return Expr("neg", (e,), e.unit, span or e.span)


def total(terms: list[tuple[str, Expr]], unit: Unit | None, span: Span | None) -> Expr:
    """The sum of `+` and `-` terms, all in `unit`."""
    if len(terms) == 2 and terms[1][0] == "-" and terms[0][1].op != "+":
        return _difference(terms[0][1], terms[1][1], unit, span)
    flat: list[Expr] = []
    for op, e in terms:
        if op == "-":
            flat.append(negate(e))
        else:
            flat.extend(_parts("+", e))
    return _folded("+", flat, unit, span)


def _difference(a: Expr, b: Expr, unit: Unit | None, span: Span | None) -> Expr:
    x, y = literal(a), literal(b)
    if x is not None and y is not None:
        return number(_bounded(x - y), unit, span)
    return Expr("-", (a, b), unit, span)


def _parts(op: str, e: Expr) -> list[Expr]:
    return [a for a in e.args if isinstance(a, Expr)] if e.op == op else [e]


def _folded(op: str, parts: list[Expr], unit: Unit | None, span: Span | None) -> Expr:
    """The parts under one `op`, leading numbers made one."""
    lead, k = literal(parts[0]), 1
    lead_unit = parts[0].unit
    while lead is not None and k < len(parts) and (nxt := literal(parts[k])) is not None:
        lead = _bounded(lead + nxt if op == "+" else lead * nxt)
        part_unit = parts[k].unit
        if op == "*" and lead_unit is not None and part_unit is not None:
            lead_unit = lead_unit * part_unit
        k += 1
    if lead is not None and k > 1:
        parts = [number(lead, lead_unit, span), *parts[k:]]
    if len(parts) == 1:
        only = parts[0]
        return only if only.unit == unit else Expr(only.op, only.args, unit, only.span)
    return Expr(op, tuple(parts), unit, span)


def product(factors: list[tuple[str, Expr]], unit: Unit | None, span: Span | None) -> Expr:
    """The product of `*` and `/` factors."""
    factors = _leading_number(factors)
    above: list[Expr] = []
    below: list[Expr] = []
    for op, e in factors:
        (below if op == "/" else above).extend(_parts("*", e))
    top = _folded("*", above, _product_unit(above), span)
    if not below:
        return top if top.unit == unit else Expr(top.op, top.args, unit, top.span)
    bottom = _folded("*", below, _product_unit(below), span)
    if literal(bottom) == 0:
        raise DividedByZero
    if literal(top) is not None and literal(bottom) is not None:
        return number(_quotient(top, bottom), unit, span)
    return Expr("/", (top, bottom), unit, span)


def _leading_number(factors: list[tuple[str, Expr]]) -> list[tuple[str, Expr]]:
    lead, k = factors[0][1], 1
    while k < len(factors) and literal(lead) is not None and literal(factors[k][1]) is not None:
        op, e = factors[k]
        if op == "/":
            unit = lead.unit / e.unit if lead.unit is not None and e.unit is not None else None
            lead = number(_quotient(lead, e), unit, lead.span)
        else:
            lead = _folded("*", [lead, e], _product_unit([lead, e]), lead.span)
        k += 1
    return [("*", lead), *factors[k:]]


def _quotient(a: Expr, b: Expr) -> Fraction:
    x, y = literal(a), literal(b)
    assert x is not None and y is not None
    if y == 0:
        raise DividedByZero
    return _bounded(x / y)


def _product_unit(parts: list[Expr]) -> Unit | None:
    unit = parts[0].unit
    for p in parts[1:]:
        unit = unit * p.unit if unit is not None and p.unit is not None else None
    return unit


def raised(base: Expr, exponent: Expr, unit: Unit | None, span: Span | None) -> Expr:
    """`base ^ exponent`."""
    b, n = literal(base), literal(exponent)
    if b is None or n is None or n.denominator != 1:
        return Expr("^", (base, exponent), unit, span)
    if b == 0 and n < 0:
        raise DividedByZero
    if b not in (0, 1, -1) and _length(b) * abs(n) > MAX_BITS + _length(b):
        raise TooLarge
    if b in (0, 1, -1):
        n = Fraction(2 + n % 2) if n > 3 else n
    return number(_bounded(b ** int(n)), unit, span)


def _length(q: Fraction) -> int:
    """A lower bound of the growth in bits per multiplication, at least 1 for |q| not 0 or 1."""
    return max(1, max(q.numerator.bit_length(), q.denominator.bit_length()) - 1)


_COMPARE = {
    "<": lambda a, b: a < b, "<=": lambda a, b: a <= b, ">": lambda a, b: a > b,
    ">=": lambda a, b: a >= b, "==": lambda a, b: a == b, "!=": lambda a, b: a != b,
}  # fmt: skip


def truth(value: bool, span: Span | None = None) -> Expr:
    """`true` or `false`."""
    return Expr("true" if value else "false", (), None, span)


def compare(op: str, a: Expr, b: Expr, span: Span | None) -> Expr:
    """`a op b` for sides in one unit."""
    x, y = literal(a), literal(b)
    if x is not None and y is not None:
        return truth(_COMPARE[op](x, y), span)
    if (a.op == "sym" and b.op == "sym") or (a.op in _TRUTHS and b.op in _TRUTHS):
        return truth((a == b) == (op == "=="), span)
    return Expr(op, (a, b), None, span)


_TRUTHS = ("true", "false")


def every(parts: Iterable[Expr], span: Span | None) -> Expr:
    """The conjunction."""
    return _connective("and", parts, TRUE, FALSE, span)


def some(parts: Iterable[Expr], span: Span | None) -> Expr:
    """The disjunction."""
    return _connective("or", parts, FALSE, TRUE, span)


def _connective(op: str, parts: Iterable[Expr], neutral: Expr, absorbing: Expr, span: Span | None) -> Expr:
    flat: list[Expr] = []
    for p in parts:
        if p.op == absorbing.op:
            return truth(absorbing.op == "true", span)
        if p.op != neutral.op:
            flat.extend(_parts(op, p))
    if len(flat) < 2:
        return flat[0] if flat else truth(neutral.op == "true", span)
    return Expr(op, tuple(flat), None, span)


def negation(e: Expr, span: Span | None) -> Expr:
    """`not e`."""
    if e.op in _TRUTHS:
        return truth(e.op == "false", span)
    return Expr("not", (e,), None, span)


def implication(a: Expr, b: Expr, span: Span | None) -> Expr:
    """`a implies b`."""
    if a.op == "false" or b.op == "true":
        return truth(True, span)
    if a.op == "true":
        return b
    if b.op == "false":
        return negation(a, span)
    return Expr("implies", (a, b), None, span)


def choice(condition: Expr, yes: Expr, no: Expr, span: Span | None) -> Expr:
    """`if condition then yes else no`; both in one unit."""
    if condition.op in _TRUTHS:
        return yes if condition.op == "true" else no
    return Expr("if", (condition, yes, no), yes.unit, span)
