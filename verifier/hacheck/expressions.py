"""What core expressions mean at an instant: values as cases of quotients of polynomials, truths as formulas."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from fractions import Fraction
from functools import cached_property
from itertools import product
from typing import Any

from hacheck import bernstein
from hacheck.core import Core
from hacheck.formula import CLOSED, NEGATED, Formula, conj, disj, literal
from hacheck.polynomial import (
    ONE,
    ZERO,
    Images,
    Poly,
    add,
    along,
    const,
    constant,
    mul,
    names,
    power,
    scale,
    substitute,
    var,
)
from hacheck.rational import PI, Beyond, Interval, Refused, number, spend

Json = Any
Case = tuple[Formula, Poly, Poly]  # (the case does not apply, numerator, denominator)
TRUTHS = {"and", "or", "not", "implies", "at", "jump", "jumped", "stuck", *NEGATED}
EVENTS = {"jump", "jumped", "pre", "stuck"}
MANY = (1, 10**6)
ARITY = {  # the fewest and the most operands
    **dict.fromkeys(("pi", "time", "jumped", "stuck"), (0, 0)),
    **dict.fromkeys(("const", "param", "input", "var", "let", "neg", "abs", "not", "at", "jump", "pre", "der"), (1, 1)),
    **dict.fromkeys(("sym", "-", "/", "^", "implies", *NEGATED), (2, 2)),
    **dict.fromkeys(("scale", "clamp", "if"), (3, 3)), **dict.fromkeys(("+", "*", "min", "max", "and", "or"), MANY),
}  # fmt: skip


def nodes(value: Json) -> Iterator[list[Json]]:
    """All lists inside a JSON value that begin with a string, outermost first."""
    stack = [value]
    while stack:
        item = stack.pop()
        if isinstance(item, list):
            if item and isinstance(item[0], str):
                yield item
            stack.extend(reversed(item))
        elif isinstance(item, dict):
            stack.extend(item.values())


def well_formed(value: Json, events: bool) -> None:
    """Refuse operators with a wrong number of operands, and what just happened where that has no meaning."""
    for n in nodes(value):
        least, most = ARITY.get(n[0], (0, 10**6))
        if not least <= len(n) - 1 <= most:
            raise Refused(f"`{n[0]:.20}` has a wrong number of operands")
        inner = n[0] in ("pre", "der") and any(m[0] in EVENTS for m in nodes(n[1:]))
        if inner or (n[0] in EVENTS and not events):
            raise Beyond("`pre`, `jump`, `jumped` or `stuck` where nothing has just happened")


class Scope:
    """The constants, params and lets that an automaton sees; with `rounding`, constants vary within `half`."""

    def __init__(self, core: Core, automaton: Json, rounding: bool, outer: Scope | None = None) -> None:
        self.core, self.automaton, self.rounding, self.outer = core, automaton, rounding, outer
        self.rho: Poly | None = None  # the rate all modes share, if they share one
        self.constants = {c["name"]: c for c in automaton["constants"]} if outer else core.constants
        self.box: bernstein.Box = outer.box if outer else {"pi": PI}
        self._values: dict[str, list[Case]] = {}
        self._lets: dict[str, dict[str, Json]] = {}
        self._rates: dict[str, dict[str, Poly]] = {}
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
        if outer:
            self._check_names(core.data["constants"] + automaton["constants"])

    def _check_names(self, constants: list[Json]) -> None:
        """A name means one thing in a box."""
        rounded = {c["name"] for c in constants if self.rounding and c["half"] is not None}
        known = [*self.types, *self.params, *rounded, "s", "sigma", "pi"]
        if len(set(known)) < len(known) or any("'" in n for n in known):
            raise Beyond("a name has another meaning in certificates")

    def constant(self, name: str) -> list[Case]:
        """The value of a constant, a box variable where it stands for a rounding box."""
        if name not in self.constants:
            if self.outer is None:
                raise Refused(f"there is no constant {name}")
            return self.outer.constant(name)
        if name not in self._values:
            self._values[name] = self._define(self.constants[name])
        return self._values[name]

    def _define(self, c: Json) -> list[Case]:
        if isinstance(c["value"], dict):
            raise Refused(f"the constant {c['name']} is a set")
        value = self._base.value(c["value"])
        if not self.rounding or c["half"] is None:
            return value
        middle, half, name = constant(value[0][1]), number(c["half"]), c["name"]
        if middle is None or half < 0 or len(value) > 1 or value[0][2] != ONE:
            raise Beyond(f"the rounding box of {name} is no interval")
        if name in self.box:
            raise Beyond(f"the name {name} has another meaning in certificates")
        self.box[name] = (middle - half, middle + half)
        return [(False, var(name), ONE)]

    def type_of(self, kind: str, name: str) -> str | None:
        """The type of a variable or constant."""
        if kind == "var":
            return self.types.get(name)
        found = self.constants.get(name)
        return found.get("type") if found else self.outer.type_of(kind, name) if self.outer else None

    def range(self, e: Json, fixed: bool = False) -> Interval:
        """An enclosure of an expression of constants and params, or of constants alone."""
        p = self._base.poly(e) if e is not None else None
        if p is not None and fixed and names(p) & set(self.params):
            raise Beyond("a declared range that depends on params")
        return (None, None) if p is None else bernstein.bounds(p, self.box)

    def integral(self, p: Poly) -> bool:
        """Is it an integer wherever discrete variables are?"""
        return p.unit == 1 and all(self.types.get(v, "real") != "real" for v in names(p))

    def ordinal(self, enum: str, value: str) -> Fraction:
        """The number an enumeration value counts as."""
        found = self.core.enums.get(enum)
        if found is None or value not in found["values"]:
            raise Refused(f"there is no value {value} of {enum}")
        return Fraction(found["values"].index(value)) + (number(found["low"]) if found["low"] is not None else 0)

    def window(self, name: str) -> Interval:
        """The declared range of a variable, as far out as constants allow; all values of its type."""
        v = next(v for v in self.automaton["vars"] if v["name"] == name)
        if v["type"] == "real":
            return self.range(v["low"], fixed=True)[0], self.range(v["high"], fixed=True)[1]
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
        if mode not in self._rates:
            flow, at = self.modes[mode]["flow"], Instant(self, mode, {})
            if not all("rate" in line for line in flow):
                raise Beyond("flows that are inclusions")
            self._rates[mode] = {**dict.fromkeys(self.types, ZERO), **{f["var"]: at.poly(f["rate"]) for f in flow}}
        return self._rates[mode]

    def let(self, mode: str | None, name: str) -> Json:
        """The definition of a let in a mode."""
        if mode is None:
            raise Beyond("a let outside a mode")
        if mode not in self._lets:
            self._lets[mode] = {o["name"]: o for o in self.automaton["lets"] + self.modes[mode]["lets"]}
        if name not in self._lets[mode]:
            raise Refused(f"there is no let {name} in mode {mode}")
        return self._lets[mode][name]


class Instant:
    """A mode, values of its variables as polynomials, and what happened just before."""

    def __init__(self, scope: Scope, mode: str | None, env: dict[str, Poly], *, time: Poly | None = None,
                 edge: str | None = None, before: Instant | None = None) -> None:  # fmt: skip
        self.scope, self.mode, self.env, self.time, self.edge, self.before = scope, mode, env, time, edge, before
        self._lets: dict[tuple[str, bool], list[Case]] = {}
        self._careful = 0  # > 0 where a division that may be by zero, or a switch, is not understood
        self._images: Images = {}

    @cached_property
    def domain(self) -> Formula:
        """The state is in the mode's domain, read as closed (S6)."""
        return self.formula(self.scope.modes[str(self.mode)]["domain"], closed=True)

    @cached_property
    def outside(self) -> Formula:
        """The state is not in the mode's closed domain."""
        return self.formula(self.scope.modes[str(self.mode)]["domain"], closed=True, outer=True)

    def poly(self, e: Json) -> Poly:
        """The value, where it is one polynomial."""
        bit = self._bit(e[1]) if isinstance(e, list) and e[:1] == ["if"] and len(e) == 4 else None
        if bit is not None:
            return _chosen(bit, self.poly(e[2]), self.poly(e[3]))
        cases = self.value(e)
        divisor = constant(cases[0][2])
        if len(cases) > 1 or not divisor:
            raise Beyond("a value that should be a polynomial is none")
        return scale(cases[0][1], 1 / divisor)

    def value(self, e: Json) -> list[Case]:
        """The cases of a number; a truth counts as 0 or 1."""
        spend(5)
        if isinstance(e, str):
            return [(False, const(number(e)), ONE)]
        if isinstance(e, bool):
            return [(False, const(e), ONE)]
        op, args = _node(e)
        if op in _LEAVES:
            return self._leaf(op, args)
        if op == "pre":
            return (self.before or self).value(args[0])
        if self._is_truth(e):
            return self._truth(e)
        if op in ("+", "-", "neg", "*", "/", "^", "scale"):
            return self._arithmetic(op, args)
        if op == "der":
            return [(False, *self._slope(args[0]))]
        return self._switch(op, args)

    def _truth(self, e: Json) -> list[Case]:
        bit = self._bit(e)
        if bit is not None:
            return [(False, bit, ONE)]
        no, yes = self._sides(e)
        return _few([(no, ONE, ONE), (yes, ZERO, ONE)])

    def _bit(self, e: Json) -> Poly | None:
        """A truth made of truth variables, as a polynomial in them; None for others."""
        op, args = _node(e) if isinstance(e, list) else ("", [])
        if not op or op in ("var", "const"):
            return self.poly(e) if isinstance(e, bool) or self._is_truth(e) else None
        if op == "implies":
            op, args = "or", [["not", args[0]], args[1]]
        bits = [self._bit(a) for a in args] if op in ("not", "and", "or", "if", "==", "!=") else [None]
        if op in ("if", "==", "!=") and len(bits) > 1:
            first, *_, last = bits
            yes, no = (bits[1], last) if op == "if" else (last, None if last is None else add(ONE, last, -1))
            yes, no = (no, yes) if op == "!=" else (yes, no)
            return None if first is None or yes is None or no is None else _chosen(first, yes, no)
        known = [b if op == "and" else add(ONE, b, -1) for b in bits if b is not None]
        if len(known) < len(bits):
            return None
        out = ONE
        for b in known:
            out = mul(out, b)
        return add(ONE, out, -1) if op == "or" else out

    def _leaf(self, op: str, args: list[Json]) -> list[Case]:
        if op == "const":
            return self.scope.constant(args[0])
        if op == "let":
            return self._let(args[0])
        if op == "time" and self.time is not None:
            return [(False, self.time, ONE)]
        if op == "time" and self.mode is not None and self.scope.rho is not None:
            return [(False, var("sigma"), self.scope.rho)]
        known = self.env if op == "var" or (args[:1] and args[0] in self.env) else self.scope.params
        if op in ("var", "param") and args[0] in known:
            return [(False, known[args[0]], ONE)]
        if op in ("pi", "sym"):
            return [(False, var("pi") if op == "pi" else const(self.scope.ordinal(*args)), ONE)]
        raise Beyond("the time is not tracked" if op == "time" else f"there is no {op} {args[0]!a} here")

    def _let(self, name: str) -> list[Case]:
        key = name, self._careful > 0
        if key not in self._lets:
            self._lets[key] = self.value(self.scope.let(self.mode, name)["expr"])
        return self._lets[key]

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
            if k is None or k.denominator != 1 or (k <= 0 and any(names(d) for _, _, d in out)):
                raise Beyond("powers with other exponents than integers, or of quotients")
            raised = [(no, power(n, abs(int(k))), power(d, abs(int(k)))) for no, n, d in out]
            return raised if k >= 0 else [(no, d, n) for no, n, d in raised]
        for e in args[1:]:
            out = _few(_combine(op, a, b) for a, b in product(out, self.value(e)))
        return out

    def _switch(self, op: str, args: list[Json]) -> list[Case]:
        if op == "if":
            no, yes = self._switched(args[0], self._careful > 0)
            return _few((disj([m, n]), *v) for m, e in ((no, args[1]), (yes, args[2])) if m is not True
                        for n, *v in self.value(e))  # fmt: skip
        if op == "abs":
            return _few(c for no, n, d in self.value(args[0]) for c in self._greater((no, n, d), (no, scale(n, -1), d)))
        if op == "clamp":
            return self.value(["min", ["max", args[0], args[1]], args[2]])
        if op not in ("min", "max"):
            raise Beyond(f"`{op!s:.20}` is outside the checker's fragment")
        out = self.value(args[0])
        for e in args[1:]:
            pairs = product(out, self.value(e))
            out = _few(c for a, b in pairs for c in (self._greater(a, b) if op == "max" else self._greater(b, a, True)))
        return out

    def _greater(self, a: Case, b: Case, least: bool = False) -> list[Case]:
        """The cases of the greater of two, or of the least."""
        no, n, d = _combine("-", a, b)
        self._careful += 1
        try:
            below, above = self._literal("<", n, d), self._literal(">=", n, d)
        finally:
            self._careful -= 1
        first, second = (b, a) if least else (a, b)
        return [(disj([no, below]), *first[1:]), (disj([no, above]), *second[1:])]

    def _slope(self, e: Json) -> tuple[Poly, Poly]:
        if self.mode is None:
            raise Refused("a derivative outside a mode")
        still, rates = self.scope.identity(self.mode), self.scope.rates(self.mode)
        cases = still.value(e)
        moving = {**rates, **({"sigma": self.scope.rho} if self.scope.rho is not None else {})}
        timed = self.time is not None and "sigma" in names(cases[0][1])
        if len(cases) > 1 or names(cases[0][2]) & set(moving) or timed:
            raise Beyond("a derivative of what is no polynomial")
        slope = along(cases[0][1], moving)
        return substitute(slope, self.env, self._images), cases[0][2]

    def _is_truth(self, e: Json) -> bool:
        if not isinstance(e, list):
            return isinstance(e, bool)
        op, args = _node(e)
        if op in ("if", "pre"):
            return (self if op == "if" else self.before or self)._is_truth(args[-1])
        if op in ("var", "const"):
            return self.scope.type_of(op, args[0]) == "bool"
        return op in TRUTHS or (op == "let" and self.scope.let(self.mode, args[0])["type"] == "bool")

    def _sides(self, e: Json) -> tuple[Formula, Formula]:
        """Where a truth does not hold, and where it does."""
        self._careful += 1
        try:
            return self.formula(e, True), self.formula(e)
        finally:
            self._careful -= 1

    def _switched(self, e: Json, careful: bool) -> tuple[Formula, Formula]:
        no, yes = self._sides(e)
        if careful and not isinstance(yes, bool):
            raise Beyond("`if` in a domain, a guard or a condition")
        return no, yes

    def formula(self, e: Json, neg: bool = False, closed: bool = False, outer: bool = False) -> Formula:
        """`e`, negated if `neg`, then read as a closed set if `closed`, then negated again if `outer`."""
        spend(5)
        how, flip = (neg, closed, outer), neg is not outer
        if isinstance(e, bool):
            return e is not flip
        op, args = _node(e)
        if op in ("and", "or"):
            return (conj if (op == "and") is not flip else disj)(self.formula(a, *how) for a in args)
        if op == "not":
            return self.formula(args[0], not neg, closed, outer)
        if op == "implies":
            return self.formula(["or", ["not", args[0]], args[1]], *how)
        if op == "if":
            return self._choice(args, how)
        if op in NEGATED:
            return self._compare(op, args, how)
        if op in ("at", "jump", "jumped") and self.mode is not None:
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
        no, yes = self._switched(args[0], how[1] or self._careful > 0)
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


def _few(cases: Iterable[Case]) -> list[Case]:
    """The cases that may apply."""
    out = [c for c in cases if c[0] is not True]
    if len(out) > 64:
        raise Beyond("an expression has too many cases")
    return out


def _chosen(bit: Poly, yes: Poly, no: Poly) -> Poly:
    """One value where a bit is 1, another where it is 0."""
    return add(mul(bit, yes), mul(add(ONE, bit, -1), no))


def _combine(op: str, a: Case, b: Case) -> Case:
    no = disj([a[0], b[0]])
    if op == "*":
        return no, mul(a[1], b[1]), mul(a[2], b[2])
    if op == "/":
        if names(b[2]):
            raise Beyond("a division by a quotient")
        return no, mul(a[1], b[2]), mul(a[2], b[1])
    sign = 1 if op == "+" else -1
    if a[2] == b[2]:
        return no, add(a[1], b[1], sign), a[2]
    return no, add(mul(a[1], b[2]), mul(b[1], a[2]), sign), mul(a[2], b[2])
