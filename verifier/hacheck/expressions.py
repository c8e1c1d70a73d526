"""What core expressions mean at an instant: values as cases of quotients of polynomials, truths as formulas."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import cache
from itertools import product
from typing import TYPE_CHECKING, Any

from hacheck import bernstein
from hacheck.formula import CLOSED, NEGATED, Formula, conj, disj, literal
from hacheck.polynomial import (
    ONE,
    ZERO,
    Env,
    Poly,
    add,
    const,
    constant,
    derivative,
    mul,
    names,
    power,
    scale,
    substitute,
    total,
    var,
)
from hacheck.rational import Beyond, Refused, number, spend

if TYPE_CHECKING:
    from hacheck.scope import Scope

Json = Any
Case = tuple[Formula, Poly, Poly]  # (the case does not apply, numerator, denominator)
TRUTHS = {"and", "or", "not", "implies", "at", "jump", "jumped", "stuck", *NEGATED}
EVENTS = {"jump", "jumped", "pre", "stuck"}
MANY = (1, 10**6)
ARITY = {  # the fewest and the most operands
    **dict.fromkeys(("pi", "time", "jumped", "stuck"), (0, 0)),
    **dict.fromkeys(("const", "param", "input", "var", "let", "neg", "abs", "not", "at", "jump", "pre", "der"), (1, 1)),
    **dict.fromkeys(("sin", "cos", "exp"), (1, 1)),
    **dict.fromkeys(("sym", "-", "/", "^", "implies", *NEGATED), (2, 2)),
    **dict.fromkeys(("scale", "clamp", "if"), (3, 3)), **dict.fromkeys(("+", "*", "min", "max", "and", "or"), MANY),
}  # fmt: skip


def nodes(value: Json) -> Iterator[list[Json]]:
    """All lists inside a JSON value that begin with a string, outermost first."""
    stack = [value]
    while stack:
        item = stack.pop()
        if type(item) is list and item and type(item[0]) is str:
            yield item
        inside = item[::-1] if type(item) is list else item.values() if type(item) is dict else ()
        stack += [x for x in inside if type(x) is list or type(x) is dict]


def well_formed(value: Json, events: bool) -> None:
    """Refuse operators with a wrong number of operands, and what just happened where that has no meaning."""
    for n in nodes(value):
        least, most = ARITY.get(n[0], (0, 10**6))
        if not least <= len(n) - 1 <= most:
            raise Refused(f"`{n[0]:.20}` has a wrong number of operands")
        inner = n[0] in ("pre", "der") and any(m[0] in EVENTS for m in nodes(n[1:]))
        if inner or (n[0] in EVENTS and not events):
            raise Beyond("`pre`, `jump`, `jumped` or `stuck` where nothing has just happened")


class Instant:
    """A mode, values of its variables as polynomials, and what happened just before.

    A formula is true only where everything in it is defined; where `exact`, so is its negation.
    """

    def __init__(self, scope: Scope, mode: str | None, env: dict[str, Poly], *, edge: str | None = None,
                 before: Instant | None = None) -> None:  # fmt: skip
        self.scope, self.mode, self.env, self.edge, self.before = scope, mode, Env(env), edge, before
        self._lets: dict[tuple[str, bool], list[Case]] = {}
        self._slopes: dict[tuple[str, bool], list[Case]] = {}
        self._exact = False

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
        """The cases of a number, which are disjoint; a truth counts as 0 or 1."""
        spend(5)
        if isinstance(e, (str, bool)):
            return _number(e) if isinstance(e, str) else [(False, const(e), ONE)]
        op, args = _node(e)
        if op in _LEAVES:
            return self._leaf(op, args)
        if op == "pre":
            return (self.before or self).value(args[0])
        if op == "der":
            if (at := (str(args[0]), self._exact)) not in self._slopes:
                self._slopes[at] = [(False, *self._slope(args[0]))]
            return self._slopes[at]
        if self._is_truth(e):
            bit = self._bit(e)
            if bit is not None:
                return [(False, bit, ONE)]
            return _few([(self.condition(e, True), ONE, ONE), (self.condition(e), ZERO, ONE)])
        return self._arithmetic(op, args) if op in _ARITHMETIC else self._switch(op, args)

    def _bit(self, e: Json) -> Poly | None:
        """A truth made of truth variables, as a polynomial in them; None for others."""
        op, args = _node(e) if isinstance(e, list) else ("", [])
        if not op or op in ("var", "const"):
            return self.poly(e) if isinstance(e, bool) or self._is_truth(e) else None
        if op == "implies":
            op, args = "or", [["not", args[0]], args[1]]
        found = [self._bit(a) for a in args] if op in ("not", "and", "or", "if", "==", "!=") else []
        bits = [b for b in found if b is not None]
        if not bits or len(bits) < len(found):
            return None
        if op in ("if", "==", "!="):
            other = bits[2] if op == "if" else add(ONE, bits[1], -1)
            return _chosen(bits[0], other, bits[1]) if op == "!=" else _chosen(bits[0], bits[1], other)
        out = ONE
        for b in bits:
            out = mul(out, b if op == "and" else add(ONE, b, -1))
        return add(ONE, out, -1) if op == "or" else out

    def _leaf(self, op: str, args: list[Json]) -> list[Case]:
        scope = self.scope
        if op == "const":
            return scope.constant(args[0])
        if op == "let":
            key = args[0], self._exact
            if key not in self._lets:
                self._lets[key] = self.value(scope.let(self.mode, args[0])["expr"])
            return self._lets[key]
        if op == "time" and self.mode is not None:
            return [(False, var("time"), ONE) if scope.rho is None else (False, var("@sigma"), scope.rho)]
        if op == "input":
            return [(False, scope.input(str(args[0])), ONE)]
        if op in ("pi", "sym"):
            return [(False, var("pi") if op == "pi" else const(scope.ordinal(*args)), ONE)]
        known = self.env if op == "var" or (op == "param" and args[0] in self.env) else scope.params
        if op not in ("var", "param") or args[0] not in known:
            raise Beyond(f"there is no {op} {args!a:.40} here")
        return [(False, known[args[0]], ONE)]

    def _arithmetic(self, op: str, args: list[Json]) -> list[Case]:
        if op == "scale":
            q, k, e = args
            pi = power(var("pi"), abs(k))
            return self._arithmetic("*", [e, q]) if not k else [
                (no, mul(scale(n, number(q)), pi), d) if k > 0 else (no, scale(n, number(q)), mul(d, pi))
                for no, n, d in self.value(e)]  # fmt: skip
        out = self.value(args[0])
        if op == "neg":
            return [(no, scale(n, -1), d) for no, n, d in out]
        if op == "^":
            k = constant(self.poly(args[1]))
            if k is None or k.denominator != 1 or (k <= 0 and not all(constant(d) for _, _, d in out)):
                raise Beyond("powers with other exponents than integers, or of quotients")
            raised = [(no, power(n, abs(int(k))), power(d, abs(int(k)))) for no, n, d in out]
            return raised if k >= 0 else [(no, d, n) for no, n, d in raised]
        others = [self.value(e) for e in args[1:]]
        if op == "+" and all(len(v) == 1 and v[0][0] is False and v[0][2] is ONE for v in (out, *others)):
            return [(False, total([(1, v[0][1]) for v in (out, *others)]), ONE)]
        for v in others:
            out = _few([_combine(op, a, b) for a, b in product(out, v)])
        return out

    def _switch(self, op: str, args: list[Json]) -> list[Case]:
        if op == "if":
            yes, no = self._test(args[0])
            return _few((disj([m, n]), *v) for m, e in ((no, args[1]), (yes, args[2])) if m is not True
                        for n, *v in self.value(e))  # fmt: skip
        if op == "abs":
            return _few(c for no, n, d in self.value(args[0]) for c in self._greater((no, n, d), (no, scale(n, -1), d)))
        if op == "clamp":
            return self.value(["min", ["max", args[0], args[1]], args[2]])
        if op in ("sin", "cos", "exp", "log", "sqrt"):
            return [(False, self.scope.function(op, self.poly(args[0])), ONE)]
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
        first, second = (b, a) if least else (a, b)
        below, above = self._literal("<", n, d, True), self._literal(">=", n, d, True)
        return [(disj([no, below]), *first[1:]), (disj([no, above]), *second[1:])]

    def _slope(self, e: Json) -> tuple[Poly, Poly]:
        if self.mode is None:
            raise Refused("a derivative outside a mode")
        rates = {**self.scope.rates(self.mode), "@sigma": self.scope.rho or ZERO, "time": ONE}
        (_, n, d), *others = self.scope.identity(self.mode).value(e)
        if others or names(d) & rates.keys():
            raise Beyond("a derivative of what is no polynomial")
        return substitute(total((1, mul(derivative(n, v), r)) for v, r in rates.items()), self.env), d

    def _is_truth(self, e: Json) -> bool:
        if not isinstance(e, list):
            return isinstance(e, bool)
        op, args = _node(e)
        if op in ("if", "pre"):
            return (self if op == "if" else self.before or self)._is_truth(args[-1])
        if op == "var":
            return self.scope.types.get(args[0]) == "bool"
        if op == "const":
            return bool(self.scope.constants.get(args[0], {}).get("type") == "bool")
        return op in TRUTHS or (op == "let" and self.scope.let(self.mode, args[0])["type"] == "bool")

    def condition(self, e: Json, neg: bool = False, closed: bool = False) -> Formula:
        """A domain, guard or test, or its negation; exact: everything in it must certainly be defined."""
        before, self._exact = self._exact, True
        try:
            return self.formula(e, neg, closed)
        finally:
            self._exact = before

    def _test(self, e: Json) -> tuple[Formula, Formula]:
        """Where a condition of `if` holds, and where not."""
        yes, no = self.condition(e), self.condition(e, True)
        if self._exact and not isinstance(yes, bool):
            raise Beyond("`if` in a domain, a guard or a condition")
        return yes, no

    def formula(self, e: Json, neg: bool = False, closed: bool = False) -> Formula:
        """`e`, or its negation, then read as a closed set if `closed` (S6)."""
        spend(5)
        if isinstance(e, bool):
            return e is not neg
        op, args = _node(e)
        if op in ("and", "or"):
            return (conj if (op == "and") is not neg else disj)(self.formula(a, neg, closed) for a in args)
        if op == "not":
            return self.formula(args[0], not neg, closed)
        if op == "implies":
            flips = zip(args, (not neg, neg), strict=True)
            return (conj if neg else disj)(self.formula(a, n, closed) for a, n in flips)
        if op == "if":
            yes, no = self._test(args[0])
            return conj(disj([m, self.formula(a, neg, closed)]) for m, a in ((no, args[1]), (yes, args[2]))
                        if m is not True)  # fmt: skip
        if op in NEGATED:
            return self._compare(op, args, neg, closed)
        if op in ("at", "jump", "jumped") and self.mode is not None:
            now = args[0] == (self.mode if op == "at" else self.edge) if args else self.edge is not None
            return now is not neg
        if op == "pre":
            return (self.before or self).formula(args[0], neg, closed)
        if op == "let" and self._is_truth(e):
            return self.formula(self.scope.let(self.mode, args[0])["expr"], neg, closed)
        if op in ("var", "const") and self._is_truth(e):
            return literal("<=" if neg else ">=", add(self.poly(e), const(0 if neg else 1), -1))
        raise Beyond(f"`{op!s:.20}` is outside the checker's fragment")

    def _compare(self, op: str, args: list[Json], neg: bool, closed: bool) -> Formula:
        a, b = args
        if op in ("==", "!=") and self._is_truth(a) and self._is_truth(b):
            if closed and neg is (op == "=="):
                return True
            same = ["or", ["and", a, b], ["and", ["not", a], ["not", b]]]
            return self.formula(same, neg is not (op == "!="), closed)
        op = NEGATED[op] if neg else op
        if closed and op == "!=":
            return True
        op = CLOSED[op] if closed else op
        low, high = (b, a) if op[0] == ">" else (a, b)
        pairs = product(*(self._greatest(e) if op[0] in "<>" else [[c] for c in self.value(e)] for e in (low, high)))
        op = op.replace(">", "<")
        held = [disj([self._between(op, x, y) for y in ys]) for xs, ys in pairs for x in xs]
        return conj([*held, *(self.partial(args, set()) if self.scope.has_functions and not self._exact else ())])

    def partial(self, e: Json, seen: set[str]) -> Iterator[Formula]:
        """The roots and logarithms that an expression reads are defined, also where their values are of no account."""
        for op, *args in nodes(e):
            spend(2)
            if op in ("sqrt", "log"):
                yield literal(">=" if op == "sqrt" else ">", self.poly(args[0]))
            elif op == "let" and args[0] not in seen:
                seen.add(args[0])
                yield from self.partial(self.scope.let(self.mode, args[0])["expr"], seen)

    def _greatest(self, e: Json) -> list[list[Case]]:
        """The cases of a number, each as the greatest of some: of x and -x where it is an absolute value."""
        if isinstance(e, list) and e[:1] == ["abs"]:
            return [[(no, n, d), (no, scale(n, -1), d)] for no, n, d in self.value(e[1])]
        return [[c] for c in self.value(e)]

    def _between(self, op: str, x: Case, y: Case) -> Formula:
        no, n, d = _combine("-", x, y)
        found = self._literal(op, n, d, self._exact)
        return found if no is False else disj([no, found])

    def _literal(self, op: str, n: Poly, d: Poly, exact: bool) -> Formula:
        """`n / d op 0` and `d != 0`."""
        if d is ONE or d == ONE:
            return literal(op, n)
        for sign, q in ((">", n), ("<", scale(n, -1))):
            if bernstein.certain(sign, d, self.scope.box):
                return literal(op, q)
        if exact:
            raise Beyond("a division, perhaps by zero, in a domain, a guard or a condition")
        return conj([literal(op, mul(n, d)), literal("!=", d)])


_LEAVES = {"const", "let", "var", "param", "input", "time", "pi", "sym"}
_ARITHMETIC = {"+", "-", "neg", "*", "/", "^", "scale"}


def _node(e: Json) -> tuple[str, list[Json]]:
    if not isinstance(e, list) or not e or not isinstance(e[0], str):
        raise Refused("an expression is malformed")
    return e[0], e[1:]


@cache
def _number(text: str) -> list[Case]:
    return [(False, const(number(text)), ONE)]


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
    no = disj([a[0], b[0]]) if a[0] or b[0] else False
    if op == "*":
        return no, mul(a[1], b[1]), mul(a[2], b[2])
    if op == "/":
        if not constant(b[2]):
            raise Beyond("a division by a quotient")
        return no, mul(a[1], b[2]), mul(a[2], b[1])
    sign = 1 if op == "+" else -1
    if a[2] == b[2]:
        return no, add(a[1], b[1], sign), a[2]
    return no, add(mul(a[1], b[2]), mul(b[1], a[2]), sign), mul(a[2], b[2])
