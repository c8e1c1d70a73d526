"""Symmetric matrices over the rationals: is one positive semidefinite? Its LDL^T decomposition says so."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

Matrix = list[list[Fraction]]


def squares(gram: Sequence[Sequence[Fraction]]) -> list[tuple[Fraction, list[Fraction]]] | None:
    """Numbers q > 0 and vectors l with `gram = sum of q l l^T`; None where the matrix is not positive semidefinite.

    Source              the LDL^T decomposition with the greatest diagonal entry as pivot
    """
    rest = [list(row) for row in gram]
    size = len(rest)
    left = set(range(size))
    found = []
    while left:
        k = max(left, key=lambda i: (rest[i][i], -i))
        pivot = rest[k][k]
        if pivot < 0 or (pivot == 0 and any(rest[i][j] for i in left for j in left)):
            return None
        if pivot == 0:
            break
        column = [rest[i][k] / pivot if i in left else Fraction(0) for i in range(size)]
        found.append((pivot, column))
        left.discard(k)
        for i in left:
            if column[i]:
                for j in left:
                    if column[j] and j >= i:
                        rest[i][j] -= pivot * column[i] * column[j]
                        rest[j][i] = rest[i][j]
    return found
