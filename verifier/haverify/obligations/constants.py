"""The values of constants, params and enumerations of a spec, as exact numbers or, where asked for, as symbols."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from fractions import Fraction

from haverify.maths.polynomial import Polynomial, variable
from haverify.model.expression import Expr
from haverify.model.hybrid import Constant, HybridAutomaton, Param, Range
from haverify.model.spec import Spec
from haverify.obligations.formula import Formula
from haverify.obligations.translate import Case, OutsideFragmentError, Scope
from haverify.text.record import field, holder

Q = Fraction


@holder
class Values:
    """What a spec's constants and enumerations are worth inside one automaton; `symbolic` constants stay variables.

    `names` is what params mean to constants that read them.
    """

    constants: dict[str, Constant]
    positions: dict[str, dict[str, Q]]
    symbolic: frozenset[str] = frozenset()
    known: dict[str, list[Case] | Formula] = field(default_factory=dict)
    names: Mapping[str, Polynomial] = field(default_factory=dict)

    def constant(self, name: str) -> list[Case] | Formula:
        """The value of a constant: cases (one, as a rule), or a truth value."""
        if name in self.symbolic:
            return [Case(True, variable(name))]
        if name not in self.known:
            self.known[name] = self._evaluate(name)
        return self.known[name]

    def _evaluate(self, name: str) -> list[Case] | Formula:
        if name not in self.constants:
            raise OutsideFragmentError(f"there is no constant `{name}`")
        value = self.constants[name].value
        if isinstance(value, Range):
            raise OutsideFragmentError(f"the constant `{name}` is a set")
        scope = self.scope(f"the constant `{name}`")
        return scope.formula(value) if scope.is_truth(value) else scope.cases(value)

    def scope(self, where: str) -> Scope:
        """A scope in which only constants mean something, and what they may read."""
        return Scope(where, self.names, {}, self.constant, self.symbol, frozenset(), {})

    def symbol(self, enum: str, value: str) -> Q:
        """The number of an enumeration's value."""
        try:
            return self.positions[enum][value]
        except KeyError:
            raise OutsideFragmentError(f"there is no value `{value}` of `{enum}`") from None

    def number(self, e: Expr) -> Q:
        """The exact value of an expression in constants."""
        value = self.scope("a bound").polynomial(e).constant
        if value is None:
            raise OutsideFragmentError("a bound reads `pi`, and only rational bounds are followed")
        return value

    def interval(self, r: Range) -> tuple[Q, Q]:
        """Both ends of a range of constants."""
        return self.number(r.low), self.number(r.high)


def values_of(spec: Spec, automaton: HybridAutomaton | None, symbolic: Iterable[str] = ()) -> Values:
    """The values that hold inside `automaton` (None: on the top level), its own constants first."""
    own = automaton.constants if automaton is not None else ()
    constants = {c.name: c for c in (*spec.constants, *own)}
    positions = {}
    for e in spec.enums:
        first = e.low if e.low is not None else Q(0)
        positions[e.name] = {v: first + i for i, v in enumerate(e.values)}
    return Values(constants, positions, frozenset(symbolic))


def params_of(spec: Spec, automaton: HybridAutomaton) -> tuple[Param, ...]:
    """The params that an automaton can read: the spec's and its own."""
    return (*spec.params, *automaton.params)


def rounded(values: Values) -> dict[str, tuple[Q, Q]]:
    """The box of each constant that was printed with limited digits."""
    boxes = {}
    for c in values.constants.values():
        if c.half is not None and isinstance(c.value, Expr):
            middle = values.number(c.value)
            boxes[c.name] = (middle - c.half, middle + c.half)
    return boxes
