"""From expressions to polynomials and formulas: piecewise functions by cases, lets and constants unfolded.

A value is a list of cases `(condition, numerator, denominator)`; the value is that of every case whose condition holds.
A comparison of values is the conjunction, over the cases, of `not condition or literal`; a division adds
`divisor != 0`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from functools import reduce
from itertools import product
from operator import mul

from haverify.maths.bernstein import Box, bounds
from haverify.maths.polynomial import ONE, Polynomial, constant, total, variable
from haverify.model.expression import Expr
from haverify.obligations.formula import Formula, compare, conjunction, disjunction, literal, negation, transform
from haverify.text.record import field, holder, record

UNIT = constant(1)
COMPARISONS = frozenset({"<", "<=", ">", ">=", "==", "!="})
TRUTH = COMPARISONS | {"true", "false", "and", "or", "not", "implies", "at", "jump", "jumped", "stuck"}
MOST_CASES = 64
MOST_TERMS = 4000
HIGHEST_POWER = 64


class OutsideFragmentError(Exception):
    """An expression is no piecewise polynomial of what a clock-driven analysis knows; the message says
    which and why."""


@record
class Case:
    """`numerator / denominator` where `condition` holds."""

    condition: Formula
    numerator: Polynomial
    denominator: Polynomial = UNIT


@record
class Landing:
    """A jump: what held before it, the mode it leads to, and the values it assigns, as polynomials in those before."""

    before: Scope
    after: Scope
    assigned: Mapping[str, Polynomial]

    def carried(self, cases: list[Case]) -> list[Case]:
        """Cases in variables after the jump, in those before it."""
        return [
            Case(
                transform(c.condition, self._change),
                self._change(c.numerator),
                UNIT if c.denominator is UNIT else self._change(c.denominator),
            )
            for c in cases
        ]

    def carried_truth(self, f: Formula) -> Formula:
        """A formula in variables after the jump, in those before it."""
        return transform(f, self._change)

    def _change(self, p: Polynomial) -> Polynomial:
        return p.substitute(self.assigned)


@holder
class Scope:
    """What names mean in one mode: polynomials in variables, params, symbolic constants, `pi` and `sigma`.

    `rates` is the flow by variable; `time` what `time` stands for, as numerator and denominator (None: not tracked).
    `let_cases` and `let_truths` cache unfolded lets.
    """

    where: str
    variables: Mapping[str, Polynomial]
    lets: Mapping[str, tuple[str, Expr]]  # type and definition
    constants: Callable[[str], list[Case] | Formula]
    symbols: Callable[[str, str], Fraction]
    truths: frozenset[str]  # the variables of type bool
    rates: Mapping[str, Polynomial | None]
    time: tuple[Polynomial, Polynomial] | None = None
    box: Box = field(default_factory=dict)  # of the params, where divisors are looked at
    landing: Landing | None = None
    function: Callable[[str, Polynomial], Polynomial] | None = None  # what `sin` and others of a polynomial are
    let_cases: dict[str, list[Case]] = field(default_factory=dict)
    let_truths: dict[str, Formula] = field(default_factory=dict)

    def cases(self, e: Expr) -> list[Case]:
        """The value of a numerical (or enumeration) expression."""
        handler = _VALUES.get(e.op)
        if handler is None:
            raise OutsideFragmentError(f"{self.where} reads {described(e)}")
        return handler(self, e)

    def polynomial(self, e: Expr) -> Polynomial:
        """The value of an expression that is one polynomial without cases."""
        cases = self.cases(e)
        if len(cases) == 1 and cases[0].condition is True and (d := cases[0].denominator.constant) is not None:
            return cases[0].numerator.scaled(1 / d)
        raise OutsideFragmentError(f"{self.where} reads `{e.op}` where a polynomial is needed")

    def formula(self, e: Expr) -> Formula:
        """The truth of a boolean expression."""
        if e.op in COMPARISONS:
            return self._comparison(e)
        handler = _TRUTHS.get(e.op)
        if handler is None:
            raise OutsideFragmentError(f"{self.where} reads {described(e)}")
        return handler(self, e)

    def is_truth(self, e: Expr) -> bool:
        """Whether the expression is a truth value."""
        if e.op == "let":
            return self.lets[e.name][0] == "bool" if e.name in self.lets else False
        if e.op == "var":
            return e.name in self.truths
        if e.op in ("if", "pre"):
            return self.is_truth(e.children[-1])
        if e.op == "const":
            return not isinstance(self.constants(e.name), list)
        return e.op in TRUTH

    def let(self, name: str) -> list[Case]:
        """The value of a let."""
        if self.landing is not None:
            return self.landing.carried(self.landing.after.let(name))
        if name not in self.let_cases:
            self.let_cases[name] = self.cases(self._definition(name))
        return self.let_cases[name]

    def let_truth(self, name: str) -> Formula:
        """The truth of a let of type bool."""
        if self.landing is not None:
            return self.landing.carried_truth(self.landing.after.let_truth(name))
        if name not in self.let_truths:
            self.let_truths[name] = self.formula(self._definition(name))
        return self.let_truths[name]

    def _definition(self, name: str) -> Expr:
        if name not in self.lets:
            raise OutsideFragmentError(f"{self.where} has no output `{name}`")
        return self.lets[name][1]

    def _comparison(self, e: Expr) -> Formula:
        a, b = e.children
        if e.op in ("==", "!=") and (self.is_truth(a) or self.is_truth(b)):
            p, q = self.formula(a), self.formula(b)
            same = conjunction([disjunction([negation(p), q]), disjunction([p, negation(q)])])
            return same if e.op == "==" else negation(same)
        pairs = _bounded(product(self.cases(a), self.cases(b)), self.where)
        return conjunction(_compare_case(e.op, x, y, self.box) for x, y in pairs)


def described(e: Expr) -> str:
    """The construct that is missing, in words."""
    words = {"input": f"the input `{e.args[0] if e.args else ''}`", "time": "`time`", "stuck": "`stuck`"}
    return words.get(e.op, f"`{e.op}(...)`")


def _compare_case(op: str, x: Case, y: Case, box: Box | None = None) -> Formula:
    if x.denominator is UNIT and y.denominator is UNIT:
        held = compare(op, x.numerator - y.numerator)
        if x.condition is True and y.condition is True:
            return held
    else:
        difference = x.numerator * y.denominator - y.numerator * x.denominator
        held = _quotient(op, difference, x.denominator * y.denominator, box or {})
    return disjunction([negation(x.condition), negation(y.condition), held])


def _quotient(op: str, p: Polynomial, divisor: Polynomial, box: Box) -> Formula:
    """`p / divisor op 0`, the divisor not being zero."""
    if all(v in box for v in divisor.variables):
        low, high = bounds(divisor, box)
        if low > 0 or high < 0:
            return compare(op, p if low > 0 else -p)
    return conjunction([compare(op, p * divisor), literal("!=", divisor)])


def _bounded(pairs: product[tuple[Case, Case]], where: str) -> list[tuple[Case, Case]]:
    found = list(pairs)
    if len(found) > MOST_CASES:
        raise OutsideFragmentError(f"{where} splits into more than {MOST_CASES} cases")
    return found


def _combine(
    scope: Scope, a: list[Case], b: list[Case], make: Callable[[Case, Case], tuple[Polynomial, Polynomial]]
) -> list[Case]:
    result = []
    for x, y in _bounded(product(a, b), scope.where):
        condition = conjunction([x.condition, y.condition])
        if condition is not False:
            numerator, denominator = make(x, y)
            if len(numerator.whole) > MOST_TERMS:
                raise OutsideFragmentError(f"{scope.where} has a polynomial of more than {MOST_TERMS} terms")
            result.append(Case(condition, numerator, denominator))
    return result


def _plus(x: Case, y: Case) -> tuple[Polynomial, Polynomial]:
    if x.denominator == y.denominator:
        return x.numerator + y.numerator, x.denominator
    return x.numerator * y.denominator + y.numerator * x.denominator, x.denominator * y.denominator


def _times(x: Case, y: Case) -> tuple[Polynomial, Polynomial]:
    return x.numerator * y.numerator, UNIT if x.denominator is UNIT is y.denominator else x.denominator * y.denominator


def _sum(scope: Scope, e: Expr) -> list[Case]:
    parts = [scope.cases(c) for c in e.children]
    if all(len(p) == 1 and p[0].condition is True and p[0].denominator is UNIT for p in parts):
        return [Case(True, total(p[0].numerator for p in parts))]
    result = parts[0]
    for p in parts[1:]:
        result = _combine(scope, result, p, _plus)
    return result


def _product(scope: Scope, e: Expr) -> list[Case]:
    parts = [scope.cases(c) for c in e.children]
    if all(len(p) == 1 and p[0].condition is True and p[0].denominator is UNIT for p in parts):
        whole = reduce(mul, [p[0].numerator for p in parts])
        if len(whole.whole) <= MOST_TERMS:
            return [Case(True, whole)]
    result, *rest = parts
    for p in rest:
        result = _combine(scope, result, p, _times)
    return result


def _negative(case: Case) -> Case:
    return Case(case.condition, -case.numerator, case.denominator)


def _difference(scope: Scope, e: Expr) -> list[Case]:
    a, b = e.children
    return _combine(scope, scope.cases(a), [_negative(c) for c in scope.cases(b)], _plus)


def _ratio(scope: Scope, e: Expr) -> list[Case]:
    a, b = e.children
    return _combine(scope, scope.cases(a), [_inverse(scope, c) for c in scope.cases(b)], _times)


def _inverse(scope: Scope, c: Case) -> Case:
    value = c.numerator.constant
    if value is None:
        return Case(c.condition, c.denominator, c.numerator)
    if value == 0:
        raise OutsideFragmentError(f"{scope.where} divides by zero")
    return Case(c.condition, c.denominator.scaled(1 / value))


def _power(scope: Scope, e: Expr) -> list[Case]:
    written = e.children[1]
    exponent = written.args[0] if written.op == "num" else scope.polynomial(written).constant
    if not isinstance(exponent, Fraction) or exponent.denominator != 1 or abs(exponent) > HIGHEST_POWER:
        raise OutsideFragmentError(f"{scope.where} reads a power whose exponent is no integer up to {HIGHEST_POWER}")
    base = scope.cases(e.children[0])
    if exponent < 0:
        base = [_inverse(scope, c) for c in base]
    n = abs(int(exponent))
    if any(len(c.numerator.whole) > 1 and len(c.numerator.whole) ** min(n, 8) > 10**6 for c in base):
        raise OutsideFragmentError(f"{scope.where} has a polynomial of more than {MOST_TERMS} terms")
    return [Case(c.condition, c.numerator**n, UNIT if c.denominator is UNIT else c.denominator**n) for c in base]


def _scale(scope: Scope, e: Expr) -> list[Case]:
    q, k = e.args[0], e.args[1]
    assert isinstance(q, Fraction) and isinstance(k, (Fraction, int, str)), "scale has a rational and an integer"
    factor, power = constant(q), int(Fraction(k))
    cases = [Case(c.condition, c.numerator * factor, c.denominator) for c in scope.cases(e.children[0])]
    if power == 0:
        return cases
    circle = variable("pi") ** abs(power)
    if power > 0:
        return [Case(c.condition, c.numerator * circle, c.denominator) for c in cases]
    return [Case(c.condition, c.numerator, c.denominator * circle) for c in cases]


def _absolute(scope: Scope, e: Expr) -> list[Case]:
    zero = Case(True, constant(0))
    result = []
    for c in scope.cases(e.children[0]):
        below = _compare_case("<", Case(True, c.numerator, c.denominator), zero)
        result.append(Case(conjunction([c.condition, negation(below)]), c.numerator, c.denominator))
        result.append(Case(conjunction([c.condition, below]), -c.numerator, c.denominator))
    return [c for c in result if c.condition is not False]


def _extreme(scope: Scope, e: Expr) -> list[Case]:
    """`min` and `max`, two at a time."""
    op = "<=" if e.op == "min" else ">="
    result, *rest = [scope.cases(c) for c in e.children]
    for other in rest:
        merged = []
        for x, y in _bounded(product(result, other), scope.where):
            first = _compare_case(op, Case(True, x.numerator, x.denominator), Case(True, y.numerator, y.denominator))
            both = [x.condition, y.condition]
            merged.append(Case(conjunction([*both, first]), x.numerator, x.denominator))
            merged.append(Case(conjunction([*both, negation(first)]), y.numerator, y.denominator))
        result = [c for c in merged if c.condition is not False]
    return result


def _clamp(scope: Scope, e: Expr) -> list[Case]:
    value, low, high = e.children
    return _extreme(scope, Expr("min", (Expr("max", (value, low)), high)))


def _choice(scope: Scope, e: Expr) -> list[Case]:
    condition, yes, no = e.children
    holds = scope.formula(condition)
    result = []
    for guard, branch in ((holds, yes), (negation(holds), no)):
        if guard is not False:
            result += [Case(conjunction([guard, c.condition]), c.numerator, c.denominator) for c in scope.cases(branch)]
    return result


def _variable(scope: Scope, e: Expr) -> list[Case]:
    if e.name not in scope.variables:
        raise OutsideFragmentError(f"{scope.where} reads `{e.name}`")
    return [Case(True, scope.variables[e.name])]


def _constant(scope: Scope, e: Expr) -> list[Case]:
    value = scope.constants(e.name)
    if not isinstance(value, list):
        raise OutsideFragmentError(f"{scope.where} reads the truth value `{e.name}` as a number")
    return value


def _time(scope: Scope, _: Expr) -> list[Case]:
    if scope.time is None:
        raise OutsideFragmentError(f"{scope.where} reads `time`, but the modes do not share one rate")
    return [Case(True, *scope.time)]


def _derivative(scope: Scope, e: Expr) -> list[Case]:
    if scope.landing is not None:
        return scope.landing.carried(scope.landing.after.cases(e))
    cases = scope.cases(e.children[0])
    if len(cases) != 1 or cases[0].condition is not True or cases[0].denominator.constant is None:
        raise OutsideFragmentError(f"{scope.where} reads the derivative of something that is no polynomial")
    p = cases[0].numerator.scaled(1 / (cases[0].denominator.constant or ONE))
    if "@sigma" in p.variables:
        raise OutsideFragmentError(f"{scope.where} reads the derivative of `time`")
    summands = []
    for v in p.variables:
        rate = scope.rates.get(v, constant(0))
        if rate is None:
            raise OutsideFragmentError(
                f"{scope.where} reads the derivative of `{v}`, whose flow is no polynomial of params"
            )
        summands.append(p.derivative(v) * rate)
    return [Case(True, total(summands))]


def _before(scope: Scope, e: Expr) -> Scope:
    if scope.landing is None:
        raise OutsideFragmentError(f"{scope.where} reads {described(e)}")
    return scope.landing.before


def _function(scope: Scope, e: Expr) -> list[Case]:
    if scope.function is None:
        raise OutsideFragmentError(f"{scope.where} reads {described(e)}")
    return [Case(True, scope.function(e.op, scope.polynomial(e.children[0])))]


def _symbol(scope: Scope, e: Expr) -> list[Case]:
    return [Case(True, constant(scope.symbols(str(e.args[0]), str(e.args[1]))))]


def _number(_: Scope, e: Expr) -> list[Case]:
    value = e.args[0]
    assert isinstance(value, Fraction), "a number node holds a rational"
    return [Case(True, constant(value))]


_VALUES: dict[str, Callable[[Scope, Expr], list[Case]]] = {
    "num": _number,
    "pi": lambda _s, _e: [Case(True, variable("pi"))],
    "time": _time,
    "const": _constant,
    "param": _variable,
    "input": _variable,
    "var": _variable,
    "let": lambda s, e: s.let(e.name),
    "sym": _symbol,
    "scale": _scale,
    "+": _sum,
    "-": _difference,
    "neg": lambda s, e: [_negative(c) for c in s.cases(e.children[0])],
    "*": _product,
    "/": _ratio,
    "^": _power,
    "abs": _absolute,
    "min": _extreme,
    "max": _extreme,
    "clamp": _clamp,
    "if": _choice,
    "der": _derivative,
    "sin": _function,
    "cos": _function,
    "exp": _function,
    "log": _function,
    "sqrt": _function,
    "pre": lambda s, e: _before(s, e).cases(e.children[0]),
}


def _truth_constant(scope: Scope, e: Expr) -> Formula:
    value = scope.constants(e.name)
    if isinstance(value, list):
        raise OutsideFragmentError(f"{scope.where} reads the number `{e.name}` as a truth value")
    return value


def _truth_choice(scope: Scope, e: Expr) -> Formula:
    condition, yes, no = (scope.formula(c) for c in e.children)
    return conjunction([disjunction([negation(condition), yes]), disjunction([condition, no])])


_TRUTHS: dict[str, Callable[[Scope, Expr], Formula]] = {
    "true": lambda _s, _e: True,
    "false": lambda _s, _e: False,
    "and": lambda s, e: conjunction(s.formula(c) for c in e.children),
    "or": lambda s, e: disjunction(s.formula(c) for c in e.children),
    "not": lambda s, e: negation(s.formula(e.children[0])),
    "implies": lambda s, e: disjunction([negation(s.formula(e.children[0])), s.formula(e.children[1])]),
    "if": _truth_choice,
    "var": lambda s, e: literal("==", s.polynomial(e) - constant(1)),
    "let": lambda s, e: s.let_truth(e.name),
    "const": _truth_constant,
    "pre": lambda s, e: _before(s, e).formula(e.children[0]),
}
