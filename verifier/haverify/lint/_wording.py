"""Names and values as findings print them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from fractions import Fraction

from haverify.maths.exact import people_text
from haverify.model.expression import Expr, nodes
from haverify.model.hybrid import Edge
from haverify.model.unit import Unit
from haverify.solvers.frame import Scope


def quantity(value: Fraction, unit: Unit | None) -> str:
    """A number with its unit: `1.6 s`."""
    name = str(unit) if unit is not None else ""
    return people_text(value) + (f" {name}" if name not in ("", "1") else "")


def edge_name(edge: Edge) -> str:
    """An edge as people know it: `edge hitR (Left -> Right)`."""
    way = f"{edge.source} -> {edge.target}"
    return f"edge {edge.name} ({way})" if edge.name else f"edge {way}"


def point_text(point: Mapping[str, Fraction], scope: Scope, names: Iterable[str] | None = None) -> str:
    """A state as `x = 1.6 s, phase is LR`; only `names` where given, in the order of declaration."""
    wanted = point.keys() & set(point if names is None else names)
    shown = [value_text(v.name, point[v.name], v.type, v.unit, scope) for v in scope.vars.values() if v.name in wanted]
    shown += [
        value_text(i.name, point[i.name], i.type, i.unit, scope) for i in scope.inputs.values() if i.name in wanted
    ]
    shown += [f"{p.name} = {quantity(point[p.name], p.unit)}" for p in scope.params.values() if p.name in wanted]
    return ", ".join(shown)


def value_text(name: str, value: Fraction, type_name: str, unit: Unit | None, scope: Scope) -> str:
    """A named value as people write it: `x = 1.6 s`, `phase is LR`, `not armed`."""
    enum = scope.enums.get(type_name)
    if type_name == "bool":
        return name if value else f"not {name}"
    if enum is not None and enum.low is None:
        return f"{name} is {enum.values[int(value)]}"
    return f"{name} = {quantity(value, unit)}"


def mentioned(e: Expr) -> list[str]:
    """The variables, params and inputs an expression mentions, in order."""
    return list(dict.fromkeys(n.name for n in nodes(e) if n.op in ("var", "param", "input")))
