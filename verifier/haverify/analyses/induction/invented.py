"""Invariants found for one mode: cuts of `analyses.synthesis` as a formula and the proof that the flow keeps it."""

from __future__ import annotations

from typing import Any

from haverify.obligations.formula import Formula, conjunction
from haverify.obligations.induction import Induction
from haverify.obligations.premises import formula_json
from haverify.text.record import record

Json = Any


@record
class Invented:
    """A formula for the mode, and a FLOW that keeps it."""

    mode: str
    formula: Formula
    flow: Json


def applies(induction: Induction) -> bool:
    """Whether an invariant is searched for: one mode, no edges, no functions (they would be taken for constant)."""
    return len(induction.automaton.modes) == 1 and not induction.automaton.edges and not induction.functions.known


def invent(induction: Induction, seconds: float) -> Invented | None:
    """Cuts that hold at all starts, are kept and imply the goal."""
    if not applies(induction):
        return None
    from haverify.analyses.synthesis.saturate import invent as saturate
    from haverify.analyses.synthesis.system import System

    mode = induction.automaton.modes[0].name
    common = induction.common(mode)
    starts = tuple(induction.premises(*common, *induction.starts(line, m)) for line, m, _ in induction.lines())
    system = System(induction.premises(*common), starts, induction.aim(mode), induction.field(mode))
    try:
        cuts = saturate(system, seconds)
    except OverflowError:  # a number beyond the floats in which candidates are sampled
        return None
    if cuts is None:
        return None
    told = [{"formula": formula_json(conjunction(cut.literals)), "start": "t", "keep": cut.rule} for cut in cuts]
    return Invented(mode, conjunction(q for cut in cuts for q in cut.literals), {"cuts": told, "end": "t"})
