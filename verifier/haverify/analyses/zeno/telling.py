"""What is said of runs that end because their jumps accumulate."""

from __future__ import annotations

from fractions import Fraction

from haverify.analyses.induction.written import written
from haverify.analyses.zeno.closing import Closing, rounded_up
from haverify.analyses.zeno.tail import Bracket
from haverify.maths.exact import people_text, significant
from haverify.obligations.formula import conjunction, literals
from haverify.obligations.induction import Induction

DIGITS = 8


def ending(induction: Induction, closing: Closing, found: Bracket | None = None) -> str:
    """By when all runs have ended, where jumps accumulate and when, and what a cycle of jumps leaves."""
    unit = "" if induction.spec.unitless else " s"
    text = f"no run has an instant after {people_text(closing.end)}{unit}: it is stuck, or its jumps accumulate (S12)"
    point = conjunction(f for f in closing.point)
    if list(literals(point)):
        text += f", where {written(point, induction.automaton, induction.spec.params, induction.functions)}"
    if found is not None:
        text += "; " + between(found, unit)
    if closing.share is not None:
        text += f"; a cycle of jumps leaves at most {significant(closing.share)} of the speed"
    return text


def between(found: Bracket, unit: str) -> str:
    """When jumps accumulate, with few digits, rounded outwards."""
    low, high = -rounded_up(-found.low, DIGITS), rounded_up(found.high, DIGITS)
    times = f"between {people_text(low)}{unit} and {people_text(high)}{unit}"
    return f"followed through {found.jumps} jumps, those that accumulate do so {times} (enclosed)"


def after_jumps(jumps: int, high: Fraction, is_unitless: bool) -> str:
    """By when all runs have ended, as flowpipes through some jumps show it."""
    unit = "" if is_unitless else " s"
    last = f"{people_text(rounded_up(high, DIGITS))}{unit}"
    return f"followed through {jumps} jumps, no run has an instant after {last} (enclosed)"
