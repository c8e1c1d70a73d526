"""Expressions in a discrete state: numbers are sums of clocks and a constant, truths are formulas about clocks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any

from haverify.analyses.networks.zones import Formula, conjunction, disjunction, negation
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import holder, record

Json = Any
State = tuple[Any, ...]
Linear = tuple[Fraction, dict[int, Fraction]]
TIME = "time"
OPPOSITE = {"<": ">=", "<=": ">", ">": "<=", ">=": "<", "==": "!=", "!=": "=="}
MIRRORED = {"<": ">", "<=": ">=", ">": "<", ">=": "<=", "==": "==", "!=": "!="}
CLOSED = {"<": "<=", ">": ">="}
LARGEST = 1 << 45


class ScaleError(Exception):
    """A bound is no whole number of the unit; `factor` is how much finer the unit has to be."""

    def __init__(self, factor: int) -> None:
        super().__init__(factor)
        self.factor = factor


@record
class Event:
    """The jump just made: what it is known by, and the discrete state before it."""

    names: tuple[str, ...]
    before: State


@holder
class Terms:
    """What expressions mean: where each name is found in a state, and how fast each clock runs.

    `slots`: positions of modes (by `part.`) and discrete variables in a state; `clocks`: numbers of clocks; `rates`:
    their rates; `modes`: (position, mode) of each `part.mode`. `scale`: units of time in a second.
    """

    scale: int
    slots: Mapping[str, int]
    clocks: Mapping[str, int]
    rates: Mapping[str, Fraction]
    modes: Mapping[str, tuple[int, str]]
    stuck: Any = None  # (state) -> Formula

    def number(self, e: Json, s: State) -> Fraction:
        """The value of an expression that no clock has a part in."""
        q, clocks = self.linear(e, s, None)
        if clocks:
            raise OutsideFragmentError("a clock stands where a number is needed (in a product, a reset or a rate)")
        return q

    def linear(self, e: Json, s: State, event: Event | None) -> Linear:
        """A constant, and how often each clock (counted in the unit of time) is added."""
        if isinstance(e, str):
            return Fraction(e), {}
        op, args = (e[0], e[1:]) if isinstance(e, list) else ("bool", [])
        if op in ("var", TIME):
            return self._read(TIME if op == TIME else args[0], s)
        if op == "scale":
            if args[1] != 0:
                raise OutsideFragmentError("a quantity in multiples of pi")
            return _times(Fraction(args[0]), self.linear(args[2], s, event))
        if op in _ARITHMETIC:
            joined: Linear = _ARITHMETIC[op]([self.linear(a, s, event) for a in args])
            return joined
        if op in _FUNCTIONS:
            return Fraction(_FUNCTIONS[op]([self._plain(op, a, s, event) for a in args])), {}
        if op == "if":
            return self.linear(args[1] if self.decided(args[0], s, event) else args[2], s, event)
        if op == "pre":
            return (self.number(args[0], event.before), {}) if event else self.linear(args[0], s, None)
        return Fraction(self.decided(e, s, event)), {}

    def _plain(self, op: str, e: Json, s: State, event: Event | None) -> Fraction:
        q, clocks = self.linear(e, s, event)
        if clocks:
            raise OutsideFragmentError(f"`{op}` of a clock")
        return q

    def _read(self, name: str, s: State) -> Linear:
        if name in self.clocks:
            return Fraction(0), {self.clocks[name]: self.rates[name] / self.scale}
        if name == TIME:
            raise OutsideFragmentError("`time` in a system is tracked only up to a horizon: give the claim a `within`")
        if self.slots.get(name, len(s)) >= len(s):
            raise OutsideFragmentError(f"`{name}` stands where a constant is needed")
        return s[self.slots[name]], {}

    def decided(self, e: Json, s: State, event: Event | None = None) -> bool:
        """A truth that no clock has a part in."""
        f = self.truth(e, s, event)
        if not isinstance(f, bool):
            raise OutsideFragmentError("a comparison of clocks decides an `if` or counts as a number")
        return f

    def truth(self, e: Json, s: State, event: Event | None = None, closed: bool = False, no: bool = False) -> Formula:
        """Where an expression holds in a discrete state; `no`: where it does not; `closed`: read as in S6."""
        if isinstance(e, bool):
            return e is not no
        op, args = e[0], e[1:]
        if op in ("and", "or"):
            join = conjunction if (op == "and") is not no else disjunction
            return join(self.truth(a, s, event, closed, no) for a in args)
        if op == "not":
            return self.truth(args[0], s, event, closed, not no)
        if op == "implies":
            return self.truth(["or", ["not", args[0]], args[1]], s, event, closed, no)
        if op == "if":
            return self.truth(args[1] if self.decided(args[0], s, event) else args[2], s, event, closed, no)
        if op in OPPOSITE:
            return self._comparison(OPPOSITE[op] if no else op, args, s, event, closed)
        if op == "stuck":
            return negation(self.stuck(s)) if no else self.stuck(s)
        return self._fact(e, s, event) is not no

    def _fact(self, e: Json, s: State, event: Event | None) -> bool:
        op, args = e[0], e[1:]
        if op == "at":
            slot, mode = self.modes[args[0]]
            return bool(s[slot] == mode)
        if op in ("jump", "jumped"):
            return event is not None and (op == "jumped" or args[0] in event.names)
        if op == "var" and args[0] in self.slots:
            return bool(self.number(e, s) != 0)
        if op == "pre":
            return self.decided(args[0], event.before if event else s)
        word = f"`{args[0]}` where it is not defined" if op == "undefined" else f"`{op}`"
        raise OutsideFragmentError(f"{word}, in a system")

    def _comparison(self, op: str, args: Sequence[Json], s: State, event: Event | None, closed: bool) -> Formula:
        (p, xs), (q, ys) = self.linear(args[0], s, event), self.linear(args[1], s, event)
        op = CLOSED.get(op, op) if closed else op
        if closed and op == "!=":
            return True
        clocks = {c: xs.get(c, Fraction(0)) - ys.get(c, Fraction(0)) for c in {*xs, *ys}}
        terms = [(c, k) for c, k in sorted(clocks.items()) if k]
        if not terms:
            return holds(op, p - q)
        if len(terms) == 1:
            terms.append((0, -terms[0][1]))
        (i, k), (j, other) = terms[0], terms[1]
        if len(terms) > 2 or other != -k:
            raise OutsideFragmentError(
                "a comparison that is no bound on one clock, nor on the difference of two of one rate"
            )
        return self.bound(i, j, op if k > 0 else MIRRORED[op], (q - p) / k)

    def bound(self, i: int, j: int, op: str, q: Fraction) -> Formula:
        """`x_i - x_j op q`, in units of time."""
        c = whole(q)
        below, above = (i, j, 2 * c + (op in ("<=", "=="))), (j, i, -2 * c + (op in (">=", "==")))
        if op in ("<", "<="):
            return below
        if op in (">", ">="):
            return above
        return conjunction([below, above]) if op == "==" else disjunction([below, above])

    def clock_bounds(self, name: str, low: Fraction | None, high: Fraction | None) -> Formula:
        """`low <= name <= high` for a clock variable, whatever its rate."""
        rate, out = self.rates[name], []
        for op, q in ((">=", low), ("<=", high)):
            if q is not None:
                out.append(self.bound(self.clocks[name], 0, op if rate > 0 else MIRRORED[op], q / rate * self.scale))
        return conjunction(out)


def whole(q: Fraction) -> int:
    """An integer number of units."""
    if q.denominator != 1:
        raise ScaleError(q.denominator)
    if abs(q) > LARGEST:
        raise OutsideFragmentError("times too large, or of denominators too different, to be counted in one unit")
    return int(q)


def holds(op: str, q: Fraction) -> bool:
    """`q op 0`."""
    return {"<": q < 0, "<=": q <= 0, ">": q > 0, ">=": q >= 0, "==": q == 0, "!=": q != 0}[op]


def _times(factor: Fraction, x: Linear) -> Linear:
    return x[0] * factor, {c: k * factor for c, k in x[1].items() if k * factor}


def _sum(terms: Sequence[Linear]) -> Linear:
    total, clocks = Fraction(0), dict[int, Fraction]()
    for q, xs in terms:
        total += q
        for c, k in xs.items():
            clocks[c] = clocks.get(c, Fraction(0)) + k
    return total, {c: k for c, k in clocks.items() if k}


def _product(terms: Sequence[Linear]) -> Linear:
    moving = [x for x in terms if x[1]]
    if len(moving) > 1:
        raise OutsideFragmentError("a product of clocks")
    factor = Fraction(1)
    for q, xs in terms:
        factor *= 1 if xs else q
    return _times(factor, moving[0] if moving else (Fraction(1), {}))


def _quotient(terms: Sequence[Linear]) -> Linear:
    a, b = terms
    if b[1] or not b[0]:
        raise OutsideFragmentError("a division by a clock, or by 0")
    return _times(1 / b[0], a)


def _power(given: Sequence[Fraction]) -> Fraction:
    if given[1].denominator != 1 or abs(given[1]) > 64 or (given[1] < 0 and not given[0]):
        raise OutsideFragmentError("a power with an exponent that is no small integer")
    return Fraction(given[0] ** int(given[1]))


_ARITHMETIC: dict[str, Any] = {
    "+": _sum,
    "-": lambda t: _sum([t[0], _times(Fraction(-1), t[1])]),
    "neg": lambda t: _times(Fraction(-1), t[0]),
    "*": _product,
    "/": _quotient,
}
_FUNCTIONS: dict[str, Any] = {
    "abs": lambda v: abs(v[0]),
    "min": min,
    "max": max,
    "clamp": lambda v: min(max(v[0], v[1]), v[2]),
    "^": _power,
}
