"""Expressions of the core as functions of a state, in floating point: good enough to draw, never to decide."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from functools import lru_cache
from operator import ge, gt, le, lt
from typing import Any

from haverify.report.figures.material import Json, Material, Undrawable
from haverify.report.figures.polynomials import COMBINED, Coefficients, evaluated, product
from haverify.text.record import field, holder

State = dict[str, float]
Value = Callable[[State], float]

_STEP = 1e-5  # of central differences, relative to the range of no clock smaller than a second
_DEPTH = 60


@holder
class Scope:
    """What names mean in one mode of one automaton. `rates` are those of its variables, by name.

    Params stand at their defaults, or where they have none at the middle of their range.
    """

    mode: str
    constants: dict[str, Any]
    params: dict[str, Any]
    lets: dict[str, Any]
    rates: dict[str, Any]
    enums: dict[str, list[str]]
    depth: int = 0
    known: dict[str, tuple[str | None, Coefficients]] = field(default_factory=dict)
    read: dict[str, set[str]] = field(default_factory=dict)

    def value(self, e: Any) -> Value:
        """The function that computes `e`.

        Raises
        ------
        Undrawable      for what is no function of the state here: inputs, `pre`, jumps, nets and the like
        """
        self.depth += 1
        try:
            if self.depth > _DEPTH:
                raise Undrawable
            p = self.polynomial(e)
            return self._of(str(e[0]), e[1:]) if p is None else evaluated(*p)
        finally:
            self.depth -= 1

    def polynomial(self, e: Any) -> tuple[str | None, Coefficients] | None:
        """The variable and the coefficients (lowest first) of a polynomial in at most one; None for anything else."""
        if isinstance(e, str):
            return None, [_number(e)]
        if not isinstance(e, list) or not e or e[0] not in _POLYNOMIAL:
            if isinstance(e, bool):
                return None, [float(e)]
            if not isinstance(e, list) or not e:
                raise Undrawable
            return None
        return self._polynomial(str(e[0]), e[1:])

    def _polynomial(self, op: str, args: list[Any]) -> tuple[str | None, Coefficients] | None:
        if op == "var":
            return str(args[0]), [0.0, 1.0]
        if op in ("const", "param", "let"):
            return self._by_name(op, str(args[0]))
        if op == "scale":
            p = self.polynomial(args[2])
            factor = _number(args[0]) * math.pi ** int(args[1])
            return p and (p[0], [factor * c for c in p[1]])
        if op == "^":
            return self._power(args)
        inner = [self.polynomial(a) for a in args]
        known = [p for p in inner if p is not None]
        names = {p[0] for p in known if p[0] is not None}
        if len(known) < len(inner) or len(names) > 1:
            return None
        return next(iter(names), None), COMBINED[op]([p[1] for p in known])

    def _power(self, args: list[Any]) -> tuple[str | None, Coefficients] | None:
        if not isinstance(args[1], str) or not args[1].isdigit() or int(args[1]) > 40:
            return None
        p = self.polynomial(args[0])
        return p and (p[0], product([p[1]] * int(args[1])))

    def _by_name(self, op: str, name: str) -> tuple[str | None, Coefficients] | None:
        """What a name stands for, computed once."""
        key = f"{op} {name}"
        if key not in self.known:
            definitions = {"const": self.constants, "param": self.params, "let": self.lets}[op]
            if name not in definitions or self.depth > _DEPTH:
                raise Undrawable
            self.depth += 1
            p = self.polynomial(definitions[name])
            if p is None and op != "let":
                p = None, [self.value(definitions[name])({})]
            self.depth -= 1
            if p is None:
                return None
            self.known[key] = p
        return self.known[key]

    def _of(self, op: str, args: list[Any]) -> Value:
        if op in _NAMED:
            return getattr(self, f"_{op}")(args)  # type: ignore[no-any-return]
        if op not in _FUNCTIONS:
            raise Undrawable
        function, inner = _FUNCTIONS[op], [self.value(a) for a in args]
        if len(inner) == 1:
            one = inner[0]
            return lambda s: function(one(s))
        if len(inner) == 2:
            one, two = inner
            return lambda s: function(one(s), two(s))
        return lambda s: function(*[f(s) for f in inner])

    def _let(self, args: list[Any]) -> Value:
        if args[0] not in self.lets:
            raise Undrawable
        return self.value(self.lets[args[0]])

    def _at(self, args: list[Any]) -> Value:
        return _constant(float(args[0] == self.mode))

    def _sym(self, args: list[Any]) -> Value:
        values = self.enums.get(args[0], [])
        if args[1] not in values:
            raise Undrawable
        return _constant(float(values.index(args[1])))

    def _pi(self, args: list[Any]) -> Value:
        return _constant(math.pi)

    def _scale(self, args: list[Any]) -> Value:
        factor, inner = _number(args[0]) * math.pi ** int(args[1]), self.value(args[2])
        return lambda s: factor * inner(s)

    def _if(self, args: list[Any]) -> Value:
        condition, then, other = map(self.value, args)
        return lambda s: then(s) if condition(s) else other(s)

    def _der(self, args: list[Any]) -> Value:
        """The derivative along the flow; of what is no polynomial by a central difference."""
        p = self.polynomial(args[0])
        if p is not None:
            rate = self.value(self.rates[p[0]])({}) if p[0] is not None else 0.0
            return evaluated(p[0], [k * c * rate for k, c in enumerate(p[1])][1:] or [0.0])
        inner = self.value(args[0])
        rates = {name: self.value(rate)({}) for name, rate in self.rates.items()}

        def slope(s: State) -> float:
            ahead = {name: value + _STEP * rates.get(name, 0.0) for name, value in s.items()}
            behind = {name: value - _STEP * rates.get(name, 0.0) for name, value in s.items()}
            return (inner(ahead) - inner(behind)) / (2 * _STEP)

        return slope


_NAMED = ("let", "at", "sym", "scale", "pi", "if", "der")
_POLYNOMIAL = ("var", "const", "param", "let", "scale", "+", "-", "neg", "*", "^")


def scope(material: Material, automaton: Json, mode: Json) -> Scope:
    """The scope of a mode, made once; an automaton's own constants and params hide those of the file."""
    key = (automaton["name"], mode["name"])
    if key not in material.scopes:
        material.scopes[key] = _scope(material.core, automaton, mode)
    return material.scopes[key]  # type: ignore[no-any-return]


