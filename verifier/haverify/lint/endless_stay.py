"""HA310: a mode in which a run may stay for ever, read by a claim without a horizon."""

from __future__ import annotations

from collections.abc import Iterator

from haverify.diagnostics.diagnostic import Diagnostic, Label
from haverify.lint._clock import explored
from haverify.lint._facts import Facts
from haverify.lint._registry import rule
from haverify.model.claim import Claim
from haverify.model.expression import Expr, nodes
from haverify.model.hybrid import HybridAutomaton, Mode
from haverify.model.spec import Spec


@rule("HA310")
def endless_stay(spec: Spec, facts: Facts) -> Iterator[Diagnostic]:
    """For clocks: nothing ends the stay, and what the claim reads moves on meanwhile."""
    for automaton in spec.automata:
        open_ended = [c for c in spec.claims if c.on == automaton.name and _has_no_horizon(c)]
        for mode in _endless(facts, automaton) if open_ended else ():
            readers = [c for c in open_ended if _reads_what_moves(facts, automaton, mode, c)]
            if readers:
                yield _finding(automaton, mode, readers)


def _has_no_horizon(claim: Claim) -> bool:
    if claim.time is not None:
        return False
    return any(g.kind in ("always", "can_reach") and g.within is None and g.window is None for g in claim.goals)


def _endless(facts: Facts, automaton: HybridAutomaton) -> Iterator[Mode]:
    cells = explored(facts, automaton)
    ended = {c.mode: True for c in cells.cells if c.dwell is None} if cells is not None else {}
    return (m for k, m in enumerate(automaton.modes) if k in ended and not m.terminal)


def _reads_what_moves(facts: Facts, automaton: HybridAutomaton, mode: Mode, claim: Claim) -> bool:
    cells = explored(facts, automaton)
    assert cells is not None, "asked for only where the cells are known"
    slopes = cells.model.mode(cells.model.index[mode.name]).slopes
    frame = facts.frame(automaton, mode)
    stack: list[Expr] = [g.condition for g in claim.goals]
    seen: set[str] = set()
    while stack:
        for n in nodes(stack.pop()):
            if n.op == "var" and slopes.get(n.name):
                return True
            if n.op == "let" and n.name not in seen:
                seen.add(n.name)
                stack += [e for e in [frame.let(n.name)] if e is not None]
    return False


def _finding(automaton: HybridAutomaton, mode: Mode, readers: list[Claim]) -> Diagnostic:
    first, more = readers[0], len(readers) - 1
    others = f" (nor have {more} more)" if more else ""
    return Diagnostic(
        "HA310",
        f"mode {mode.name} has no upper bound on the stay, and {first.kind} {first.name} has no horizon{others}",
        span=mode.span,
        labels=(Label(first.span, "speaks of all time"),) if first.span else (),
        help="bound the domain, make an edge urgent, or add `within T` to the claim",
        key=f"{automaton.name}: mode {mode.name} has no upper bound on the stay",
    )
