"""Every condition of a spec, with the place it stands in."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from haverify.lint._facts import Facts
from haverify.lint._wording import edge_name
from haverify.model.expression import Expr, nodes
from haverify.model.hybrid import HybridAutomaton, Init, Input, Param, Range, Variable
from haverify.solvers.frame import Frame
from haverify.text.record import record


@record
class Formula:
    """A condition and what it is: `kind` is domain, guard, init, assumption or claim; `place` names its owner."""

    expr: Expr
    frame: Frame
    kind: str
    place: str
    automaton: HybridAutomaton | None = None


def formulas(facts: Facts) -> Iterator[Formula]:
    """The conditions of all automata, then the assumptions, then the claims."""
    for automaton in facts.spec.automata:
        yield from _of_automaton(facts, automaton)
    for assumption in facts.spec.assumptions:
        yield Formula(assumption, facts.frame(None), "assumption", "the assumption")
    for claim in facts.spec.claims:
        automaton_of = facts.automata.get(claim.on or "")
        frame = facts.frame(automaton_of)
        for assumption in claim.assume:
            yield Formula(assumption, frame, "assumption", f"the assumption of {claim.name}", automaton_of)
        for goal in claim.goals:
            yield Formula(goal.condition, frame, "claim", f"{claim.kind} {claim.name}", automaton_of)


def _of_automaton(facts: Facts, automaton: HybridAutomaton) -> Iterator[Formula]:
    modes = facts.modes(automaton)
    for mode in automaton.modes:
        yield Formula(mode.domain, facts.frame(automaton, mode), "domain", f"the domain of mode {mode.name}", automaton)
    for edge in automaton.edges:
        frame = facts.frame(automaton, modes[edge.source])
        yield Formula(edge.guard, frame, "guard", f"the guard of {edge_name(edge)}", automaton)
    for init in automaton.init:
        frame = facts.frame(automaton, modes.get(init.mode or ""))
        yield Formula(init.where, frame, "init", start_name(automaton, init), automaton)


def start_name(automaton: HybridAutomaton, init: Init) -> str:
    """An init line as people know it."""
    return f"init {init.mode} of {automaton.name}" if init.mode else f"init of {automaton.name}"


def ranges(facts: Facts) -> Iterator[tuple[Range, Frame, str]]:
    """Every interval that is written down, with its frame and what it bounds."""
    spec = facts.spec
    top = facts.frame(None)
    yield from _declared((*spec.params, *spec.inputs), top)
    yield from ((c.value, top, c.name) for c in spec.constants if isinstance(c.value, Range))
    for automaton in spec.automata:
        frame = facts.frame(automaton)
        yield from _declared((*automaton.params, *automaton.inputs, *automaton.vars), frame)
        yield from ((c.value, frame, c.name) for c in automaton.constants if isinstance(c.value, Range))
        yield from _dynamic(facts, automaton)
    for claim in spec.claims:
        yield from ((r, top, name) for name, r in claim.which)
        windows = (Range(*g.window) for g in claim.goals if g.window is not None)
        yield from ((w, top, f"the window of property {claim.name}") for w in windows)


def _declared(owners: Iterable[Param | Input | Variable], frame: Frame) -> Iterator[tuple[Range, Frame, str]]:
    for owner in owners:
        if owner.range is not None:
            yield owner.range, frame, owner.name
        if isinstance(owner, Input) and owner.rate is not None:
            yield owner.rate, frame, f"{owner.name}'"


def _dynamic(facts: Facts, automaton: HybridAutomaton) -> Iterator[tuple[Range, Frame, str]]:
    modes = facts.modes(automaton)
    for mode in automaton.modes:
        frame = facts.frame(automaton, mode)
        yield from ((f.rate, frame, f"{f.var}'") for f in mode.flow if isinstance(f.rate, Range))
    for edge in automaton.edges:
        frame = facts.frame(automaton, modes[edge.source])
        yield from ((a.to, frame, a.var) for a in edge.resets if isinstance(a.to, Range))


def written_in(parts: Sequence[Expr], whole: Expr) -> list[Expr]:
    """Those of `parts` that stand in the text of `whole`."""
    spans = {n.span for n in nodes(whole) if n.span is not None}
    return [e for e in parts if e.span in spans]
