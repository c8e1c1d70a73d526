"""What core expressions mean at an instant: values as cases of quotients of polynomials, truths as formulas."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from hacheck import bernstein
from hacheck.core import Core
from hacheck.formula import CLOSED, NEGATED, Formula, conj, disj, literal
from hacheck.rational import (
    ONE,
    PI,
    Beyond,
    Interval,
    Poly,
    Powers,
    Refused,
    add,
    const,
    constant,
    derivative,
    mul,
    names,  # fmt: skip
    number,
    power,
    scale,
    substitute,
    total,
    var,
)

Json = Any
Case = tuple[Formula, Poly, Poly]  # (the case does not apply, numerator, denominator)
TRUTHS = {"and", "or", "not", "implies", "at", "jump", "jumped", "stuck", *NEGATED}
RESERVED = {"s", "sigma", "pi"}


class Scope:
    """The constants, params and lets that an automaton sees; with `rounding`, constants vary within `half`."""

    def __init__(self, core: Core, automaton: Json, rounding: bool, outer: Scope | None = None) -> None:
        self.core, self.automaton, self.rounding, self.outer = core, automaton, rounding, outer
        self.constants = {c["name"]: c for c in automaton["constants"]} if outer else core.constants
        self.box: bernstein.Box = outer.box if outer else {"pi": PI}
        self._values: dict[str, list[Case] | None] = {}
        self._lets: dict[str | None, dict[str, Json]] = {}
        self._base, self._identities = Instant(self, None, {}), dict[str, Instant]()
        self.modes = {m["name"]: m for m in automaton["modes"]} if outer else {}
        self.types: dict[str, str] = {v["name"]: v["type"] for v in automaton["vars"]} if outer else {}
        self.params: dict[str, Poly] = dict(outer.params) if outer else {}
        for p in automaton["params"] if outer else core.data["params"]:
            low, high = self.range(p["low"])[0], self.range(p["high"])[1]
            if low is None or high is None or low > high or p["name"] in self.params:
                raise Refused(f"the range of param {p['name']} is empty, unbounded or given twice")
            self.params[p["name"]] = const(low) if low == high else var(p["name"])
            self.box[p["name"]] = (low, high)
        if RESERVED & {*self.params, *self.types} or set(self.params) & set(self.types):
            raise Beyond("a name has another meaning in certificates")
        self.rho: Poly | None = None  # the rate all modes share, once it is known to be one

    def constant(self, name: str) -> list[Case]:
        """The value of a constant, a box variable where it stands for a rounding box."""
        if name not in self.constants:
            if self.outer is None:
                raise Refused(f"there is no constant {name}")
            return self.outer.constant(name)
        if name not in self._values:
            self._values[name] = None
            self._values[name] = self._define(self.constants[name])
        found = self._values[name]
        if found is None:
            raise Refused(f"the constant {name} depends on itself")
        return found

    def _define(self, c: Json) -> list[Case]:
        if isinstance(c["value"], dict):
            raise Refused(f"the constant {c['name']} is a set")
        value = self._base.value(c["value"])
        if not self.rounding or c["half"] is None:
            return value
        middle, half, name = constant(value[0][1]), number(c["half"]), c["name"]
        if middle is None or half < 0 or len(value) > 1 or value[0][2] != ONE:
            raise Beyond(f"the rounding box of {name} is no interval")
        if name in self.params or name in self.types or name in RESERVED or name in self.box:
            raise Beyond(f"the name {name} has another meaning in certificates")
        self.box[name] = (middle - half, middle + half)
        return [(False, var(name), ONE)]

    def type_of(self, kind: str, name: str) -> str | None:
        """The type of a variable or constant."""
        if kind == "var":
            return self.types.get(name)
        found = self.constants.get(name)
        return found.get("type") if found else self.outer.type_of(kind, name) if self.outer else None

    def range(self, e: Json) -> Interval:
        """An enclosure of an expression of constants and params."""
        return (None, None) if e is None else bernstein.bounds(self._base.poly(e), self.box)

    def ordinal(self, enum: str, value: str) -> Fraction:
        """The number an enumeration value counts as."""
        found = self.core.enums.get(enum)
        if found is None or value not in found["values"]:
            raise Refused(f"there is no value {value} of {enum}")
        return Fraction(found["values"].index(value)) + (number(found["low"]) if found["low"] is not None else 0)

    def window(self, v: Json) -> Interval:
        """The declared range of a variable, as far out as constants and params allow; all values of its type."""
        if v["type"] == "real":
            return self.range(v["low"])[0], self.range(v["high"])[1]
        found = self.core.enums.get(v["type"], {"values": "01", "low": None})
        low = number(found["low"]) if found["low"] is not None else Fraction(0)
        return low, low + len(found["values"]) - 1

    def identity(self, mode: str) -> Instant:
        """Dwelling in a mode at the state its variables name."""
        if mode not in self._identities:
            self._identities[mode] = Instant(self, mode, {v: var(v) for v in self.types})
        return self._identities[mode]

    def rates(self, mode: str) -> dict[str, Poly]:
        """The flow: a polynomial of params and constants per variable, 0 for discrete ones."""
        out: dict[str, Poly] = {v: {} for v in self.types}
        for line in self.modes[mode]["flow"]:
            if "rate" not in line:
                raise Beyond("flows that are inclusions")
            out[line["var"]] = self._base.poly(line["rate"])
        return out

    def let(self, mode: str | None, name: str) -> Json:
        """The definition of a let in a mode."""
        if mode not in self._lets:
            listed = (self.automaton["lets"], self.modes[mode]["lets"] if mode else []) if self.outer else ()
            self._lets[mode] = {o["name"]: o for lets in listed for o in lets}
        if name not in self._lets[mode]:
            raise Refused(f"there is no let {name} in mode {mode}")
        return self._lets[mode][name]


class Instant:
    """A mode, values of its variables as polynomials, and what happened just before."""

    def __init__(self, scope: Scope, mode: str | None, env: dict[str, Poly], *, time: Poly | None = None,
                 edge: str | None = None, before: Instant | None = None) -> None:  # fmt: skip
        self.scope, self.mode, self.env, self.time, self.edge, self.before = scope, mode, env, time, edge, before
        self._lets: dict[str, list[Case] | None] = {}
        self._careful = 0  # > 0 where a division that may be by zero, or a switch, is not understood
        self._powers: Powers = {}

    def poly(self, e: Json) -> Poly:
        """The value, where it is one polynomial."""
        cases = self.value(e)
        divisor = constant(cases[0][2])
        if len(cases) > 1 or not divisor:
            raise Beyond("a value that should be a polynomial is none")
        return scale(cases[0][1], 1 / divisor)

    def value(self, e: Json) -> list[Case]:
        """The cases of a number; a truth counts as 0 or 1."""
        if isinstance(e, str):
            return [(False, const(number(e)), ONE)]
        if isinstance(e, bool) or self._is_truth(e):
            yes, no = self._careful_formula(e, False), self._careful_formula(e, True)
            return [c for c in ((no, ONE, ONE), (yes, {}, ONE)) if c[0] is not True]
        op, args = _node(e)
        if op in _LEAVES:
            return self._leaf(op, args)
        if op in ("+", "-", "neg", "*", "/", "^", "scale"):
            return self._arithmetic(op, args)
        if op == "pre":
            return (self.before or self).value(args[0])
        if op == "der":
            return [(False, *self._slope(args[0]))]
        return self._switch(op, args)

    def _leaf(self, op: str, args: list[Json]) -> list[Case]:
        if op == "const":
            return self.scope.constant(args[0])
        if op == "let":
            return self._let(args[0])
        if op == "time" and (self.time is not None or self.scope.rho is not None):
            return [(False, self.time, ONE) if self.time is not None else (False, var("sigma"), self.scope.rho or ONE)]
        known = self.env if op == "var" or (args[:1] and args[0] in self.env) else self.scope.params
        if op in ("var", "param") and args[0] in known:
            return [(False, known[args[0]], ONE)]
        if op in ("pi", "sym"):
            return [(False, var("pi") if op == "pi" else const(self.scope.ordinal(*args)), ONE)]
        raise Beyond("the time is not tracked" if op == "time" else f"there is no {op} {args[0]!a} here")

    def _let(self, name: str) -> list[Case]:
        if name not in self._lets:
            self._lets[name] = None
            self._lets[name] = self.value(self.scope.let(self.mode, name)["expr"])
        found = self._lets[name]
        if found is None:
            raise Refused(f"the let {name} depends on itself")
        return found

    def _arithmetic(self, op: str, args: list[Json]) -> list[Case]:
        if op == "neg":
            return [(no, scale(n, -1), d) for no, n, d in self.value(args[0])]
        if op == "scale":
            q, k = number(args[0]), args[1]
            up, down = (power(var("pi"), abs(k)), ONE) if k >= 0 else (ONE, power(var("pi"), abs(k)))
            return [(no, mul(scale(n, q), up), mul(d, down)) for no, n, d in self.value(args[2])]
        out = self.value(args[0])
        if op == "^":
            k = constant(self.poly(args[1]))
            if k is None or k.denominator != 1:
                raise Beyond("powers with other exponents than integers")
            raised = [(no, power(n, abs(int(k))), power(d, abs(int(k)))) for no, n, d in out]
            return raised if k >= 0 else [(no, d, n) for no, n, d in raised]
        for e in args[1:]:
            out = [_combine(op, a, b) for a in out for b in self.value(e)]
            out = [c for c in out if c[0] is not True]
            if len(out) > 64:
                raise Beyond("an expression has too many cases")
        return out

    def _switch(self, op: str, args: list[Json]) -> list[Case]:
        if op == "if":
            no, yes = self._careful_formula(args[0], True), self._careful_formula(args[0], False)
            if self._careful and not isinstance(yes, bool):
                raise Beyond("`if` in a domain, a guard or a condition")
            return _either(no, args[1], yes, args[2], self)
        if op == "abs":
            below = self._careful_formula(["<", args[0], "0"], False)
            return _either(below, args[0], self._careful_formula([">=", args[0], "0"], False), ["neg", args[0]], self)
        if op == "clamp":
            return self.value(["min", ["max", args[0], args[1]], args[2]])
        if op in ("min", "max"):
            a, b = args[0], [op, *args[1:]] if len(args) > 2 else args[-1]
            if len(args) < 2:
                return self.value(a)
            worse = ">" if op == "min" else "<"
            no, yes = self._careful_formula([worse, a, b], False), self._careful_formula([worse, a, b], True)
            return _either(no, a, yes, b, self)
        raise Beyond(f"`{op!s:.20}` is outside the checker's fragment")

    def _slope(self, e: Json) -> tuple[Poly, Poly]:
        if self.mode is None:
            raise Refused("a derivative outside a mode")
        still, rates = self.scope.identity(self.mode), self.scope.rates(self.mode)
        cases = still.value(e)
        moving = {**rates, **({"sigma": self.scope.rho} if self.scope.rho is not None else {})}
        timed = self.time is not None and "sigma" in names(cases[0][1])
        if len(cases) > 1 or names(cases[0][2]) & set(moving) or timed:
            raise Beyond("a derivative of what is no polynomial")
        slope = total(mul(derivative(cases[0][1], v), r) for v, r in moving.items())
        return substitute(slope, self.env, self._powers), cases[0][2]

    def _is_truth(self, e: Json) -> bool:
        op, args = _node(e) if isinstance(e, list) else ("", [e])
        if op in ("if", "pre"):
            return self._is_truth(args[-1])
        if op in ("var", "const"):
            return self.scope.type_of(op, args[0]) == "bool"
        if op == "let":
            return bool(self.scope.let(self.mode, args[0])["type"] == "bool")
        return op in TRUTHS or (isinstance(args[0] if args else 0, bool) and not op)

    def _careful_formula(self, e: Json, neg: bool) -> Formula:
        self._careful += 1
        try:
            return self.formula(e, neg)
        finally:
            self._careful -= 1

    def formula(self, e: Json, neg: bool = False, closed: bool = False, outer: bool = False) -> Formula:
        """`e`, negated if `neg`, then read as a closed set if `closed`, then negated again if `outer`."""
        how, flip = (neg, closed, outer), neg is not outer
        if isinstance(e, bool):
            return e is not flip
        op, args = _node(e)
        if op in ("and", "or"):
            return (conj if (op == "and") is not flip else disj)([self.formula(a, *how) for a in args])
        if op == "not":
            return self.formula(args[0], not neg, closed, outer)
        if op == "implies":
            return self.formula(["or", ["not", args[0]], args[1]], *how)
        if op == "if":
            return self._choice(args, how)
        if op in NEGATED:
            return self._compare(op, args, how)
        if op in ("at", "jump", "jumped"):
            now = args[0] == (self.mode if op == "at" else self.edge) if args else self.edge is not None
            return now is not flip
        if op == "pre":
            return (self.before or self).formula(args[0], *how)
        if op == "let" and self._is_truth(e):
            return self.formula(self.scope.let(self.mode, args[0])["expr"], *how)
        if op in ("var", "const") and self._is_truth(e):
            return literal("<=" if flip else ">=", add(self.poly(e), const(0 if flip else -1)))
        raise Beyond(f"`{op!s:.20}` is outside the checker's fragment")

    def _choice(self, args: list[Json], how: tuple[bool, bool, bool]) -> Formula:
        no, yes = self._careful_formula(args[0], True), self._careful_formula(args[0], False)
        if (how[1] or self._careful) and not isinstance(yes, bool):
            raise Beyond("`if` in a domain, a guard or a condition")
        return conj([disj([no, self.formula(args[1], *how)]), disj([yes, self.formula(args[2], *how)])])

    def _compare(self, op: str, args: list[Json], how: tuple[bool, bool, bool]) -> Formula:
        neg, closed, outer = how
        if op in ("==", "!=") and self._is_truth(args[0]) and self._is_truth(args[1]):
            a, b = args
            same = ["or", ["and", a, b], ["and", ["not", a], ["not", b]]]
            return self.formula(same, neg is not (op == "!="), closed, outer)
        op = NEGATED[op] if neg else op
        if closed and op == "!=":
            return not outer
        op = CLOSED[op] if closed else op
        op = NEGATED[op] if outer else op
        self._careful += closed
        try:
            pairs = [_combine("-", a, b) for a in self.value(args[0]) for b in self.value(args[1])]
            return conj([disj([no, self._literal(op, n, d)]) for no, n, d in pairs])
        finally:
            self._careful -= closed

    def _literal(self, op: str, n: Poly, d: Poly) -> Formula:
        """`n / d op 0` and `d != 0`; true only where everything is defined."""
        if d == ONE:
            return literal(op, n)
        for sign, q in ((">", n), ("<", scale(n, -1))):
            if bernstein.certain(sign, d, self.scope.box):
                return literal(op, q)
        if self._careful:
            raise Beyond("a division, perhaps by zero, in a domain, a guard or a condition")
        return conj([literal(op, mul(n, d)), literal("!=", d)])


_LEAVES = {"const", "let", "var", "param", "input", "time", "pi", "sym"}


def _node(e: Json) -> tuple[str, list[Json]]:
    if not isinstance(e, list) or not e or not isinstance(e[0], str):
        raise Refused("an expression is malformed")
    return e[0], e[1:]


def _either(no: Formula, a: Json, yes: Formula, b: Json, at: Instant) -> list[Case]:
    """a except where `no`, b except where `yes`; a branch that never applies is not evaluated."""
    first = [] if no is True else [(disj([no, m]), n, d) for m, n, d in at.value(a)]
    return first + ([] if yes is True else [(disj([yes, m]), n, d) for m, n, d in at.value(b)])


def _combine(op: str, a: Case, b: Case) -> Case:
    no = disj([a[0], b[0]])
    if op == "*":
        return no, mul(a[1], b[1]), mul(a[2], b[2])
    if op == "/":
        return no, mul(a[1], b[2]), mul(a[2], b[1])
    sign = 1 if op == "+" else -1
    if a[2] == b[2]:
        return no, add(a[1], b[1], sign), a[2]
    return no, add(mul(a[1], b[2]), mul(b[1], a[2]), sign), mul(a[2], b[2])
