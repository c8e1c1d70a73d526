"""Linear equations over the rationals: sparse Gauss-Jordan elimination with exact numbers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction

from haverify.text.record import holder

Equation = Mapping[int, Fraction]
"""The coefficients of the unknowns, which are numbered; none of them zero."""


@holder
class Echelon:
    """Equations `x_pivot + sum of the others = right`, each pivot in one of them only."""

    rows: dict[int, dict[int, Fraction]]
    right: dict[int, Fraction]

    def solution(self, free: Mapping[int, Fraction]) -> dict[int, Fraction]:
        """The solution in which unknowns that are no pivots have the values of `free`, 0 where it has none."""
        found = {k: v for k, v in free.items() if k not in self.rows and v}
        for pivot, row in self.rows.items():
            value = self.right[pivot] - sum((c * found[k] for k, c in row.items() if k in found), Fraction(0))
            if value:
                found[pivot] = value
        return found


def echelon(equations: Iterable[tuple[Equation, Fraction]], last: Sequence[int] = ()) -> Echelon | None:
    """The equations solved for pivots; None where they contradict each other.

    Unknowns in `last` become pivots only where an equation has no other.
    """
    late = set(last)
    found = Echelon({}, {})
    uses: dict[int, set[int]] = {}
    for equation, right in sorted(equations, key=lambda e: len(e[0])):
        row, value = _reduced(dict(equation), right, found)
        if not row:
            if value:
                return None
            continue
        pivot = min(row, key=lambda k: (k in late, len(uses.get(k, ())), k))
        factor = 1 / row.pop(pivot)
        row = {k: c * factor for k, c in row.items()}
        value *= factor
        _clear(found, uses, pivot, row, value)
        found.rows[pivot], found.right[pivot] = row, value
        for k in row:
            uses.setdefault(k, set()).add(pivot)
    return found


def _reduced(row: dict[int, Fraction], right: Fraction, by: Echelon) -> tuple[dict[int, Fraction], Fraction]:
    for pivot in [k for k in row if k in by.rows]:
        factor = row.pop(pivot)
        _subtract(row, by.rows[pivot], factor)
        right -= factor * by.right[pivot]
    return row, right


def _clear(found: Echelon, uses: dict[int, set[int]], pivot: int, row: dict[int, Fraction], right: Fraction) -> None:
    """Takes the new pivot out of the equations that have it."""
    for other in uses.pop(pivot, set()):
        target = found.rows[other]
        factor = target.pop(pivot)
        before = set(target)
        _subtract(target, row, factor)
        found.right[other] -= factor * right
        for k in before - set(target):
            uses[k].discard(other)
        for k in set(target) - before:
            uses.setdefault(k, set()).add(other)


def _subtract(row: dict[int, Fraction], other: Mapping[int, Fraction], factor: Fraction) -> None:
    for k, c in other.items():
        value = row.get(k, 0) - factor * c
        if value:
            row[k] = Fraction(value)
        else:
            row.pop(k, None)


def kernel(equations: Iterable[Equation], size: int) -> list[dict[int, Fraction]]:
    """A basis of the solutions of `equation = 0` for all of them, in unknowns 0 to `size` - 1."""
    solved = echelon((e, Fraction(0)) for e in equations)
    if solved is None:
        return []
    one = Fraction(1)
    return [solved.solution({k: one}) for k in range(size) if k not in solved.rows]
