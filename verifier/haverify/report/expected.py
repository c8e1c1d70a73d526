"""The margin that an `expect` line states, compared exactly with the margin that was found."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from haverify.evidence.verdict import Margin, Unknown, Verdict
from haverify.model.claim import Claim
from haverify.model.expression import Expr
from haverify.model.unit import Unit, conversion, parse_unit
from haverify.report.numbers import decimal

Interval = tuple[Fraction, Fraction]

_PI: Interval = (Fraction("3.14159265358979323846264338327950288"), Fraction("3.14159265358979323846264338327950289"))


def margin_problem(claim: Claim, verdict: Verdict) -> str | None:
    """What is wrong with the margin of a decided claim; None when it is as stated, or nothing is stated."""
    if claim.expect is None or claim.expect.margin is None or isinstance(verdict, Unknown):
        return None
    op, expr = claim.expect.margin
    if verdict.margin is None:
        return "a margin is expected, but none is known for this claim"
    bound = _in_unit(expr, verdict.margin.unit)
    if bound is None:
        return f"the expected margin cannot be compared with a margin in {verdict.margin.unit or 'a plain number'}"
    answer = _compare(op, verdict.margin, bound)
    found = f"{decimal((verdict.margin.low + verdict.margin.high) / 2)} {verdict.margin.unit}".strip()
    stated = f"{op} {decimal(bound[0])} {verdict.margin.unit}".strip()
    if answer is None:
        return f"whether the margin, about {found}, is {stated} is too close to tell"
    return None if answer else f"expected margin {stated}, got {found}"


_TESTS: dict[str, Callable[[Fraction, Fraction], bool]] = {
    "<": lambda a, b: a < b,
    "<=": lambda a, b: a <= b,
    ">": lambda a, b: a > b,
    ">=": lambda a, b: a >= b,
}


def _compare(op: str, margin: Margin, bound: Interval) -> bool | None:
    """Whether every margin of the enclosure compares with every bound; None when some do and some do not."""
    test = _TESTS.get(op)
    if test is None:  # == and !=: only exact values can tell
        if margin.low == margin.high and bound[0] == bound[1]:
            return (margin.low == bound[0]) is (op == "==")
        return (op == "!=") if margin.high < bound[0] or bound[1] < margin.low else None
    answers = {test(m, b) for m in (margin.low, margin.high) for b in bound}
    return answers.pop() if len(answers) == 1 else None


def _in_unit(expr: Expr, unit: str) -> Interval | None:
    value = evaluate(expr)
    if value is None or expr.unit is None or str(expr.unit) == unit:
        return value
    known = tuple(named for named, _ in expr.unit.factors)
    target = parse_unit(unit or "1", known)
    factor = conversion(expr.unit, target) if isinstance(target, Unit) else None
    return factor and _scaled(factor[0], factor[1], value)


def evaluate(e: Expr) -> Interval | None:
    """An enclosure of an expression in numbers and pi, the value itself where pi does not occur; None for any other."""
    if e.op == "num":
        return (Fraction(e.args[0]), Fraction(e.args[0]))  # type: ignore[arg-type]
    if e.op == "pi":
        return _PI
    inner = [evaluate(c) for c in e.children]
    if not inner or any(v is None for v in inner):
        return None
    values = [v for v in inner if v is not None]
    if e.op == "scale":
        return _scaled(Fraction(e.args[0]), int(e.args[1]), values[0])  # type: ignore[arg-type]
    return _arithmetic(e.op, values)


def _arithmetic(op: str, values: list[Interval]) -> Interval | None:
    if op == "neg":
        return (-values[0][1], -values[0][0])
    if op == "+":
        return (sum((v[0] for v in values), Fraction(0)), sum((v[1] for v in values), Fraction(0)))
    if op == "-":
        return (values[0][0] - values[1][1], values[0][1] - values[1][0])
    if op == "*":
        product = values[0]
        for v in values[1:]:
            product = _times(product, v)
        return product
    if op == "/" and (values[1][0] > 0 or values[1][1] < 0):
        return _times(values[0], (1 / values[1][1], 1 / values[1][0]))
    return None


def _times(a: Interval, b: Interval) -> Interval:
    products = [x * y for x in a for y in b]
    return (min(products), max(products))


def _scaled(q: Fraction, k: int, value: Interval) -> Interval:
    """`q * pi^k * value`."""
    power = (_PI[0] ** k, _PI[1] ** k) if k >= 0 else (_PI[1] ** k, _PI[0] ** k)
    return _times((q, q), _times(power, value))
