"""Ranges of expressions over boxes, and truths of conditions there."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from haverify.analyses.hybrid.conditions import Atom, Condition, Every
from haverify.maths.interval import Fault, Interval
from haverify.model.expression import Expr
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import holder

Q = Fraction
FUNCTIONS = {
    "neg": Interval.__neg__, "abs": Interval.__abs__, "sqrt": Interval.sqrt, "exp": Interval.exp, "log": Interval.log,
    "sin": Interval.sin, "cos": Interval.cos, "tan": Interval.tan, "asin": Interval.asin, "acos": Interval.acos,
    "atan": Interval.atan, "sinh": Interval.sinh, "cosh": Interval.cosh, "tanh": Interval.tanh,
}  # fmt: skip
CHAINED = {
    "+": Interval.__add__, "-": Interval.__sub__, "*": Interval.__mul__, "/": Interval.__truediv__,
    "min": Interval.minimum, "max": Interval.maximum,
}  # fmt: skip


@holder
class Ranges:
    """Ranges over a box; `definitions` are what lets and constants stand for."""

    box: Mapping[str, Interval]
    definitions: Mapping[tuple[str, str], Expr]

    def of(self, e: Expr) -> Interval:
        """The range of a quantity.

        Raises
        ------
        Fault                   if it may be undefined somewhere
        OutsideFragmentError    if it holds an operation without an enclosure
        """
        if e.op in ("var", "param", "time"):
            return self.box["time" if e.op == "time" else e.name]
        if e.op in ("let", "const") and (e.op, e.name) in self.definitions:
            return self.of(self.definitions[e.op, e.name])
        if e.op == "num":
            return Interval.at(Q(str(e.args[0])))
        if e.op == "pi":
            return Interval.at(1).atan() * 4
        if e.op == "scale":
            return Interval.at(Q(str(e.args[0]))) * (Interval.at(1).atan() * 4) ** int(str(e.args[1])) * self._last(e)
        if e.op == "^":
            return self._power(e)
        if e.op in CHAINED:
            first, *rest = (self.of(c) for c in e.children)
            for x in rest:
                first = CHAINED[e.op](first, x)
            return first
        if e.op in FUNCTIONS:
            return FUNCTIONS[e.op](self._last(e))
        raise OutsideFragmentError(f"`{e.op}` beside a periodic orbit")

    def _last(self, e: Expr) -> Interval:
        return self.of(e.children[-1])

    def _power(self, e: Expr) -> Interval:
        base, exponent = e.children
        n = Q(str(exponent.args[0])) if exponent.op == "num" else Q(1, 2)
        if n.denominator != 1:
            raise OutsideFragmentError("a power whose exponent is no integer")
        return self.of(base) ** int(n)

    def truth(self, c: Condition) -> bool | None:
        """Whether a condition holds everywhere in the box, or nowhere, or neither is known."""
        if isinstance(c, bool):
            return c
        if isinstance(c, Atom):
            return self._compared(c)
        truths = [self.truth(m) for m in c.members]
        decisive = not isinstance(c, Every)
        if decisive in truths:
            return decisive
        return None if None in truths else not decisive

    def _compared(self, c: Atom) -> bool | None:
        try:
            x = self.of(c.quantity)
        except Fault:
            return None
        if c.op in ("==", "!="):
            is_zero = True if x.low == x.high == 0 else False if x.low > 0 or x.high < 0 else None
            return is_zero if c.op == "==" or is_zero is None else not is_zero
        low, high = (x.low, x.high) if c.op[0] == ">" else (-x.high, -x.low)
        is_closed = c.op in (">=", "<=")
        if low > 0 or (is_closed and low == 0):
            return True
        return False if high < 0 or (not is_closed and high == 0) else None
