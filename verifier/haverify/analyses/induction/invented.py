"""Invariants that are found: cuts of `analyses.synthesis` as formulas and the proofs that the flows keep them."""

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
    from haverify.analyses.synthesis.system import Cut, Hybrid, System

Json = Any
MOST_SIGHTS = 20


@record
class Invented:
    """A formula for each mode, and a FLOW that keeps it there."""

    formulas: dict[str, Formula]
    flows: dict[str, Json]


def applies(induction: Induction) -> bool:
    """Whether an invariant is searched for: where there is nothing that would wrongly be taken for constant."""
    return not (induction.functions.known or induction.inputs)


def invent(induction: Induction, seconds: float) -> Invented | None:
    """Cuts that hold at all starts, are kept and imply the goal."""
    if not applies(induction):
        return None
    from haverify.analyses.synthesis.modes import invent_modes
    from haverify.analyses.synthesis.saturate import invent as saturate

    modes = [m.name for m in induction.automaton.modes]
    try:
        if len(modes) == 1 and not induction.automaton.edges:
            cuts = saturate(system_of(induction, modes[0]), seconds)
            found = None if cuts is None else {modes[0]: cuts}
        else:
            found = invent_modes(hybrid_of(induction), seconds)
    except OverflowError:  # a number beyond the floats in which candidates are sampled
        return None
    return None if found is None else _told(found)


def _told(found: dict[str, list[Cut]]) -> Invented:
    """The cuts as formulas, and as flows whose starts and ends follow at a glance."""
    flows = {}
    for m, cuts in found.items():
        told = [{"formula": formula_json(conjunction(cut.literals)), "start": "t", "keep": cut.rule} for cut in cuts]
        flows[m] = {"cuts": told, "end": "t"}
    return Invented({m: conjunction(q for cut in cuts for q in cut.literals) for m, cuts in found.items()}, flows)


def hybrid_of(induction: Induction) -> Hybrid:
    """What is searched for in all modes, and the edges between them."""
    from haverify.analyses.synthesis.system import Hybrid, Jump

    jumps = tuple(
        Jump(e.source, e.target, induction.premises(*induction.jump(k)), induction.landing(k))
        for k, e in enumerate(induction.automaton.edges)
    )
    return Hybrid({m.name: system_of(induction, m.name) for m in induction.automaton.modes}, jumps)


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
