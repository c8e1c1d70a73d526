"""Expressions as operations in floats: one list for each mode, equal subexpressions once."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction

from haverify.model.expression import Expr, number, operands
from haverify.obligations.translate import OutsideFragmentError
from haverify.simulate.derivative import APPLIED, derivative
from haverify.solvers.runs import Operation, Words
from haverify.text.record import field, holder

COMPARISONS = {"<", "<=", ">", ">=", "==", "!="}
NEGATED = {"<": ">=", "<=": ">", ">": "<=", ">=": "<", "==": "!=", "!=": "=="}
CLOSED = {"<": "<=", ">": ">="}
TRUTHS = {"and", "or", "not", "implies", "true", "false", *COMPARISONS}

_PLAIN = {"+": "add", "-": "sub", "*": "mul", "/": "div"}
_PAIRS = {"sin": ("sin", "cos"), "sinh": ("sinh", "cosh"), "tanh": ("tanh", "sech2")}
_PARTNERS = {"cos": "sin", "cosh": "sinh"}
_HIGHEST_POWER = 64
_BRIEF = {"num", "var", "param", "input", "time", "sym", "let", "const", *APPLIED}  # hashed in no time


@holder
class Code:
    """Operations of one mode. `variables` numbers the state, `definitions` say what lets and constants stand for.

    `symbols` are the numbers of enumerations' values, `truths` the variables of type bool, `rates` the slopes by which
    `der` is written out, `applied` says what applications of fuzzy systems and tables stand for.
    """

    variables: Mapping[str, int]
    definitions: Mapping[tuple[str, str], Expr]
    symbols: Mapping[tuple[str, str], Fraction]
    truths: frozenset[str]
    rates: Mapping[str, Expr]
    applied: Callable[[Expr], Expr]
    operations: list[Operation] = field(default_factory=list)
    conditions: list[Words] = field(default_factory=list)
    _known: dict[object, int] = field(default_factory=dict)
    _kept: list[Expr] = field(default_factory=list)  # known by their id, which no other may have

    def value(self, e: Expr) -> int:
        """The register of a number; a truth value counts as 0 or 1.

        Raises
        ------
        OutsideFragmentError    if the simulator has no operation for it
        """
        key = e if e.op in _BRIEF else id(e)
        if key not in self._known:
            if self.is_truth(e):
                self._known[key] = self._chosen(self.words(e), number(1), number(0))
            else:
                self._known[key] = self._value(e)
            self._kept.append(e)
        return self._known[key]

    def _value(self, e: Expr) -> int:
        if e.op == "num":
            return self.constant(_float(Fraction(str(e.args[0]))))
        if e.op == "pi":
            return self.constant(math.pi)
        if e.op in ("var", "param", "input", "time"):
            return self.variable("time" if e.op == "time" else e.name)
        if e.op in ("let", "const", *APPLIED):
            return self.value(self._definition(e))
        if e.op == "sym":
            return self.constant(float(self.symbols[str(e.args[0]), str(e.args[1])]))
        if e.op == "scale":
            q, k, inner = e.args
            assert isinstance(inner, Expr)
            factor = _float(Fraction(str(q))) * math.pi ** int(Fraction(str(k)))
            return self.push("mul", [self.constant(factor), self.value(inner)])
        if e.op == "der":
            return self.value(derivative(e.children[0], self.rates, self._definition))
        if e.op == "if":
            condition, yes, no = operands(e)
            return self._chosen(self.words(condition), yes, no)
        return self._function(e)

    def _function(self, e: Expr) -> int:
        if e.op == "^":
            return self._power(*e.children)
        if e.op in _PLAIN:
            first, *rest = [self.value(c) for c in e.children]
            for other in rest:
                first = self.push(_PLAIN[e.op], [first, other])
            return first
        if e.op in ("min", "max"):
            first, *rest = [self.value(c) for c in e.children]
            for other in rest:
                first = self.push(e.op, [first, other, self.push("sub", [first, other])])
            return first
        if e.op == "clamp":
            inner, low, high = e.children
            return self.value(Expr("min", (Expr("max", (inner, low)), high)))
        a = [self.value(c) for c in e.children]
        if e.op in ("neg", "sqrt", "exp", "log", "abs"):
            return self.push(e.op, a)
        if e.op in _PAIRS or e.op in _PARTNERS:
            return self._paired(e.op, a)
        if e.op == "tan":
            sine = self._paired("sin", a)
            return self.push("div", [sine, sine + 1])
        return self._inverse(e.op, a)

    def _paired(self, name: str, a: list[int]) -> int:
        """A function whose series needs a second one, which follows it."""
        first = _PARTNERS.get(name, name)
        at = self.push(first, a)
        if self.operations[at + 1 :][:1] != [(_PAIRS[first][1], a, 0.0)]:
            self.push(_PAIRS[first][1], a)
        return at if first == name else at + 1

    def _inverse(self, name: str, a: list[int]) -> int:
        """Inverse functions with their derivatives."""
        one = self.constant(1.0)
        if name in ("atan", "asin", "acos"):
            square = self.push("mul", [a[0], a[0]])
            if name == "atan":
                slope = self.push("div", [one, self.push("add", [one, square])])
            else:
                root = self.push("sqrt", [self.push("sub", [one, square])])
                slope = self.push("div", [one if name == "asin" else self.constant(-1.0), root])
            return self.push(name, [a[0], slope])
        if name == "atan2":
            y, x = a
            square = self.push("add", [self.push("mul", [x, x]), self.push("mul", [y, y])])
            return self.push("turn", [y, x, self.push("div", [x, square]), self.push("div", [y, square])])
        raise OutsideFragmentError(f"the simulator has no `{name}`")

    def _power(self, base: Expr, exponent: Expr) -> int:
        if exponent.op != "num":
            logarithm = Expr("log", (base,))
            return self.value(Expr("exp", (Expr("*", (exponent, logarithm)),)))
        n = Fraction(str(exponent.args[0]))
        if n.denominator != 1 or abs(n) > _HIGHEST_POWER:
            return self.push("power", [self.value(base)], _float(n))
        if n == 0:
            return self.constant(1.0)
        result = self._repeated(self.value(base), abs(int(n)))
        return result if n > 0 else self.push("div", [self.constant(1.0), result])

    def _repeated(self, base: int, n: int) -> int:
        if n == 1:
            return base
        half = self._repeated(base, n // 2)
        square = self.push("mul", [half, half])
        return square if n % 2 == 0 else self.push("mul", [square, base])

    def _chosen(self, words: Words, yes: Expr, no: Expr) -> int:
        if words in ([("true", 0)], [("false", 0)]):
            return self.value(yes if words[0][0] == "true" else no)
        a, b = self.value(yes), self.value(no)
        if words not in self.conditions:
            self.conditions.append(words)
        return self.push("choose", [self.conditions.index(words), a, b])

    def _definition(self, e: Expr) -> Expr:
        if e.op in APPLIED:
            return self.applied(e)
        found = self.definitions.get((e.op, e.name))
        if found is None:
            raise OutsideFragmentError(f"`{e.name}` is no single value")
        return found

    def constant(self, x: float) -> int:
        """The register of a number."""
        return self.push("constant", [], x)

    def variable(self, name: str) -> int:
        """The register of a variable of the state."""
        if name not in self.variables:
            raise OutsideFragmentError(f"`{name}` is no part of the state")
        return self.push("variable", [self.variables[name]])

    def push(self, name: str, operands: Sequence[int], x: float = 0.0) -> int:
        """The register of an operation, made where it is new."""
        key = (name, tuple(operands), x)
        if key not in self._known:
            self._known[key] = len(self.operations)
            self.operations.append((name, list(operands), x))
        return self._known[key]

    # ---- truth values ----

    def is_truth(self, e: Expr) -> bool:
        """Whether an expression is a truth value."""
        if e.op == "var":
            return e.name in self.truths
        if e.op in ("let", "const"):
            return self.is_truth(self._definition(e))
        if e.op in ("if", "pre"):
            return self.is_truth(operands(e)[-1])
        return e.op in TRUTHS

    def words(self, e: Expr, is_denied: bool = False, closed: bool = False) -> Words:
        """A condition over registers, the operator before its members; `closed`: as a domain is read (LANGUAGE S6)."""
        if e.op in ("true", "false"):
            return [("true" if (e.op == "true") is not is_denied else "false", 0)]
        if e.op == "not":
            return self.words(e.children[0], not is_denied, closed)
        if e.op in ("let", "const"):
            return self.words(self._definition(e), is_denied, closed)
        if e.op == "var":
            return [("<=" if is_denied else ">", self.variable(e.name))]
        if e.op == "implies":
            premise, conclusion = e.children
            both = [self.words(premise, not is_denied, closed), self.words(conclusion, is_denied, closed)]
            return joined("all" if is_denied else "any", both)
        if e.op in ("and", "or"):
            members = [self.words(c, is_denied, closed) for c in e.children]
            return joined("all" if (e.op == "and") is not is_denied else "any", members)
        if e.op == "if":
            condition, yes, no = operands(e)
            first = joined("all", [self.words(condition), self.words(yes, is_denied, closed)])
            return joined(
                "any", [first, joined("all", [self.words(condition, True), self.words(no, is_denied, closed)])]
            )
        if e.op in COMPARISONS:
            return self._compared(e, is_denied, closed)
        raise OutsideFragmentError(f"the simulator cannot evaluate `{e.op}`")

    def _compared(self, e: Expr, is_denied: bool, closed: bool) -> Words:
        op = NEGATED[e.op] if is_denied else e.op
        left, right = e.children
        if closed and op == "!=":
            return [("true", 0)]
        op = CLOSED.get(op, op) if closed else op
        if self.is_truth(left):
            same = joined("all", [self.words(left), self.words(right)])
            other = joined("all", [self.words(left, True), self.words(right, True)])
            mixed = [self.words(left), self.words(right, True)], [self.words(left, True), self.words(right)]
            return joined("any", [same, other] if op == "==" else [joined("all", m) for m in mixed])
        a, b = self.value(left), self.value(right)
        return [(op, a if self.operations[b] == ("constant", [], 0.0) else self.push("sub", [a, b]))]


def joined(word: str, members: Sequence[Words]) -> Words:
    """`all` or `any` of some conditions, truth constants folded."""
    decisive = "false" if word == "all" else "true"
    kept = [m for m in members if m[0][0] not in ("true", "false")]
    if any(m[0][0] == decisive for m in members):
        return [(decisive, 0)]
    if not kept:
        return [("true" if word == "all" else "false", 0)]
    return kept[0] if len(kept) == 1 else [(word, len(kept)), *(w for m in kept for w in m)]


def holds(words: Words, values: Sequence[float]) -> bool:
    """The truth of a condition from the values of all registers."""
    return _holds(iter(words), values)


def _holds(words: Iterator[tuple[str, int]], values: Sequence[float]) -> bool:
    word, at = next(words)
    if word in ("true", "false"):
        return word == "true"
    if word in ("all", "any"):
        members = [_holds(words, values) for _ in range(at)]
        return all(members) if word == "all" else any(members)
    return _SIGNS[word](values[at])


_SIGNS: dict[str, Callable[[float], bool]] = {
    "<": lambda x: x < 0,
    "<=": lambda x: x <= 0,
    ">": lambda x: x > 0,
    ">=": lambda x: x >= 0,
    "==": lambda x: x == 0,
    "!=": lambda x: x != 0,
}


def _float(q: Fraction) -> float:
    try:
        return float(q)
    except OverflowError:
        return math.inf if q > 0 else -math.inf
