"""Concrete runs of clock-driven automata, walked exactly from event to event, to find states where they get stuck."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from itertools import pairwise

from haverify.analyses.motion import NOW, Motion, State
from haverify.maths.sturm import isolate, refine
from haverify.maths.univariate import integers
from haverify.obligations.formula import Formula, holds, literals
from haverify.text.record import record

MOST_STATES = 60
FAR = Fraction(1000)  # s; events later than this are not looked at


@record
class Stay:
    """What may happen in a stay: `moments` of choice, and the `end` that the domain or urgency sets.

    `is_forced` where the domain ends there; `end` is None where nothing ends the stay.
    """

    moments: tuple[Fraction, ...]
    end: Fraction | None
    is_forced: bool


def stuck_states(motion: Motion) -> Iterator[State]:
    """States that a run reaches, where the flow leaves the domain, no edge is enabled and the mode is not terminal.

    Runs fire edges at the moments where some condition changes, and between them; so what is found is certain, and
    nothing found is no proof.
    """
    todo = list(motion.starts())[:4]
    seen: set[object] = set()
    while todo and len(seen) < MOST_STATES:
        state = todo.pop(0)
        key = state.mode, tuple(sorted(state.values.items()))
        if key in seen:
            continue
        seen.add(key)
        stay = _stay(motion, state)
        if stay is None:
            continue
        if stay.end is not None and stay.is_forced and _is_stuck(motion, state, stay.end):
            yield motion.at(state, stay.end)
        todo += _successors(motion, state, stay)


def _is_stuck(motion: Motion, state: State, end: Fraction) -> bool:
    model = motion.model
    if model.mode(state.mode).terminal:
        return False
    last = motion.at(state, end)
    return not any(_fires(motion, last, k) for k in model.leaving[state.mode])


def _fires(motion: Motion, state: State, k: int) -> bool:
    has_guard = holds(motion.enabled(k), motion.known(state))
    return has_guard and any(True for _ in motion.outcomes(state, motion.model.edge(k)))


def _stay(motion: Motion, state: State) -> Stay | None:
    """None where an event is no rational number: such a state is not followed."""
    model = motion.model
    domain = motion.along(motion.domain(state.mode), state)
    gates = {k: motion.along(motion.enabled(k), state) for k in model.leaving[state.mode]}
    events = _events([domain, *gates.values()])
    if events is None:
        return None
    moments = _with_between(events)
    end, is_forced = _domain_end(domain, moments)
    for k, gate in gates.items():
        due = _due(gate, moments) if model.edge(k).urgent else None
        if due is not None and (end is None or due <= end):
            end, is_forced = due, False
    return Stay(tuple(m for m in moments if end is None or m <= end), end, is_forced)


def _events(formulas: list[Formula]) -> list[Fraction] | None:
    """The moments from 0 on at which some literal changes its sign; None where one of them is no rational."""
    found = {Fraction(0)}
    for f in formulas:
        for leaf in literals(f):
            p = integers(leaf.polynomial.univariate())[0]
            for root in isolate(p, Fraction(0), FAR):
                exact = refine(p, root)
                if exact.low != exact.high:
                    return None
                found.add(exact.low)
    return sorted(found)


def _with_between(events: list[Fraction]) -> list[Fraction]:
    """Events at even positions, a moment after each of them at odd ones."""
    after = [(a + b) / 2 for a, b in pairwise(events)] + [events[-1] + 1]
    return [m for pair in zip(events, after, strict=True) for m in pair]


def _domain_end(domain: Formula, moments: list[Fraction]) -> tuple[Fraction | None, bool]:
    for k, moment in enumerate(moments):
        if not holds(domain, {NOW: moment}):
            return moments[max(k - 1, 0)], True
    return None, False


def _due(gate: Formula, moments: list[Fraction]) -> Fraction | None:
    """The first moment at which the edge is enabled, or is at all times just after."""
    for k, moment in enumerate(moments):
        if holds(gate, {NOW: moment}):
            return moment if k % 2 == 0 else moments[k - 1]
    return None


def _successors(motion: Motion, state: State, stay: Stay) -> Iterator[State]:
    """Each edge is taken at the first and at the last moment at which it certainly can be."""
    for k in motion.model.leaving[state.mode]:
        enabled = [m for m in stay.moments if _fires(motion, motion.at(state, m), k)]
        for moment in dict.fromkeys((*enabled[:1], *enabled[-1:])):
            outcomes = motion.outcomes(motion.at(state, moment), motion.model.edge(k))
            yield from (after for after, _ in list(outcomes)[:2])
