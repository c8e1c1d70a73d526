"""How far small errors are from their series: what rounding leaves out is counted in full."""

from __future__ import annotations

from fractions import Fraction

from hacheck.enclosures import Space, key
from hacheck.matrices import Block, term
from hacheck.tubes import Field, _divided

BITS, TOP = 24, 4
START, SLOPES = 162699, [3911, 1592, 912, 2432, 3491]  # much is cut, nearly always
KEYS = [0, *(key([*[0] * i, 1]) for i in range(64))]


def turned(start: int, slopes: list[int]) -> tuple[int, Fraction]:
    """The bound of `h J U - U'`, and what it is at t = 1 where all set variables are 1, in units."""
    field = object.__new__(Field)
    field.coarse = Space(BITS, TOP, 1)
    frame, rates = Block({k: [[start]] for k in KEYS}, [[0]]), [Block({0: [[s]]}, [[0]]) for s in slopes]
    series = [frame]
    for k in range(TOP):
        series.append(_divided(term(rates, series, k, BITS), k + 1))
    at_one = [sum(m[0][0] for m in a.parts.values()) for a in series]
    moved = sum(at_one) * Fraction(sum(slopes), 1 << BITS)
    bound = field._turn(frame, Block({0: [[1 << BITS]]}, [[0]]), (rates, [[0]])).rest[0][0]
    return bound, moved - sum(i * a for i, a in enumerate(at_one))


def test_remainders_of_many_monomials_are_counted() -> None:
    """Each monomial loses by products cut, and by divisions by powers of t, always to the same side."""
    bound, off = turned(START, SLOPES)
    assert abs(off) <= bound
