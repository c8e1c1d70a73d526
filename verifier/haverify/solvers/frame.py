"""How the names in a condition are read: by which automaton, in which mode, before or after a reset."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from functools import cached_property
from typing import Any

from haverify.maths.polynomial import Polynomial, variable
from haverify.model.expression import Expr
from haverify.model.hybrid import Constant, HybridAutomaton, Input, Mode, Output, Param, Variable
from haverify.model.spec import EnumType, Spec
from haverify.text.record import field, record, replace


@record
class Scope:
    """The declarations that names of an automaton (or, without one, of the top level) refer to."""

    spec: Spec
    automaton: HybridAutomaton | None
    known: dict[tuple[str | None, str], Any] = field(default_factory=dict, compare=False, repr=False)  # by mode and let

    @cached_property
    def constants(self) -> dict[str, Constant]:
        own = self.automaton.constants if self.automaton else ()
        return {c.name: c for c in (*self.spec.constants, *own)}

    @cached_property
    def params(self) -> dict[str, Param]:
        own = self.automaton.params if self.automaton else ()
        return {p.name: p for p in (*self.spec.params, *own)}

    @cached_property
    def inputs(self) -> dict[str, Input]:
        own = self.automaton.inputs if self.automaton else ()
        return {i.name: i for i in (*self.spec.inputs, *own)}

    @cached_property
    def vars(self) -> dict[str, Variable]:
        return {v.name: v for v in self.automaton.vars} if self.automaton else {}

    @cached_property
    def lets(self) -> dict[str, Output]:
        return {o.name: o for o in self.automaton.lets} if self.automaton else {}

    @cached_property
    def enums(self) -> dict[str, EnumType]:
        return {e.name: e for e in self.spec.enums}

    def values(self, type_name: str) -> list[Fraction] | None:
        """The values of a discrete type as numbers, None for `real`."""
        if type_name == "bool":
            return [Fraction(0), Fraction(1)]
        enum = self.enums.get(type_name)
        if enum is None:
            return None
        low = enum.low if enum.low is not None else Fraction(0)
        return [low + k for k in range(len(enum.values))]


@record
class Frame:
    """A scope, the mode whose lets are meant, and the value of each variable where it is not the variable itself."""

    scope: Scope
    mode: Mode | None = None
    values: Mapping[str, Polynomial] = field(default_factory=dict)
    jump: str | None = None  # the edge that has just been taken, "" for none; None where that is not known

    def let(self, name: str) -> Expr | None:
        """The expression of an output in this mode."""
        own = next((o for o in self.mode.lets if o.name == name), None) if self.mode else None
        found = own or self.scope.lets.get(name)
        return found.expr if found else None

    def variable(self, name: str) -> Polynomial:
        """The value of a variable, before any reset the unknown of its name."""
        return self.values.get(name, variable(name))

    def after(self, mode: Mode, values: Mapping[str, Polynomial]) -> Frame:
        """The frame in `mode` with the variables' values after a reset."""
        return replace(self, mode=mode, values=values)
