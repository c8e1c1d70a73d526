"""Cycles of edges that a run could pass without time passing."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from haverify.lint._facts import AFTER, Facts, any_of
from haverify.lint._wording import edge_name
from haverify.lint.overlapping_guards import has_equality
from haverify.maths.polynomial import variable
from haverify.model.hybrid import Edge, HybridAutomaton
from haverify.solvers.answer import Answer, Holds, Undecided
from haverify.solvers.conditions import Condition
from haverify.solvers.frame import Frame
from haverify.solvers.literals import Case, Literal, TooManyCasesError

LONGEST = 4
MOST = 200

Cycle = tuple[Edge, ...]


def cycles(facts: Facts, automaton: HybridAutomaton) -> Iterator[Cycle]:
    """The simple cycles of at most LONGEST edges that wait for nothing: each edge urgent, or named by an event.

    Edges in a `sync` never fire alone and are left out; so are all cycles past the first MOST.
    """
    edges = [e for e in automaton.edges if (e.urgent or has_equality(e)) and e.name not in facts.synced]
    order = {m.name: k for k, m in enumerate(automaton.modes)}
    found = 0
    for mode in automaton.modes:
        for cycle in _from(edges, (), mode.name, mode.name, order):
            found += 1
            if found > MOST:
                return
            yield cycle


def _from(edges: Sequence[Edge], path: Cycle, at: str, start: str, order: dict[str, int]) -> Iterator[Cycle]:
    """Ways back to `start` through modes declared after it, each mode once."""
    for e in edges:
        if e.source != at:
            continue
        if e.target == start:
            yield (*path, e)
        elif order[e.target] > order[start] and len(path) + 1 < LONGEST and all(e.target != p.source for p in path):
            yield from _from(edges, (*path, e), e.target, start, order)


def returns(facts: Facts, code: str, automaton: HybridAutomaton, cycle: Cycle, closed: bool = False) -> Answer:
    """Whether some state passes all edges of the cycle at one instant and is the same afterwards.

    `closed` reads the guards as closed sets: such a state may only be approached.
    """
    modes = facts.modes(automaton)
    place = ", ".join(edge_name(e) for e in cycle)
    ways: list[tuple[Frame, list[Condition], Case]] = [(facts.frame(automaton, modes[cycle[0].source]), [], ())]
    try:
        for number, edge in enumerate(cycle):
            ways = [w for way in ways for w in _step(facts, automaton, edge, way, AFTER * (number + 1), closed)]
    except TooManyCasesError:
        facts.leave_open(code, place, "the resets have too many cases", cycle[0].span)
        return Undecided("the resets have too many cases")
    answers = [facts.decide(code, place, cycle[0].span, c, (*case, *_same(frame))) for frame, c, case in ways]
    return any_of(answers)


def _step(
    facts: Facts,
    automaton: HybridAutomaton,
    edge: Edge,
    way: tuple[Frame, list[Condition], Case],
    mark: str,
    closed: bool,
) -> Iterator[tuple[Frame, list[Condition], Case]]:
    frame, conditions, case = way
    modes = facts.modes(automaton)
    now = [Condition(modes[edge.source].domain, frame, closed=True), Condition(edge.guard, frame, closed=closed)]
    for o in facts.outcomes(frame, edge.resets, mark):
        after = frame.after(modes[edge.target], o.values)
        yield after, [*conditions, *now, Condition(modes[edge.target].domain, after, closed=True)], case + o.case


def _same(frame: Frame) -> Case:
    return tuple(Literal(value - variable(name), "==") for name, value in sorted(frame.values.items()))


def is_identity(cycle: Cycle) -> bool:
    """Whether no edge of the cycle changes anything."""
    return not any(e.resets for e in cycle)


def is_reached(facts: Facts, automaton: HybridAutomaton, cycle: Cycle, answer: Holds) -> bool:
    """Whether a run certainly starts at the state found; where the cycle changes nothing, in any of its modes."""
    modes = facts.modes(automaton)
    where = cycle if is_identity(cycle) else cycle[:1]
    return answer.is_exact and any(facts.is_start(automaton, modes[e.source], answer.point) for e in where)
