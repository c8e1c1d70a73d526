"""Matrices of functions of a set: linear in its variables, each in [-1, 1], with bounds of what is left out.

All numbers are integers in units of `2^-bits`.
"""

from __future__ import annotations

from collections.abc import Sequence
from operator import mul
from typing import NamedTuple

from hacheck.enclosures import Key, Space
from hacheck.rational import Beyond, spend

Matrix = list[list[int]]


class Block(NamedTuple):
    """The sum of matrices times monomials (0: the number 1, else set variables), and at most how far it is off."""

    parts: dict[Key, Matrix]
    rest: Matrix


def unit(n: int, bits: int, sign: int = 1) -> Block:
    """The matrix that changes nothing, or minus that."""
    return Block({0: [[sign << bits if i == j else 0 for j in range(n)] for i in range(n)]}, nothing(n))


def nothing(n: int) -> Matrix:
    """Zeros."""
    return [[0] * n for _ in range(n)]


def total(terms: Sequence[Matrix]) -> Matrix:
    """The sum."""
    return [[sum(cs) for cs in zip(*rows, strict=True)] for rows in zip(*terms, strict=True)]


def added(terms: Sequence[Block]) -> Block:
    """The sum of blocks."""
    keys = {k for a in terms for k in a.parts}
    parts = {k: total([a.parts[k] for a in terms if k in a.parts]) for k in keys}
    return Block(parts, total([a.rest for a in terms]))


def sizes(a: Matrix) -> Matrix:
    """The magnitudes."""
    return [[abs(c) for c in row] for row in a]


def size(a: Block) -> Matrix:
    """Bounds of the magnitudes."""
    return total([a.rest, *map(sizes, a.parts.values())])


def applied(a: Matrix, x: list[int], bits: int) -> list[int]:
    """A matrix of bounds times a vector of bounds."""
    return [-(-sum(map(mul, row, x)) >> bits) for row in a]


def _times(a: Matrix, b: Matrix) -> Matrix:
    columns = list(zip(*b, strict=True))
    spend(1 + (len(a) * len(a) * len(columns) >> 4))
    return [[sum(map(mul, row, column)) for column in columns] if any(row) else [0] * len(columns) for row in a]


def term(a: Sequence[Block], b: Sequence[Block], m: int, bits: int) -> Block:
    """The coefficient of t^m in a product of series: all products that are linear, bounds of the others."""
    pairs = [(a[i], b[m - i]) for i in range(len(a)) if 0 <= m - i < len(b)]
    found: dict[Key, list[Matrix]] = {}
    lost = []
    for x, y in pairs:
        for k, p in x.parts.items():
            for other, q in y.parts.items() if not k else [(0, y.parts[0])] if 0 in y.parts else []:
                found.setdefault(k + other, []).append(_times(p, q))
        bent, also = ([m for k, m in z.parts.items() if k] for z in (x, y))
        if bent and also:
            lost.append(_times(total([sizes(m) for m in bent]), total([sizes(m) for m in also])))
        if any(map(any, x.rest)):
            lost.append(_times(x.rest, size(y)))
        if any(map(any, y.rest)):
            lost.append(_times(total([x.rest, *map(sizes, x.parts.values())]), y.rest))
    parts = {k: [[c >> bits for c in row] for row in total(p)] for k, p in found.items()}
    n = len(pairs[0][0].rest)
    rest = total(lost) if lost else nothing(n)
    return Block(parts, [[(c >> bits) + 1 + len(parts) for c in row] for row in rest])


def product(a: Block, b: Block, bits: int) -> Block:
    """The product."""
    return term([a], [b], 0, bits)


def inverse(a: Block, bits: int) -> Block:
    """Near the inverse: that of its middle, and one step of Newton's iteration; nothing rests on it."""
    back, parts, zeros = inverted(a.parts[0], bits), {}, nothing(len(a.rest))
    for k, m in a.parts.items():
        if k:
            half = product(Block({0: back}, zeros), Block({0: m}, zeros), bits).parts[0]
            made = product(Block({0: half}, zeros), Block({0: back}, zeros), bits).parts[0]
            parts[k] = [[-c for c in row] for row in made]
    return Block({0: back, **parts}, zeros)


def inverted(a: Matrix, bits: int) -> Matrix:
    """A matrix near the inverse, by elimination; nothing rests on it."""
    n, one = len(a), 1 << bits
    spend(n**3)
    rows = [[*row, *(one if i == j else 0 for j in range(n))] for i, row in enumerate(a)]
    for c in range(n):
        best = max(range(c, n), key=lambda i: abs(rows[i][c]))
        rows[c], rows[best] = rows[best], rows[c]
        pivot = rows[c][c]
        if not pivot:
            raise Beyond("the errors of a recorded flow lose a direction")
        rows[c] = [x * one // pivot for x in rows[c]]
        for i in range(n):
            if i != c and rows[i][c]:
                rows[i] = [x - (rows[i][c] * y >> bits) for x, y in zip(rows[i], rows[c], strict=True)]
    return [row[n:] for row in rows]


def orthogonal(a: Matrix, radii: list[int], space: Space) -> Matrix:
    """Columns near orthogonal ones, the first along the longest column times its radius (R. Lohner's choice)."""
    n = range(len(a))
    columns = [[row[j] for row in a] for j in n]
    lengths = [sum(abs(row[j]) for row in a) * (radii[j] + 1) for j in n]
    found: Matrix = []
    for j in sorted(n, key=lambda j: -lengths[j]):
        column = columns[j]
        for other in found:
            along = sum(map(mul, column, other)) * space.one // (sum(x * x for x in other) or 1)
            column = [x - (along * y >> space.bits) for x, y in zip(column, other, strict=True)]
        most = max(map(abs, column))
        if not most:
            raise Beyond("the errors of a recorded flow lose a direction")
        found.append([x * space.one // most for x in column])
    return [[c[i] for c in found] for i in n]
