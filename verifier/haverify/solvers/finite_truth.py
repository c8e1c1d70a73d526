"""Truths and values of expressions about cells and relations, for given values of their bound names.

Truths are Kleene's: what something undefined decides is None, whatever stands beside it. A quantifier whose body has
no other is decided for all its cells at once, on integers with one bit a cell.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from functools import reduce
from operator import eq, ge, gt, le, lt, ne
from typing import Any

from haverify.model.expression import Expr, operands
from haverify.solvers.finite_world import Cell, NotFiniteError, TooMuchError, Value, World
from haverify.text.record import record

Env = Mapping[str, Cell]
Truth = bool | None

QUANTIFIERS = ("forall", "exists", "unique")
COMPARED: dict[str, Callable[[Any, Any], bool]] = {"==": eq, "!=": ne, "<": lt, "<=": le, ">": gt, ">=": ge}
_TRUTHS = frozenset(
    {"true", "false", "and", "or", "not", "implies", "defined", "unique_rule", "related", *QUANTIFIERS, *COMPARED}
)
_LONGEST = 60_000  # bits of a number
USUAL = 4_000_000  # steps that one goal may take, some two microseconds each


@record
class Lanes:
    """Bit i says whether a truth holds (`yes`), or does not (`no`), for cell i of a set of `count`."""

    yes: int
    no: int
    count: int

    @property
    def everywhere(self) -> int:
        """All bits."""
        return (1 << self.count) - 1

    def flipped(self) -> Lanes:
        """The negation."""
        return Lanes(self.no, self.yes, self.count)

    def joined(self, other: Lanes) -> Lanes:
        """The conjunction."""
        return Lanes(self.yes & other.yes, self.no | other.no, self.count)


def lanes_of(truths: Sequence[Truth]) -> Lanes:
    """The truths of all cells as bits."""
    yes = "".join("1" if t is True else "0" for t in reversed(truths))
    no = "".join("1" if t is False else "0" for t in reversed(truths))
    return Lanes(int(yes or "0", 2), int(no or "0", 2), len(truths))


def every(truths: Iterable[Truth]) -> Truth:
    """The conjunction."""
    found: Truth = True
    for t in truths:
        if t is False:
            return False
        found = found if t else None
    return found


def opposite(t: Truth) -> Truth:
    """The negation."""
    return None if t is None else not t


class Finite:
    """An evaluator that remembers what quantifiers and terms came to; `steps` bounds its work."""

    def __init__(self, world: World, steps: int = USUAL) -> None:
        self.world, self.steps = world, steps
        self._free: dict[int, tuple[Expr, frozenset[str]]] = {}  # with the expression: an id is reused once it is gone
        self._nested: dict[int, tuple[Expr, bool]] = {}
        self._known: dict[Any, Any] = {}

    def _spend(self, steps: int) -> None:
        self.steps -= steps
        if self.steps < 0:
            raise TooMuchError("there are too many combinations of cells to try")

    def free(self, e: Expr) -> frozenset[str]:
        """The bound names that an expression reads from outside."""
        if id(e) not in self._free:
            names = frozenset({e.name}) if e.op == "bound" else frozenset().union(*map(self.free, operands(e)))
            self._free[id(e)] = e, names - {e.name} if e.op in QUANTIFIERS else names
        return self._free[id(e)][1]

    def _has_quantifier(self, e: Expr) -> bool:
        if id(e) not in self._nested:
            self._nested[id(e)] = e, e.op in QUANTIFIERS or any(map(self._has_quantifier, operands(e)))
        return self._nested[id(e)][1]

    # ---- truths ----------------------------------------------------------------------

    def truth(self, e: Expr, env: Env) -> Truth:
        """True, false, or None where something undefined decides.

        Raises
        ------
        NotFiniteError       where values of params, runs or other things decide, or there is too much to try
        """
        self._spend(1)
        special = _SPECIAL.get(e.op)
        if special is not None:
            return special(self, e, env)
        if e.op in COMPARED:
            a, b = (self.value(c, env) for c in e.children)
            return None if a is None or b is None else COMPARED[e.op](a, b)
        raise NotFiniteError(f"`{e.op}` in a goal about rules, relations and constants")

    def _quantified(self, e: Expr, env: Env) -> Truth:
        key = id(e), *(env[n] for n in sorted(self.free(e)))
        if key not in self._known:
            self._known[key] = _decided(e.op, self.body(e, env))
        found: Truth = self._known[key]
        return found

    def body(self, e: Expr, env: Env) -> Lanes:
        """For which of its cells the body of a quantifier holds."""
        name, of, (body,) = e.name, str(e.args[1]), e.children
        if not self._has_quantifier(body):
            return self.lanes(body, env, name, of)
        return lanes_of([self.truth(body, {**env, name: c}) for c in self.world.cells(of).cells])

    def lanes(self, e: Expr, env: Env, name: str, of: str) -> Lanes:
        """For which cells of a set, as the value of `name`, a truth without quantifiers holds."""
        cells = self.world.cells(of).cells
        self._spend(1 + len(cells) // 2000)
        if name not in self.free(e):
            t = self.truth(e, env)
            everywhere = (1 << len(cells)) - 1
            return Lanes(everywhere if t is True else 0, everywhere if t is False else 0, len(cells))
        if e.op in ("and", "or", "not", "implies"):
            return _joined(e.op, [self.lanes(c, env, name, of) for c in e.children])
        if e.op in ("==", "!=") and any(name not in self.free(c) for c in e.children):
            same = self._same(e, env, name, of)
            return same if e.op == "==" else same.flipped()
        key = "lanes", id(e), name, of, *((n, env[n]) for n in sorted(self.free(e) - {name}))
        if key not in self._known:
            self._known[key] = lanes_of([self.truth(e, {**env, name: c}) for c in cells])
        found: Lanes = self._known[key]
        return found

    def _same(self, e: Expr, env: Env, name: str, of: str) -> Lanes:
        """Where the side that reads `name` equals the one that does not."""
        a, b = e.children
        fixed, moving = (a, b) if name not in self.free(a) else (b, a)
        wanted = self.value(fixed, env)
        places, known = self._places(moving, env, name, of)
        yes = places.get(wanted, 0)
        count = len(self.world.cells(of).cells)
        return Lanes(0, 0, count) if wanted is None else Lanes(yes, known & ~yes, count)

    def _places(self, e: Expr, env: Env, name: str, of: str) -> tuple[dict[Value, int], int]:
        """For which cells a term has each of its values, and for which it has one."""
        key = "places", id(e), name, of, *((n, env[n]) for n in sorted(self.free(e) - {name}))
        if key not in self._known:
            values = [self.value(e, {**env, name: c}) for c in self.world.cells(of).cells]
            bits: dict[Value, int] = {}
            for k, v in enumerate(values):
                if v is not None:
                    bits[v] = bits.get(v, 0) | 1 << k
            self._spend(len(bits) * (1 + len(values) // 2000))
            self._known[key] = bits, lanes_of([v is not None for v in values]).yes
        found: tuple[dict[Value, int], int] = self._known[key]
        return found

    # ---- values ----------------------------------------------------------------------

    def value(self, e: Expr, env: Env) -> Value:
        """The value of an expression, None where it is undefined; raises as `truth` does."""
        self._spend(1)
        if e.op == "num":
            return Fraction(e.args[0])  # type: ignore[arg-type]
        if e.op in _TRUTHS:
            return self.truth(e, env)
        found = _VALUES.get(e.op)
        if found is not None:
            return found(self, e, env)
        return self._number(e, env)

    def _field(self, e: Expr, env: Env) -> Value:
        cell = self.value(e.children[0], env)
        return self.world.part(cell, str(e.args[1])) if isinstance(cell, tuple) else None

    def _next(self, e: Expr, env: Env) -> Value:
        cell = self.value(e.children[0], env)
        return self.world.steps(e.name)[cell].target if isinstance(cell, tuple) else None

    def _applied(self, e: Expr, env: Env) -> Value:
        value = self.value(e.children[0], env)
        found = self.world.images(e.name).get(value, ()) if isinstance(value, str) else ()
        return found[0] if len(found) == 1 else None

    def _chosen(self, e: Expr, env: Env) -> Value:
        c, a, b = e.children
        chosen = self.truth(c, env)
        return None if chosen is None else self.value(a if chosen else b, env)

    def _number(self, e: Expr, env: Env) -> Fraction | None:
        """Exact arithmetic."""
        op, given = e.op, [self.value(c, env) for c in e.children]
        if op == "scale" and e.args[1] == 0:
            op, given = "*", [Fraction(e.args[0]), *given]  # type: ignore[arg-type]
        if op not in _ARITHMETIC or not given:
            raise NotFiniteError(f"`{e.op}` in a goal about rules, relations and constants")
        numbers = [v for v in given if isinstance(v, Fraction)]
        return _ARITHMETIC[op](*numbers) if len(numbers) == len(given) else None

    def _defined(self, e: Expr, env: Env) -> Truth:
        return self.value(e.children[0], env) is not None

    def _unique(self, e: Expr, env: Env) -> Truth:
        cell = self.value(e.children[0], env)
        return len(self.world.steps(e.name)[cell].results) == 1 if isinstance(cell, tuple) else None

    def _related(self, e: Expr, env: Env) -> Truth:
        value = self.value(e.children[0], env)
        return None if value is None else value in self.world.images(e.name)

    def _if(self, e: Expr, env: Env) -> Truth:
        c, a, b = e.children
        chosen = self.truth(c, env)
        return None if chosen is None else self.truth(a if chosen else b, env)

    def _and(self, e: Expr, env: Env) -> Truth:
        return every(self.truth(c, env) for c in e.children)

    def _or(self, e: Expr, env: Env) -> Truth:
        return opposite(every(opposite(self.truth(c, env)) for c in e.children))

    def _not(self, e: Expr, env: Env) -> Truth:
        return opposite(self.truth(e.children[0], env))

    def _implies(self, e: Expr, env: Env) -> Truth:
        a, b = e.children
        return opposite(every((self.truth(a, env), opposite(self.truth(b, env)))))


_SPECIAL: dict[str, Callable[[Finite, Expr, Env], Truth]] = {
    "true": lambda f, e, env: True, "false": lambda f, e, env: False, "and": Finite._and, "or": Finite._or,
    "not": Finite._not, "implies": Finite._implies, "if": Finite._if, "defined": Finite._defined,
    "unique_rule": Finite._unique, "related": Finite._related, **dict.fromkeys(QUANTIFIERS, Finite._quantified),
}  # fmt: skip

_VALUES: dict[str, Callable[[Finite, Expr, Env], Value]] = {
    "bound": lambda f, e, env: env[e.name], "const": lambda f, e, env: f.world.constant(e.name),
    "param": lambda f, e, env: f.world.param(e.name), "sym": lambda f, e, env: f.world.sym(e.name, str(e.args[1])),
    "cell": lambda f, e, env: (e.name, str(e.args[1])), "field": Finite._field, "next": Finite._next,
    "apply": Finite._applied, "if": Finite._chosen,
}  # fmt: skip


def _joined(op: str, parts: list[Lanes]) -> Lanes:
    if op == "not":
        return parts[0].flipped()
    if op == "implies":
        return parts[0].joined(parts[1].flipped()).flipped()
    if op == "or":
        return reduce(Lanes.joined, [p.flipped() for p in parts]).flipped()
    return reduce(Lanes.joined, parts)


def _decided(kind: str, body: Lanes) -> Truth:
    """A quantifier, given where its body holds."""
    if kind == "forall":
        return False if body.no else True if body.yes == body.everywhere else None
    if kind == "exists":
        return True if body.yes else False if body.no == body.everywhere else None
    if body.yes.bit_count() > 1 or body.no == body.everywhere:
        return False
    return True if body.yes and body.yes | body.no == body.everywhere else None


def _short(q: Fraction) -> Fraction:
    if q.numerator.bit_length() + q.denominator.bit_length() > _LONGEST:
        raise NotFiniteError("a number is too long")
    return q


def _power(a: Fraction, k: Fraction) -> Fraction | None:
    if k.denominator != 1 or abs(k) * (a.numerator.bit_length() + a.denominator.bit_length()) > _LONGEST:
        raise NotFiniteError("a power with no integer, or a large one, as exponent")
    return None if a == 0 and k < 0 else Fraction(a ** int(k))


def _total(*given: Fraction) -> Fraction:
    return reduce(lambda a, b: _short(a + b), given)


def _product(*given: Fraction) -> Fraction:
    return reduce(lambda a, b: _short(a * b), given)


_ARITHMETIC: dict[str, Callable[..., Fraction | None]] = {
    "+": _total, "*": _product, "-": lambda a, b: _short(a - b), "neg": lambda a: -a,
    "/": lambda a, b: _short(a / b) if b else None, "^": _power, "abs": abs, "min": lambda *v: min(v),
    "max": lambda *v: max(v), "clamp": lambda x, low, high: min(max(x, low), high),
}  # fmt: skip
