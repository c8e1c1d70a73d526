"""What is said of runs that end because their jumps accumulate."""

from __future__ import annotations

from haverify.analyses.induction.written import written
from haverify.analyses.zeno.closing import Closing
from haverify.maths.exact import people_text, significant
from haverify.obligations.formula import conjunction, literals
from haverify.obligations.induction import Induction


def ending(induction: Induction, closing: Closing) -> str:
    """By when all runs have ended, where jumps accumulate, and what a cycle of jumps leaves."""
    unit = "" if induction.spec.unitless else " s"
    text = f"no run has an instant after {people_text(closing.end)}{unit}: jumps accumulate by then (LANGUAGE S12)"
    point = conjunction(f for f in closing.point)
    if list(literals(point)):
        text += f", where {written(point, induction.automaton, induction.spec.params, induction.functions)}"
    if closing.share is not None:
        text += f"; a cycle of jumps leaves at most {significant(closing.share)} of the speed"
    return text
