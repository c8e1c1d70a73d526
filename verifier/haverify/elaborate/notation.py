"""Core expressions as `.ha` text that elaborates to the same expressions."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import Any

from haverify.maths.exact import decimal_text
from haverify.model.expression import Expr
from haverify.model.unit import ONE, Unit, named

_LOWEST, _IMPLIES, _OR, _AND, _UNTIL, _NOT, _COMPARE, _SUM, _PRODUCT, _UNARY, _POWER, _ATOM = range(12)

Words = Mapping[tuple[str, str], str]
"""How enumeration values are written, by enumeration and value."""


class Notation:
    """The writer of expressions of one spec."""

    def __init__(self, words: Words) -> None:
        self.words = words

    def text(self, e: Expr, level: int = _LOWEST) -> str:
        """`e` as text, in parentheses where it binds less than `level`."""
        while e.op == "scale":
            operand = e.args[2]
            assert isinstance(operand, Expr)
            e = operand
        own, text = _WRITERS.get(e.op, _function)(self, e)
        return f"({text})" if own < level else text

    def joined(self, parts: tuple[Any, ...], op: str, level: int) -> str:
        """Operands of a flat connective."""
        return f" {op} ".join(self.text(p, level) for p in parts)


Written = tuple[int, str]


def quantity(value: Fraction, unit: Unit | None) -> Written:
    """A number with its unit."""
    decimal = decimal_text(abs(value)) if value.denominator.bit_length() < 400 else None
    sign, level = ("-", _UNARY) if value < 0 else ("", _ATOM)
    if unit is None or unit is ONE:
        if decimal is not None:
            return level, sign + decimal
        return _ATOM, f"({value.numerator} / {value.denominator})"
    if value == 0 and any(e != int(e) for _, e in unit.factors):
        return _ATOM, "0"
    if not unit.is_writable:
        return _ATOM, f"({_product(value, unit)})"
    if decimal is not None:
        return level, f"{sign}{decimal} {unit.text}"
    return _ATOM, f"({value.numerator} {unit.text} / {value.denominator})"


def _product(value: Fraction, unit: Unit) -> str:
    """A number in a unit that is no single word of the language."""
    text, rest = str(value.numerator), ONE
    for factor, e in unit.factors:
        if factor.is_builtin and factor.name != "%":
            rest = rest * _powered(named(factor), int(e))
        else:
            text += f" {'*' if e > 0 else '/'} 1 {factor.name}" * abs(int(e))
    if rest is not ONE:
        text += f" * 1 {rest.text}"
    return text if value.denominator == 1 else f"{text} / {value.denominator}"


def _powered(unit: Unit, exponent: int) -> Unit:
    from haverify.model.unit import power

    return power(unit, exponent)


# ---- one writer per node --------------------------------------------------------


def _num(n: Notation, e: Expr) -> Written:
    value = e.args[0]
    assert isinstance(value, Fraction)
    return quantity(value, e.unit)


def _name(n: Notation, e: Expr) -> Written:
    return _ATOM, e.name


def _second_name(n: Notation, e: Expr) -> Written:
    return _ATOM, str(e.args[1])


def _word(n: Notation, e: Expr) -> Written:
    return _ATOM, e.op


def _sym(n: Notation, e: Expr) -> Written:
    return _ATOM, n.words[str(e.args[0]), str(e.args[1])]


def _sum(n: Notation, e: Expr) -> Written:
    terms = [a for a in e.args if isinstance(a, Expr)]
    text = n.text(terms[0], _PRODUCT)
    for term in terms[1:]:
        sign, operand = _signed(term) if len(terms) > 2 else ("+", term)
        text += f" {sign} {n.text(operand, _PRODUCT)}"
    return _SUM, text


def _signed(term: Expr) -> tuple[str, Expr]:
    if term.op == "neg":
        operand = term.args[0]
        assert isinstance(operand, Expr)
        return "-", operand
    value = term.args[0] if term.op == "num" else None
    if isinstance(value, Fraction) and value < 0:
        return "-", Expr("num", (-value,), term.unit)
    return "+", term


def _difference(n: Notation, e: Expr) -> Written:
    a, b = e.children
    return _SUM, f"{n.text(a, _PRODUCT)} - {n.text(b, _PRODUCT)}"


def _neg(n: Notation, e: Expr) -> Written:
    (a,) = e.children
    return _UNARY, f"-{n.text(a, _ATOM if a.op in ('num', 'neg') else _UNARY)}"


def _times(n: Notation, e: Expr) -> Written:
    return _PRODUCT, " * ".join(n.text(c, _UNARY) for c in e.children)


def _over(n: Notation, e: Expr) -> Written:
    a, b = e.children
    top = n.text(a, _PRODUCT) if a.op == "*" else n.text(a, _UNARY)
    bottom = n.text(b, _UNARY)
    return _PRODUCT, f"{top} / {bottom}"


def _power(n: Notation, e: Expr) -> Written:
    a, b = e.children
    return _POWER, f"{n.text(a, _ATOM)}^{n.text(b, _UNARY)}"


def _comparison(n: Notation, e: Expr) -> Written:
    a, b = e.children
    op = "is" if e.op == "==" and "sym" in (a.op, b.op) else e.op
    return _COMPARE, f"{n.text(a, _SUM)} {op} {n.text(b, _SUM)}"


def _and(n: Notation, e: Expr) -> Written:
    return _AND, n.joined(e.children, "and", _UNTIL)


def _or(n: Notation, e: Expr) -> Written:
    return _OR, n.joined(e.children, "or", _AND)


def _not(n: Notation, e: Expr) -> Written:
    return _NOT, f"not {n.text(e.children[0], _NOT)}"


def _implies(n: Notation, e: Expr) -> Written:
    a, b = e.children
    return _IMPLIES, f"{n.text(a, _OR)} implies {n.text(b, _IMPLIES)}"


def _if(n: Notation, e: Expr) -> Written:
    c, a, b = e.children
    return _LOWEST, f"if {n.text(c)} then {n.text(a)} else {n.text(b)}"


def _temporal(n: Notation, e: Expr) -> Written:
    low, high, body = e.children
    return _NOT, f"{e.op}[{n.text(low)}, {n.text(high)}] {n.text(body, _NOT)}"


def _until(n: Notation, e: Expr) -> Written:
    low, high, a, b = e.children
    return _UNTIL, f"{n.text(a, _NOT)} until[{n.text(low)}, {n.text(high)}] {n.text(b, _NOT)}"


def _quantifier(n: Notation, e: Expr) -> Written:
    return _LOWEST, f"{e.op} {e.args[0]} in {e.args[1]}: {n.text(e.children[0])}"


def _function(n: Notation, e: Expr) -> Written:
    return _ATOM, f"{e.op}({', '.join(n.text(c) for c in e.children)})"


def _about(n: Notation, e: Expr) -> Written:
    return _ATOM, f"{e.op}({e.name})"


def _field(n: Notation, e: Expr) -> Written:
    return _ATOM, f"{n.text(e.children[0], _ATOM)}.{e.args[1]}"


def _column(n: Notation, e: Expr) -> Written:
    return _ATOM, f"{e.args[0]}.{e.args[1]}({', '.join(n.text(c) for c in e.children)})"


def _fuzzy(n: Notation, e: Expr) -> Written:
    named_args = e.args[2]
    assert isinstance(named_args, tuple)
    return _ATOM, f"{e.args[0]}.{e.args[1]}({', '.join(f'{k} = {n.text(v)}' for k, v in named_args)})"


def _apply(n: Notation, e: Expr) -> Written:
    return _ATOM, f"{e.name}({n.text(e.children[0])})"


def _stepped(n: Notation, e: Expr) -> Written:
    return _ATOM, f"{e.name}.{e.op}({n.text(e.children[0])})"


def _related(n: Notation, e: Expr) -> Written:
    return _ATOM, f"related({e.name}, {n.text(e.children[0])})"


def _covered(n: Notation, e: Expr) -> Written:
    return _ATOM, f"{e.args[0]}.covered({e.args[1]}, {n.text(e.children[0])})"


def _firing(n: Notation, e: Expr) -> Written:
    return _ATOM, f"{e.args[0]}.{e.op}({e.args[1]})"


def _cell(n: Notation, e: Expr) -> Written:
    return _ATOM, f"0b{e.args[1]}"


def _is(n: Notation, e: Expr) -> Written:
    return _COMPARE, f"{e.args[0]} is {e.args[1]}"


_WRITERS: dict[str, Callable[[Notation, Expr], Written]] = {
    "num": _num, "sym": _sym, "+": _sum, "-": _difference, "neg": _neg, "*": _times, "/": _over, "^": _power,
    "and": _and, "or": _or, "not": _not, "implies": _implies, "if": _if, "until": _until, "field": _field,
    "fuzzy": _fuzzy, "apply": _apply, "related": _related, "covered": _covered, "cell": _cell, "is": _is,
    **dict.fromkeys(("const", "param", "input", "var", "let", "bound"), _name),
    **dict.fromkeys(("netinput", "netoutput", "fuzzyinput"), _second_name),
    **dict.fromkeys(("time", "pi", "jumped", "stuck", "true", "false"), _word),
    **dict.fromkeys(("<", "<=", ">", ">=", "==", "!="), _comparison),
    **dict.fromkeys(("globally", "eventually"), _temporal),
    **dict.fromkeys(("forall", "exists", "unique"), _quantifier),
    **dict.fromkeys(("at", "jump"), _about),
    **dict.fromkeys(("next", "unique_rule"), _stepped),
    **dict.fromkeys(("table", "net"), _column),
    **dict.fromkeys(("max_firing", "strength"), _firing),
}  # fmt: skip
