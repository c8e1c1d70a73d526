"""The structure of a bounded STL formula: what it says of instants, how far it looks, its value on a timeline."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from functools import cached_property

from haverify.analyses.signals_value import Signal, Timeline, Window, both, denied, either, eventually, globally, until
from haverify.model.expression import Expr, nodes
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import record

Q = Fraction
TEMPORAL = frozenset({"globally", "eventually", "until"})
JUNCTIONS = frozenset({"and", "or", "not", "implies"})
Lookup = Callable[[int, bool], Signal]  # an atom, and whether a greater value of it makes the whole truer


def is_temporal(e: Expr) -> bool:
    """Whether it speaks of more than one instant."""
    return any(n.op in TEMPORAL for n in nodes(e))


def atoms_of(e: Expr) -> tuple[Expr, ...]:
    """The largest subformulas without temporal operators, each once, from left to right."""
    if not is_temporal(e):
        return (e,)
    if e.op not in TEMPORAL | JUNCTIONS:
        raise OutsideFragmentError(f"`{e.op}` around a temporal operator; `and`, `or`, `not` and `implies` may be")
    found = e.children[2:] if e.op in TEMPORAL else e.children
    return tuple(dict.fromkeys(a for c in found for a in atoms_of(c)))


@record
class Formula:
    """A formula with its atoms and the numbers its windows stand for."""

    whole: Expr
    atoms: tuple[Expr, ...]
    number: Callable[[Expr], Q]

    @cached_property
    def horizon(self) -> Q:
        """How long after the start the formula still looks, in s."""
        return self._far(self.whole)

    def _far(self, e: Expr) -> Q:
        if e.op in TEMPORAL:
            return self.ends(e)[1] + max(self._far(c) for c in e.children[2:])
        return max((self._far(c) for c in e.children), default=Q(0)) if is_temporal(e) else Q(0)

    def ends(self, e: Expr) -> tuple[Q, Q]:
        """The window of a temporal operator."""
        low, high = self.number(e.children[0]), self.number(e.children[1])
        if low < 0 or high < low:
            raise OutsideFragmentError(f"the window [{low} s, {high} s] of `{e.op}` has no instant, or looks back")
        return low, high

    def value(self, t: Timeline, rate: tuple[Q, Q], atom: Lookup) -> Signal:
        """Where it holds on a timeline whose clock runs at a rate between these bounds."""

        def window(e: Expr) -> Window:
            a, b = self.ends(e)
            return Window((a * rate[0], a * rate[1]), (b * rate[0], b * rate[1]))

        def of(e: Expr, up: bool, limit: Q) -> Signal:
            if not is_temporal(e):
                return atom(self.atoms.index(e), up)
            if e.op in TEMPORAL:
                return over_time(e, up, limit)
            found = of(e.children[0], up is not (e.op in ("not", "implies")), limit)
            if e.op in ("not", "implies"):
                found = denied(t, found)
            for c in e.children[1:]:
                found = (both if e.op == "and" else either)(found, of(c, up, limit))
            return found

        def over_time(e: Expr, up: bool, limit: Q) -> Signal:
            w, need = window(e), t.within(limit)
            below = [of(c, up, limit + w.b[1]) for c in e.children[2:]]
            if e.op == "until":
                return until(t, below[0], below[1], w, need)
            return (globally if e.op == "globally" else eventually)(t, below[0], w, need)

        return of(self.whole, True, Q(0))


def formula_of(e: Expr, number: Callable[[Expr], Q]) -> Formula:
    """The formula, taken apart; its windows are looked at at once.

    Raises
    ------
    OutsideFragmentError    where a temporal operator stands inside a comparison, or a window looks back
    """
    made = Formula(e, atoms_of(e), number)
    assert made.horizon >= 0, "windows do not look back"
    return made
