"""Expressions as text, with the parentheses that precedence needs and no others."""

from __future__ import annotations

from haverify.syntax.tree import (
    Argument,
    Binary,
    Bits,
    Call,
    Comparison,
    Expr,
    Family,
    If,
    Index,
    Interval,
    Member,
    Name,
    Number,
    Pair,
    Paren,
    Quantifier,
    Temporal,
    Truth,
    Unary,
    Until,
)

LOOSEST, IMPLIES, OR, AND, UNTIL, NOT, COMPARISON, SUM, PRODUCT, SIGN, POWER, ATOM = range(12)
# operator: its own level, and what its left and right side need at least
BINARY = {
    "implies": (IMPLIES, OR, IMPLIES),
    "or": (OR, OR, AND),
    "and": (AND, AND, UNTIL),
    "+": (SUM, SUM, PRODUCT),
    "-": (SUM, SUM, PRODUCT),
    "+-": (SUM, SUM, PRODUCT),
    "*": (PRODUCT, PRODUCT, SIGN),
    "/": (PRODUCT, PRODUCT, SIGN),
    "^": (POWER, ATOM, SIGN),
}


def print_expr(expr: Expr) -> str:
    """The text of an expression; parsing it gives the expression back, up to spans."""
    return _at(expr, LOOSEST)


def print_family(family: Family | None) -> str:
    """` for i in I`, or nothing."""
    return f" for {family.name} in {print_expr(family.of)}" if family else ""


def _at(expr: Expr, level: int) -> str:
    own, text = _level(expr), _text(expr)
    return f"({text})" if own < level else text


def _level(expr: Expr) -> int:
    if isinstance(expr, Binary):
        return BINARY[expr.op][0]
    if isinstance(expr, Unary):
        return SIGN if expr.op == "-" else NOT
    if isinstance(expr, Number):
        return SIGN if expr.text.startswith("-") else ATOM
    levels = {If: LOOSEST, Quantifier: LOOSEST, Until: UNTIL, Temporal: NOT, Comparison: COMPARISON}
    return levels.get(type(expr), ATOM)


def _text(expr: Expr) -> str:
    match expr:
        case Name(id=text) | Bits(digits=text):
            return text
        case Number():
            return f"{expr.text} {expr.unit}" if expr.unit else expr.text
        case Truth():
            return "true" if expr.value else "false"
        case Member() | Index() | Call():
            return _postfix(expr)
        case Binary():
            return _binary(expr)
        case Unary():
            return "-" + _at(expr.operand, SIGN) if expr.op == "-" else "not " + _at(expr.operand, NOT)
        case Comparison():
            sides = [_at(operand, SUM) for operand in expr.operands]
            return sides[0] + "".join(f" {op} {side}" for op, side in zip(expr.ops, sides[1:], strict=True))
        case _:
            return _enclosed(expr)


def _enclosed(expr: Expr) -> str:
    match expr:
        case Paren():
            return f"({print_expr(expr.inner)})"
        case Interval():
            return f"[{print_expr(expr.low)}, {print_expr(expr.high)}]"
        case Pair():
            return f"({print_expr(expr.left)}, {print_expr(expr.right)})"
        case If():
            condition, yes, no = (print_expr(part) for part in (expr.condition, expr.yes, expr.no))
            return f"if {condition} then {yes} else {no}"
        case Quantifier():
            return f"{expr.kind} {expr.name} in {print_expr(expr.of)}: {print_expr(expr.body)}"
        case Temporal():
            return f"{expr.kind}[{print_expr(expr.low)}, {print_expr(expr.high)}] {_at(expr.body, NOT)}"
        case Until():
            window = f"[{print_expr(expr.low)}, {print_expr(expr.high)}]"
            return f"{_at(expr.left, NOT)} until{window} {_at(expr.right, NOT)}"
    raise TypeError(f"not an expression: {expr!r}")


def _binary(expr: Binary) -> str:
    """A chain of one level is walked, not descended into: a sum may have thousands of terms."""
    level = BINARY[expr.op][0]
    parts: list[str] = []
    left: Expr = expr
    while isinstance(left, Binary) and BINARY[left.op][0] == level and BINARY[left.op][1] == level:
        parts += [_at(left.right, BINARY[left.op][2]), f" {left.op} "]
        left = left.left
    if not parts:
        assert isinstance(left, Binary)
        glue = left.op if left.op == "^" and not _measured(left.left) else f" {left.op} "
        return _at(left.left, BINARY[left.op][1]) + glue + _at(left.right, BINARY[left.op][2])
    return "".join(reversed([*parts, _at(left, level)]))


def _measured(expr: Expr) -> bool:
    """A quantity, whose unit would take a `^` that follows without a blank."""
    return isinstance(expr, Number) and expr.unit is not None


def _postfix(expr: Expr) -> str:
    parts: list[str] = []
    while isinstance(expr, Member | Index | Call):
        if isinstance(expr, Member):
            parts.append(f".{expr.name}")
            expr = expr.base
        elif isinstance(expr, Index):
            parts.append(f"[{print_expr(expr.index)}]")
            expr = expr.base
        else:
            parts.append(f"({', '.join(_argument(argument) for argument in expr.arguments)})")
            expr = expr.function
    return "".join(reversed([*parts, _at(expr, ATOM)]))


def _argument(argument: Argument) -> str:
    name = f"{argument.name} = " if argument.name else ""
    return name + print_expr(argument.value) + print_family(argument.family)
