"""HA308: a start condition of which the domain cuts off a part."""

from __future__ import annotations

from collections.abc import Iterator

from haverify.diagnostics.diagnostic import Diagnostic, Label
from haverify.lint._facts import Facts
from haverify.lint._formulas import start_name
from haverify.lint._registry import rule
from haverify.lint._wording import mentioned, point_text
from haverify.model.hybrid import HybridAutomaton, Init, Mode
from haverify.model.spec import Spec
from haverify.solvers.answer import Contradiction, Holds


@rule("HA308")
def init_cut(spec: Spec, facts: Facts) -> Iterator[Diagnostic]:
    """Only for a named mode, and only where the start names every variable of the domain: else the domain is meant."""
    for automaton in spec.automata:
        modes = facts.modes(automaton)
        for init in automaton.init:
            mode = modes.get(init.mode or "")
            if mode is not None and _speaks_of_all(init, mode):
                yield from _check(facts, automaton, init, mode)


def _speaks_of_all(init: Init, mode: Mode) -> bool:
    said = {*mentioned(init.where), *(a.var for a in init.assigns)}
    return set(mentioned(mode.domain)) <= said


def _check(facts: Facts, automaton: HybridAutomaton, init: Init, mode: Mode) -> Iterator[Diagnostic]:
    outside = facts.start(automaton, mode, init, in_domain=False)
    if not isinstance(outside, Holds) or not outside.is_exact:
        return
    if isinstance(facts.start(automaton, mode, init), Contradiction):
        return
    witness = point_text(outside.point, facts.scope(automaton))
    yield Diagnostic(
        "HA308",
        f"{start_name(automaton, init)} is cut by the domain of mode {mode.name}: {witness} is no start",
        span=init.span,
        labels=(Label(mode.domain.span, f"the domain of mode {mode.name}"),) if mode.domain.span else (),
        help="repeat the domain in the start condition, or start in the mode whose domain holds there",
        key=f"{start_name(automaton, init)} is cut by the domain",
    )
