"""Expressions of one mode as a list of operations, their derivatives, their values over models, their truth.

A truth is True, False, ("and", f, ...), ("or", f, ...), or (op, place) for `value at place op 0`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from fractions import Fraction
from types import MappingProxyType
from typing import Any

from hacheck import elementary
from hacheck.enclosures import Model, Space, add, bounds
from hacheck.formula import CLOSED, NEGATED, conj, disj
from hacheck.rational import PI, Beyond, number, spend
from hacheck.scope import Scope

Json = Any
Op = tuple[Any, ...]
Truth = Any
Known = Mapping[int, tuple[int | None, int | None]]  # bounds of the values at some places
UNKNOWN: Known = MappingProxyType({})
FUNCTIONS = {"sin", "cos", "tan", "exp", "log", "sqrt", "abs"}


class Tape:
    """Operations, each after those it uses; equal ones are one.

    They speak of an instant while dwelling in a mode, or of one just after an edge into it: then a variable x before
    the jump has the name `pre x`.
    """

    def __init__(self, scope: Scope, mode: str, edge: Json = None) -> None:
        self.scope, self.mode, self.edge, self.prefix = scope, mode, edge, ""
        self.ops: list[Op] = []
        self._known: dict[Op, int] = {}
        self._values: dict[tuple[int, str], tuple[Json, int]] = {}
        self._slopes: dict[tuple[int, str], int] = {}
        self._used: dict[tuple[int, ...], list[int]] = {}

    def put(self, *op: Any) -> int:
        """The place of an operation."""
        if op not in self._known:
            spend(5)
            self._known[op] = len(self.ops)
            self.ops.append(op)
        return self._known[op]

    def _number(self, q: Fraction | int) -> int:
        return self.put("number", Fraction(q))

    def value(self, e: Json) -> int:
        """The place of an expression's value."""
        key = id(e), self.prefix
        if key not in self._values:
            self._values[key] = e, self._value(e)  # e is kept, so that its id is not given away
        return self._values[key][1]

    def _value(self, e: Json) -> int:
        if isinstance(e, str):
            return self._number(number(e))
        if not isinstance(e, list) or not e or not isinstance(e[0], str):
            raise Beyond("a truth where a number is needed")
        op, args = e[0], e[1:]
        if op in ("var", "param") and args[0] in (self.scope.types if op == "var" else self.scope.ranges):
            return self.put("name", (self.prefix if op == "var" else "") + args[0])
        if op in ("time", "pi"):
            return self.put("name", op)
        if op == "const":
            return self.value(self.scope.definition(args[0]))
        if op == "let":
            return self.value(self.scope.let(self.mode, args[0])["expr"])
        if op == "pre":
            return int(self._before(lambda: self.value(args[0])))
        if op == "scale":
            pi = self._power(self.put("name", "pi"), args[1])
            return self.put("*", self.put("*", self._number(number(args[0])), pi), self.value(args[2]))
        if op == "^":
            q = number(args[1])
            if q.denominator != 1:
                raise Beyond("a power whose exponent is no integer")
            return self._power(self.value(args[0]), int(q))
        return self._operation(op, [self.value(a) for a in args])

    def _before(self, found: Callable[[], Any]) -> Any:
        """What is found for the instant before the jump, if one was just made."""
        if self.edge is None or self.prefix:
            return found()
        mode, self.mode, self.prefix = self.mode, self.edge["source"], "pre "
        try:
            return found()
        finally:
            self.mode, self.prefix = mode, ""

    def _operation(self, op: str, args: list[int]) -> int:
        if op == "neg":
            return self.put("*", self._number(-1), args[0])
        if op == "-" and self.ops[args[1]] == ("number", 0):
            return args[0]
        if op == "-":
            return self.put("+", args[0], self._operation("neg", args[1:]))
        if op == "/":
            return self.put("*", args[0], self.put("inverse", args[1]))
        if op in ("+", "*"):
            out = args[0]
            for a in args[1:]:
                out = self.put(op, out, a)
            return out
        if op == "tan":
            return self.put("*", self.put("sin", args[0]), self.put("inverse", self.put("cos", args[0])))
        if op in FUNCTIONS:
            return self.put(op, args[0])
        if op in ("min", "max"):
            return self._extreme(op, args)
        raise Beyond(f"`{op:.20}` along a flow")

    def _extreme(self, op: str, args: list[int]) -> int:
        """`(a + b + |a - b|) / 2` for the greater of two."""
        out = args[0]
        for a in args[1:]:
            apart = self.put("abs", self._operation("-", [out, a]))
            apart = apart if op == "max" else self._operation("neg", [apart])
            out = self.put("*", self._number(Fraction(1, 2)), self.put("+", self.put("+", out, a), apart))
        return out

    def _power(self, base: int, n: int) -> int:
        if type(n) is not int or abs(n) > 64:
            raise Beyond("an exponent is too large")
        out = self._number(1)
        for _ in range(abs(n)):
            out = base if out == self._number(1) else self.put("*", out, base)
        return self.put("inverse", out) if n < 0 else out

    def truth(self, e: Json, neg: bool = False, closed: bool = False) -> Truth:
        """A condition, or its negation, in this mode, then read as a closed set if `closed` (S6)."""
        if isinstance(e, bool):
            return e is not neg
        op, args = (e[0], e[1:]) if isinstance(e, list) and e else (None, [])
        if op in ("and", "or"):
            return (conj if (op == "and") is not neg else disj)(self.truth(a, neg, closed) for a in args)
        if op == "not":
            return self.truth(args[0], not neg, closed)
        if op == "implies":
            return self.truth(["or", ["not", args[0]], args[1]], neg, closed)
        if op in NEGATED:
            op = NEGATED[op] if neg else op
            place = self._operation("-", [self.value(a) for a in args])
            return (CLOSED.get(op, op) if closed else op, place) if (op, closed) != ("!=", True) else True
        if op == "at":
            return (args[0] == self.mode) is not neg
        if op in ("jump", "jumped"):
            return (self.edge is not None and (op == "jumped" or args[0] == self.edge["name"])) is not neg
        if op == "pre":
            return self._before(lambda: self.truth(args[0], neg, closed))
        if op in ("let", "const"):
            found = self.scope.let(self.mode, args[0])["expr"] if op == "let" else self.scope.definition(args[0])
            return self.truth(found, neg, closed)
        raise Beyond(f"`{op!s:.20}` along a flow")

    def slope(self, place: int, v: str) -> int | None:
        """The place of a partial derivative; None where it is 0."""
        for i in self.used((place,)):
            if (i, v) not in self._slopes:
                found = self._slope(i, v)
                self._slopes[i, v] = -1 if found is None else found
        found = self._slopes[place, v]
        return None if found < 0 else found

    def _slope(self, i: int, v: str) -> int | None:
        op, *args = self.ops[i]
        if op == "name" and args[0] == v:
            return self._number(1)
        if op in ("name", "number"):
            return None
        inner = [self._slopes[a, v] for a in args]
        if op == "+":
            found = [s for s in inner if s >= 0]
            return None if not found else found[0] if len(found) == 1 else self.put("+", *found)
        if op == "*":
            found = [self.times(s, other) for s, other in zip(inner, reversed(args), strict=True) if s >= 0]
            return None if not found else found[0] if len(found) == 1 else self.put("+", *found)
        return None if inner[0] < 0 else self.times(inner[0], self._outer(op, args[0], i))

    def times(self, a: int, b: int) -> int:
        """The place of a product."""
        one = self._number(1)
        return b if a == one else a if b == one else self.put("*", a, b)

    def _outer(self, op: str, a: int, here: int) -> int:
        """The derivative of a function at `a`, its value being `here`."""
        if op == "inverse":
            return self._operation("neg", [self.put("*", here, here)])
        if op == "sin":
            return self.put("cos", a)
        if op == "cos":
            return self._operation("neg", [self.put("sin", a)])
        if op == "sqrt":
            return self.put("*", self._number(Fraction(1, 2)), self.put("inverse", here))
        return here if op == "exp" else self.put("inverse", a) if op == "log" else self.put("sign", a)

    def used(self, places: tuple[int, ...]) -> list[int]:
        """The operations that some need, in order."""
        if places not in self._used:
            found, waiting = set(places), list(places)
            while waiting:
                op, *args = self.ops[waiting.pop()]
                new = [a for a in args if op not in ("name", "number") and a not in found]
                found.update(new)
                waiting += new
            self._used[places] = sorted(found)
        return self._used[places]

    def taken(self, source: Tape, place: int, reset: set[str]) -> int | None:
        """The place of a quantity of another tape; None where it reads what is reset on the way."""
        found: dict[int, int] = {}
        for i in source.used((place,)):
            op, *args = source.ops[i]
            if op == "name" and args[0] in reset:
                return None
            found[i] = self.put(op, *args) if op in ("name", "number") else self.put(op, *(found[a] for a in args))
        return found[place]

    def exactly(self, place: int, sides: Mapping[str, tuple[Fraction, Fraction]]) -> tuple[Fraction, Fraction] | None:
        """The exact range of a sum of multiples of names over a box, by interval arithmetic; None for other forms."""
        found: dict[int, tuple[Fraction, Fraction]] = {}
        for i in self.used((place,)):
            op, *args = self.ops[i]
            if op == "number" or (op == "name" and args[0] in sides):
                found[i] = (args[0], args[0]) if op == "number" else sides[args[0]]
            elif op in ("+", "*") and all(a in found for a in args):
                (a, b), (c, d) = (found[k] for k in args)
                ends = (a + c, b + d) if op == "+" else (a * c, a * d, b * c, b * d)
                found[i] = min(ends), max(ends)
        return found.get(place)

    def values(self, places: Iterable[int], env: Mapping[str, Model], space: Space) -> dict[int, Model]:
        """The values of operations, and of all they need, over models of the variables, params and time."""
        out: dict[int, Model] = {}
        waves: dict[int, tuple[Model, Model]] = {}
        for i in self.used(tuple(places)):
            op, *args = self.ops[i]
            if op == "number":
                out[i] = space.number(args[0])
            elif op == "name":
                out[i] = space.number(*PI) if args[0] == "pi" else env[args[0]]
            elif op == "+":
                out[i] = add(out[args[0]], out[args[1]])
            elif op == "*":
                out[i] = space.mul(out[args[0]], out[args[1]])
            elif op in ("sin", "cos"):
                if args[0] not in waves:
                    waves[args[0]] = elementary.waves(space, out[args[0]])
                out[i] = waves[args[0]][op == "cos"]
            else:
                out[i] = _FUNCTIONS[op](space, out[args[0]])
        return out


