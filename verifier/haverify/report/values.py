"""The value of a variable as people read it."""

from __future__ import annotations

from fractions import Fraction

from haverify.model.hybrid import Input, Variable
from haverify.model.spec import Spec
from haverify.report.numbers import decimal


def shown(spec: Spec, v: Variable | Input, q: Fraction) -> str:
    """A decimal; the name of a truth value or of a value of an enumeration."""
    if v.type == "bool":
        return "true" if q else "false"
    enum = next((e for e in spec.enums if e.name == v.type), None)
    is_named = enum is not None and enum.low is None and q.denominator == 1 and 0 <= q < len(enum.values)
    return enum.values[int(q)] if enum is not None and is_named else decimal(q)
