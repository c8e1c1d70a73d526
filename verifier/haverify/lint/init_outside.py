"""HA307: a start that lies outside the domain of its mode, or that does not exist at all."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from haverify.diagnostics.diagnostic import Diagnostic, Label
from haverify.lint._facts import Facts, Outcome, allowed
from haverify.lint._formulas import start_name, written_in
from haverify.lint._registry import rule
from haverify.lint._wording import point_text, quantity
from haverify.model.expression import Expr
from haverify.model.hybrid import HybridAutomaton, Init, Mode
from haverify.model.spec import Spec
from haverify.solvers.answer import Contradiction, Holds
from haverify.solvers.conditions import Condition, decide
from haverify.solvers.frame import Frame
from haverify.solvers.literals import TooManyCasesError, terms


@rule("HA307")
def init_outside(spec: Spec, facts: Facts) -> Iterator[Diagnostic]:
    """A start condition that contradicts itself is HA201 or HA202, an empty domain too."""
    for automaton in spec.automata:
        for init in automaton.init:
            yield from _check(facts, automaton, init)


def _check(facts: Facts, automaton: HybridAutomaton, init: Init) -> Iterator[Diagnostic]:
    modes = [m for m in allowed(automaton, init) if not _is_empty(facts, automaton, m)]
    answers = [(m, facts.start(automaton, m, init)) for m in modes]
    if not answers or not all(isinstance(a, Contradiction) for _, a in answers):
        return
    anywhere = facts.start(automaton, modes[0], init, in_domain=None)
    if not isinstance(anywhere, Contradiction):
        mode, answer = answers[0]
        assert isinstance(answer, Contradiction)
        yield _finding(facts, automaton, init, mode, answer.core, anywhere if isinstance(anywhere, Holds) else None)
    elif init.assigns and init.where.op != "true" and not _contradicts_itself(facts, automaton, modes[0], init):
        yield _empty(facts, automaton, init)


def _is_empty(facts: Facts, automaton: HybridAutomaton, mode: Mode) -> bool:
    frame = facts.frame(automaton, mode)
    return isinstance(decide([Condition(mode.domain, frame, closed=True)]), Contradiction)


def _contradicts_itself(facts: Facts, automaton: HybridAutomaton, mode: Mode, init: Init) -> bool:
    return isinstance(decide([Condition(init.where, facts.frame(automaton, mode))]), Contradiction)


def _empty(facts: Facts, automaton: HybridAutomaton, init: Init) -> Diagnostic:
    return Diagnostic(
        "HA307",
        f"{start_name(automaton, init)} allows no start: its condition is false after its assignments",
        span=init.where.span or init.span,
        labels=tuple(Label(a.span) for a in init.assigns if a.span),
        notes=(f"`{facts.text(init.where.span)}` is false for the values assigned",) if init.where.span else (),
        key=f"{start_name(automaton, init)} is empty",
    )


def _finding(
    facts: Facts, automaton: HybridAutomaton, init: Init, mode: Mode, core: tuple[Expr, ...], start: Holds | None
) -> Diagnostic:
    needs = written_in(core, mode.domain) or [mode.domain]
    after = _after(facts, automaton, init, mode)
    values = _assigned_text(facts, automaton, after)
    if start and not values:
        values = point_text(start.point, facts.scope(automaton))
    subject = f"{start_name(automaton, init)} starts outside the domain of mode {mode.name}"
    needed = " and ".join(f"`{facts.text(e.span)}`" for e in needs)
    return Diagnostic(
        "HA307",
        f"{start_name(automaton, init)} starts outside the domain of mode {mode.name}"
        + (f", at {values}" if values else ""),
        span=init.span,
        labels=tuple(Label(e.span, _value_of(e, after)) for e in needs if e.span),
        notes=(f"the domain of mode {mode.name} needs {needed}, so the automaton has no run from here",),
        key=subject,
    )


def _after(facts: Facts, automaton: HybridAutomaton, init: Init, mode: Mode) -> Frame:
    frame = facts.frame(automaton, mode)
    try:
        outcomes: list[Outcome] = facts.outcomes(frame, init.assigns)
    except TooManyCasesError:
        return frame
    return frame.after(mode, outcomes[0].values) if len(outcomes) == 1 else frame


def _assigned_text(facts: Facts, automaton: HybridAutomaton, after: Frame) -> str:
    fixed = {n: v for n, p in after.values.items() if (v := p.constant) is not None}
    return point_text(fixed, facts.scope(automaton))


def _value_of(comparison: Expr, after: Frame) -> str:
    """`theta_h is -1510.2 deg here`: the sides of a comparison that are no plain numbers, with their values."""
    shown = []
    for side in comparison.children:
        value = _constant(side, after)
        if side.op in ("let", "var") and value is not None:
            shown.append(f"{side.name} is {quantity(value, side.unit)} at the start")
    return ", ".join(shown)


def _constant(e: Expr, frame: Frame) -> Fraction | None:
    try:
        found = terms(e, frame)
    except TooManyCasesError:
        return None
    return found[0][1].constant if len(found) == 1 else None