_FUNCTIONS = {
    "inverse": elementary.inverse, "exp": elementary.exponential, "log": elementary.log, "sqrt": elementary.root,
    "abs": elementary.magnitude, "sign": elementary.sign,
}  # fmt: skip


def holds(f: Truth, values: Mapping[int, Model], known: Known = UNKNOWN) -> bool | None:
    """Is a condition true for all values, for none (False), or is neither known? Some values have known bounds."""
    if isinstance(f, bool):
        return f
    if f[0] in ("and", "or"):
        found = [holds(g, values, known) for g in f[1:]]
        decisive = f[0] == "or"
        return decisive if decisive in found else None if None in found else not decisive
    low, high = bounds(values[f[1]])
    least, most = known.get(f[1], (None, None))
    return _signs(f[0], low if least is None else max(low, least), high if most is None else min(high, most))


def _signs(op: str, low: int, high: int) -> bool | None:
    if op in (">", ">=", "!="):
        found = _signs(NEGATED[op], low, high)
        return None if found is None else not found
    if op == "==":
        return True if low == high == 0 else False if low > 0 or high < 0 else None
    return True if high < 0 or (op == "<=" and high == 0) else False if low > 0 or (op == "<" and low == 0) else None


def closed_bounds(f: Truth) -> dict[int, tuple[int | None, int | None]]:
    """What a condition, read as closed, says of values by themselves."""
    members = f[1:] if not isinstance(f, bool) and f[0] == "and" else (f,)
    ends = {"<": (None, 0), "<=": (None, 0), ">": (0, None), ">=": (0, None), "==": (0, 0)}
    return {g[1]: ends[g[0]] for g in members if not isinstance(g, bool) and g[0] in ends}


def literals(f: Truth) -> Iterator[tuple[str, int]]:
    """All comparisons of a condition with zero."""
    if not isinstance(f, bool):
        yield from (x for g in f[1:] for x in literals(g)) if f[0] in ("and", "or") else (f,)


def places(f: Truth) -> list[int]:
    """The operations that a condition reads."""
    return [place for _, place in literals(f)]