def with_params(s: Scope, params: dict[str, str]) -> Scope:
    """The scope with other values of its params."""
    return Scope(s.mode, s.constants, {**s.params, **params}, s.lets, s.rates, s.enums)


def _scope(core: Json, automaton: Json, mode: Json) -> Scope:
    outer, inner = core.get("constants", []), automaton.get("constants", [])
    params = [*core.get("params", []), *automaton.get("params", [])]
    lets = {x["name"]: x["expr"] for x in [*automaton.get("lets", []), *mode.get("lets", [])]}
    return Scope(
        mode["name"],
        {c["name"]: c["value"] for c in [*outer, *inner]},
        {p["name"]: p["default"] if p.get("default") is not None else _middle(p) for p in params},
        lets,
        {line["var"]: line.get("rate") for line in mode.get("flow", [])},
        {e["name"]: e["values"] for e in core.get("enums", [])},
    )


def reads(e: Any, s: Scope) -> set[str]:
    """The variables that an expression reads, through lets."""
    found, pending = set[str](), [e]
    while pending:
        x = pending.pop()
        if not isinstance(x, list) or not x:
            continue
        if x[0] == "var":
            found.add(str(x[1]))
        elif x[0] == "let":
            found |= _read_by_let(str(x[1]), s)
        elif x[0] not in ("const", "param", "sym", "at"):
            pending += x[1:]
    return found


def _read_by_let(name: str, s: Scope) -> set[str]:
    """What a let reads, computed once; a let that reads itself, which no core has, reads nothing more."""
    if name not in s.read:
        s.read[name] = set()
        s.read[name] = reads(s.lets.get(name), s)
    return s.read[name]


def _middle(p: Json) -> Any:
    return ["/", ["+", p.get("low"), p.get("high")], "2"]


@lru_cache(maxsize=10_000)
def _number(text: Any) -> float:
    try:
        return float(Fraction(text))
    except (ValueError, ZeroDivisionError, OverflowError, TypeError):
        raise Undrawable from None


def _constant(value: float) -> Value:
    return lambda _: value


def _product(*factors: float) -> float:
    return math.prod(factors)


_FUNCTIONS: dict[str, Callable[..., Any]] = {
    "+": lambda *v: sum(v),
    "-": lambda a, b: a - b,
    "neg": lambda a: -a,
    "*": _product,
    "/": lambda a, b: a / b,
    "^": lambda a, b: a**b,
    "abs": abs,
    "min": min,
    "max": max,
    "clamp": lambda a, low, high: min(max(a, low), high),
    "sqrt": math.sqrt,
    "sin": math.sin,
    "cos": math.cos,
    "tan": math.tan,
    "exp": math.exp,
    "ln": math.log,
    "<": lt,
    "<=": le,
    ">": gt,
    ">=": ge,
    "==": lambda a, b: a == b,
    "!=": lambda a, b: a != b,
    "and": lambda *v: all(v),
    "or": lambda *v: any(v),
    "not": lambda a: not a,
    "implies": lambda a, b: (not a) or b,
}
