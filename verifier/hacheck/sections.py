"""The set of states in which laps begin: a parallelepiped of a plane where one variable has a value, in a mode."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from typing import Any, NamedTuple

from hacheck.rational import Refused, number
from hacheck.records import Ends

Json = Any
Exact = list[list[Fraction]]
ONE = Fraction(1)


class Section(NamedTuple):
    """States `centre + basis w` of the plane `variable = value`, each w in [-1, 1]; `back` is the inverse of the basis.

    The other variables and the w have the same names, those of the centre.
    """

    mode: str
    variable: str
    value: Fraction
    centre: dict[str, Fraction]
    basis: Exact
    back: Exact

    def box(self, share: Fraction = ONE) -> dict[str, Ends]:
        """A box around the states, or around those with all w in a share of [-1, 1]."""
        far = [share * sum(map(abs, row)) for row in self.basis]
        sides = {v: (c - r, c + r) for (v, c), r in zip(self.centre.items(), far, strict=True)}
        return {**sides, self.variable: (self.value, self.value)}


def section_of(entry: Json, names: Iterable[str], modes: Iterable[str]) -> Section:
    """The section that an entry states."""
    mode, (variable, value) = str(entry["mode"]), entry["section"]
    columns, known = [v for v in names if v != variable], list(names)
    if mode not in set(modes) or variable not in known or set(entry["centre"]) != set(columns):
        raise Refused("a section is no plane of a mode and its variables")
    basis = [[number(q) for q in row] for row in entry["basis"]]
    if len(basis) != len(columns) or any(len(row) != len(columns) for row in basis):
        raise Refused("a section has not as many directions as the plane")
    centre = {v: number(entry["centre"][v]) for v in columns}
    return Section(mode, variable, number(value), centre, basis, _inverse(basis))


def _inverse(a: Exact) -> Exact:
    n = len(a)
    rows = [[*row, *(Fraction(i == j) for j in range(n))] for i, row in enumerate(a)]
    for k in range(n):
        at = next((i for i in range(k, n) if rows[i][k]), None)
        if at is None:
            raise Refused("the directions of a section are not independent")
        rows[k], rows[at] = rows[at], rows[k]
        rows[k] = [x / rows[k][k] for x in rows[k]]
        for i in range(n):
            if i != k:
                rows[i] = [x - rows[i][k] * y for x, y in zip(rows[i], rows[k], strict=True)]
    return [row[n:] for row in rows]
