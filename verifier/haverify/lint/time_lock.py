"""HA303: a state that a run reaches where time cannot pass and no edge is enabled."""

from __future__ import annotations

from collections.abc import Iterator

from haverify.diagnostics.diagnostic import Diagnostic, Label
from haverify.lint._clock import Lock, locks
from haverify.lint._facts import Facts
from haverify.lint._registry import rule
from haverify.lint._wording import edge_name, mentioned, point_text
from haverify.maths.polynomial import constant
from haverify.model.expression import Expr, nodes, rebuild
from haverify.model.hybrid import Edge, HybridAutomaton
from haverify.model.spec import Spec
from haverify.solvers.frame import Frame
from haverify.solvers.literals import number_of
from haverify.text.record import replace


@rule("HA303")
def time_lock(spec: Spec, facts: Facts) -> Iterator[Diagnostic]:
    """On concrete runs of clock-driven automata, walked exactly; one finding for each mode."""
    for automaton in spec.automata:
        edges = {e.name for e in automaton.edges}
        if not edges & facts.synced and facts.has_start(automaton):
            found = {lock.mode.name: lock for lock in reversed(list(locks(facts, automaton)))}
            for mode in automaton.modes:
                if mode.name in found:
                    yield _finding(facts, automaton, found[mode.name])


def _finding(facts: Facts, automaton: HybridAutomaton, lock: Lock) -> Diagnostic:
    mode = lock.mode
    edges = [e for e in automaton.edges if e.source == mode.name]
    ends = [c for c in _conjuncts(mode.domain) if _is_met_with_equality(facts, automaton, lock, c)]
    names = [n for c in ends for n in mentioned(c)] or list(lock.values)
    at = point_text(lock.values, facts.scope(automaton), names)
    needs = [f"{e.name or edge_name(e)} needs {facts.text(e.guard.span)}" for e in edges if facts.text(e.guard.span)]
    reason = f"no guard holds ({'; '.join(needs)})" if needs else "no edge is enabled" if edges else "no edge leads on"
    closed = _closed_guard(facts, automaton, lock, edges)
    return Diagnostic(
        "HA303",
        f"mode {mode.name}: at {at} the flow leaves the domain and {reason}",
        span=(ends[0].span if ends else None) or mode.span,
        label="the domain ends here",
        labels=tuple(Label(e.guard.span, "does not hold there") for e in edges if e.guard.span),
        notes=(f"a run reaches this state: {point_text(lock.values, facts.scope(automaton))}",),
        help=f"include the bound: `when {closed}`"
        if closed
        else "add an edge for this state, or mark the mode `terminal`",
        key=f"{automaton.name}, mode {mode.name}: the flow leaves the domain and no edge is enabled",
    )


def _conjuncts(e: Expr) -> tuple[Expr, ...]:
    return e.children if e.op == "and" else (e,)


def _at(facts: Facts, automaton: HybridAutomaton, lock: Lock) -> Frame:
    values = {n: constant(v) for n, v in lock.values.items()}
    return facts.frame(automaton, lock.mode).after(lock.mode, values)


def _is_met_with_equality(facts: Facts, automaton: HybridAutomaton, lock: Lock, e: Expr) -> bool:
    frame = _at(facts, automaton, lock)
    sides = [number_of(c, frame) for c in e.children] if e.op in ("<", "<=", ">", ">=", "==") else []
    return len(sides) == 2 and sides[0] is not None and sides[0] == sides[1]


def _closed_guard(facts: Facts, automaton: HybridAutomaton, lock: Lock, edges: list[Edge]) -> str | None:
    """The text of a strict comparison that is all that keeps an edge from firing, with its bound included."""
    for edge in edges:
        for atom in nodes(edge.guard):
            text = facts.text(atom.span)
            if atom.op not in ("<", ">") or text.count(atom.op) != 1:
                continue
            if _is_met_with_equality(facts, automaton, lock, atom):
                closed = Expr(atom.op + "=", atom.args, atom.unit, atom.span)
                if facts.edge_state(automaton, replace(edge, guard=_put(edge.guard, atom, closed))).kind == "live":
                    return text.replace(atom.op, atom.op + "=")
    return None


def _put(e: Expr, old: Expr, new: Expr) -> Expr:
    return new if e == old else rebuild(e, lambda child: _put(child, old, new))
