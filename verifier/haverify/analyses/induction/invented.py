"""Invariants found for one mode: cuts of `analyses.synthesis` as a formula and the proof that the flow keeps it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from haverify.maths.polynomial import Polynomial
from haverify.model.expression import Expr, nodes
from haverify.obligations.formula import Formula, conjunction
from haverify.obligations.induction import Induction
from haverify.obligations.premises import formula_json
from haverify.text.record import record

if TYPE_CHECKING:
    from haverify.analyses.synthesis.system import System

Json = Any
MOST_SIGHTS = 20


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

    mode = induction.automaton.modes[0].name
    try:
        cuts = saturate(system_of(induction, mode), seconds)
    except OverflowError:  # a number beyond the floats in which candidates are sampled
        return None
    if cuts is None:
        return None
    told = [{"formula": formula_json(conjunction(cut.literals)), "start": "t", "keep": cut.rule} for cut in cuts]
    return Invented(mode, conjunction(q for cut in cuts for q in cut.literals), {"cuts": told, "end": "t"})


def system_of(induction: Induction, mode: str) -> System:
    """What is searched for in a mode: its flow, the starts of the lines that allow it, the goal."""
    from haverify.analyses.synthesis.system import System

    common = induction.common(mode)
    lines = [line for line, m, _ in induction.lines() if m == mode]
    starts = tuple(induction.premises(*common, *induction.starts(line, mode)) for line in lines)
    rates = induction.field(mode)
    return System(induction.premises(*common), starts, induction.aim(mode), rates, tuple(_sight(induction, mode)))


def _sight(induction: Induction, mode: str) -> Iterator[Polynomial]:
    """The sums that the rates of a mode are written with."""
    scope, found = induction.scope(mode), set[Polynomial]()
    for line in induction.mode(mode).flow:
        for e in nodes(line.rate) if isinstance(line.rate, Expr) else ():
            cases = scope.cases(e) if e.op in ("+", "-") and e is not line.rate else []
            p = cases[0].numerator if len(cases) == 1 and cases[0].denominator.constant else None
            if p is not None and p.constant is None and p not in found and len(found) < MOST_SIGHTS:
                found.add(p)
                yield p
