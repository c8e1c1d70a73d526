"""What ends all runs by an instant, and the numbers it is made of."""

from __future__ import annotations

from fractions import Fraction
from math import inf

from haverify.analyses.zeno.floats import Point, points
from haverify.analyses.zeno.roots import Lemma, Term
from haverify.obligations.formula import Formula
from haverify.obligations.induction import Induction
from haverify.text.record import record

Q = Fraction
SLACK = Q(1, 10**9)
SLACKS = (Q(0), SLACK, Q(1, 10**6), Q(1, 1000), Q(1, 50))
EXACT = Q(1, 10**14)
SIMPLE = 10**5


@record
class Last:
    """The literal of a mode that the flow keeps last: its slope along the flow is minus the sum of the terms."""

    before: Formula
    literal: Formula
    terms: tuple[Term, ...]


@record
class Closing:
    """Formulas for each mode with which no run has an instant after `end`.

    `lemmas` of modes and `landing` of edges make proofs short. `share`: the greatest part of the speed that a cycle
    leaves; None where there is no such number. `point`: what holds where jumps accumulate.
    """

    formulas: dict[str, Formula]
    lemmas: dict[str, list[Lemma]]
    landing: dict[int, list[Lemma]]
    end: Fraction
    share: Fraction | None
    last: dict[str, Last]
    point: tuple[Formula, ...]


def starts_in(induction: Induction, mode: str) -> list[Point]:
    """Starts in a mode, in floats: corners, and some inside."""
    lines = [line for line, m, _ in induction.lines() if m == mode]
    told = [induction.premises(*induction.common(mode), *induction.starts(line, mode)) for line in lines]
    return [p for premises in told for p in points(premises)]


def above(x: float, slack: Fraction) -> Fraction | None:
    """A rational above a number by a share; with none, the simple one that it seems to be. None if infinite."""
    if abs(x) == inf:
        return None
    simple = Q(x).limit_denominator(SIMPLE)
    if not slack and abs(simple - Q(x)) <= abs(Q(x)) * EXACT:
        return simple
    return rounded_up(Q(x) + abs(Q(x)) * (slack or SLACK) + SLACK**2)


def rounded_up(q: Fraction, digits: int = 12) -> Fraction:
    """The least decimal with so many significant digits that is not below."""
    if not q:
        return q
    size = 0
    while abs(q) * Q(10) ** size < 10 ** (digits - 1):
        size += 1
    while abs(q) * Q(10) ** size >= 10**digits:
        size -= 1
    return -(-q * Q(10) ** size // 1) / Q(10) ** size
