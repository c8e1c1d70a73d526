"""HA307: a start that lies outside the domain of its mode, or that does not exist at all."""

from __future__ import annotations

from collections.abc import Iterator

from haverify.diagnostics.diagnostic import Diagnostic, Label
from haverify.lint._facts import Facts, Outcome, allowed
from haverify.lint._formulas import Formula, start_name
from haverify.lint._registry import rule
from haverify.lint._wording import point_text, quantity
from haverify.lint.empty_interval import empty_bounds
from haverify.model.expression import Expr
from haverify.model.hybrid import HybridAutomaton, Init, Mode
from haverify.model.spec import Spec
from haverify.solvers.answer import Contradiction, Holds
from haverify.solvers.conditions import Condition, decide
from haverify.solvers.frame import Frame
from haverify.solvers.literals import TooManyCasesError, number_of


@rule("HA307")
def init_outside(spec: Spec, facts: Facts) -> Iterator[Diagnostic]:
    """A start condition that contradicts itself is HA201 or HA202, an empty domain too."""
    for automaton in spec.automata:
        for init in automaton.init:
            yield from _check(facts, automaton, init)


def _check(facts: Facts, automaton: HybridAutomaton, init: Init) -> Iterator[Diagnostic]:
    modes = [m for m in allowed(automaton, init) if not _is_backwards(facts, automaton, m)]
    answers = [facts.start(automaton, m, init) for m in modes]
    if not answers or not all(isinstance(a, Contradiction) for a in answers):
        return
    mode = modes[0]
    anywhere = facts.start(automaton, mode, init, in_domain=None)
    if not isinstance(anywhere, Contradiction):
        yield _finding(facts, automaton, init, mode, anywhere if isinstance(anywhere, Holds) else None)
    elif init.assigns and init.where.op != "true" and not _contradicts_itself(facts, automaton, mode, init):
        yield _empty(facts, automaton, init)


def _is_backwards(facts: Facts, automaton: HybridAutomaton, mode: Mode) -> bool:
    formula = Formula(mode.domain, facts.frame(automaton, mode), "domain", mode.name)
    return any(True for _ in empty_bounds(formula))


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


def _finding(facts: Facts, automaton: HybridAutomaton, init: Init, mode: Mode, start: Holds | None) -> Diagnostic:
    after = _after(facts, automaton, init, mode)
    needs = _violated(mode, after) or [mode.domain]
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


def _violated(mode: Mode, after: Frame) -> list[Expr]:
    """The conjuncts of the domain that are false at the start, whatever the rest."""
    parts = mode.domain.children if mode.domain.op == "and" else (mode.domain,)
    return [c for c in parts if isinstance(decide([Condition(c, after, closed=True)]), Contradiction)]


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
        value = number_of(side, after)
        if side.op in ("let", "var") and value is not None:
            shown.append(f"{side.name} is {quantity(value, side.unit)} at the start")
    return ", ".join(shown)
