"""Starts with values between two numbers: zeros of equations that need not have a rational one."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from itertools import permutations
from typing import Any

from hacheck.bernstein import Box, shown
from hacheck.formula import Formula, conj, literal, members, placed, variables
from hacheck.polynomial import Env, Poly, const, names
from hacheck.rational import Refused, number

Json = Any
Brackets = dict[str, tuple[Fraction, Fraction]]
MOST = 4


def brackets(values: Mapping[str, Json], types: Mapping[str, str]) -> Brackets:
    """The values of a start that are given by two numbers `[low, high]` of digits."""
    given = {v: q for v, q in values.items() if isinstance(q, list) and all(isinstance(e, str) for e in q)}
    found = {v: (number(q[0]), number(q[1])) for v, q in given.items() if len(q) == 2}
    if len(found) > MOST or any(types.get(v) != "real" or not low < high for v, (low, high) in found.items()):
        raise Refused("a start has brackets of what is no number, empty ones, or too many")
    return found


def rooted(f: Formula, found: Brackets) -> Formula | None:
    """What f says beyond equations that have a common zero in the brackets; None where that is not shown.

    One equation for each name, with opposite signs where the name is at its ends, whatever the others are: that is
    the theorem of Poincare and Miranda.
    """
    said = list(members(f, "and"))
    equations = [g[1] for g in said if not isinstance(g, bool) and g[0] == "==" and variables(g) & found.keys()]
    if len(equations) != len(found) or not all(names(p) <= found.keys() for p in equations):
        return None
    ways = permutations(found)
    if not any(all(_crosses(p, v, found) for p, v in zip(equations, way, strict=True)) for way in ways):
        return None
    return conj(g for g in said if isinstance(g, bool) or g[0] != "==" or g[1] not in equations)


def _crosses(p: Poly, v: str, found: Brackets) -> bool:
    box: Box = {**found}
    low, high = (Env({v: const(q)}) for q in found[v])
    return any(shown(placed(literal(a, p), low), box) and shown(placed(literal(b, p), high), box)
               for a, b in (("<", ">"), (">", "<")))  # fmt: skip
