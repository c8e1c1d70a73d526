"""HA305: a plain edge of a clock whose guard opens well before the domain ends."""

from __future__ import annotations

import re
from collections.abc import Iterator
from fractions import Fraction

from haverify.diagnostics.diagnostic import Diagnostic, Edit, Fix, Label
from haverify.lint._facts import Facts
from haverify.lint._registry import rule
from haverify.lint._wording import edge_name, quantity
from haverify.model.expression import Expr
from haverify.model.hybrid import Edge, HybridAutomaton, Mode
from haverify.model.spec import Spec
from haverify.solvers.literals import TooManyCasesError, terms
from haverify.text.span import Span


@rule("HA305")
def lazy_edge(spec: Spec, facts: Facts) -> Iterator[Diagnostic]:
    """Only the single edge of a mode, with a threshold on a variable of constant positive slope as its whole guard."""
    for automaton in spec.automata:
        for mode in automaton.modes:
            edges = [e for e in automaton.edges if e.source == mode.name]
            if len(edges) == 1 and not edges[0].urgent and edges[0].name not in facts.synced:
                yield from _check(facts, automaton, mode, edges[0])


def _check(facts: Facts, automaton: HybridAutomaton, mode: Mode, edge: Edge) -> Iterator[Diagnostic]:
    opens = _threshold(facts, automaton, mode, edge.guard)
    if opens is None or not _is_clock(mode, opens[0]):
        return
    ends = _end(facts, automaton, mode, opens[0])
    if ends is None or ends[1] <= opens[1]:
        return
    variable, start = opens
    unit = facts.scope(automaton).vars[variable].unit
    yield Diagnostic(
        "HA305",
        f"{edge_name(edge)} may fire from {variable} = {quantity(start, unit)} on, but the run may stay in mode "
        f"{mode.name} up to {quantity(ends[1], unit)}",
        span=edge.guard.span or edge.span,
        labels=(Label(ends[0].span, "the domain ends here"),) if ends[0].span else (),
        help="if it has to fire when its guard opens, write `urgent edge`",
        fix=_fix(facts, edge),
        key=f"{automaton.name}: {edge_name(edge)} may wait",
    )


def _is_clock(mode: Mode, variable: str) -> bool:
    rate = next((f.rate for f in mode.flow if f.var == variable), None)
    return isinstance(rate, Expr) and rate.op == "num" and isinstance(rate.args[0], Fraction) and rate.args[0] > 0


def _threshold(facts: Facts, automaton: HybridAutomaton, mode: Mode, guard: Expr) -> tuple[str, Fraction] | None:
    """`variable` and bound of a guard `variable > bound` or `variable >= bound`."""
    if guard.op not in (">", ">=") or guard.children[0].op != "var":
        return None
    value = _constant(facts, automaton, mode, guard.children[1])
    return None if value is None else (guard.children[0].name, value)


def _end(facts: Facts, automaton: HybridAutomaton, mode: Mode, variable: str) -> tuple[Expr, Fraction] | None:
    """The conjunct of the domain that bounds the variable from above, and its bound."""
    found = []
    for c in mode.domain.children if mode.domain.op == "and" else (mode.domain,):
        if c.op in ("<", "<=") and c.children[0].op == "var" and c.children[0].name == variable:
            value = _constant(facts, automaton, mode, c.children[1])
            if value is not None:
                found.append((c, value))
    return min(found, key=lambda f: f[1], default=None)


def _constant(facts: Facts, automaton: HybridAutomaton, mode: Mode, e: Expr) -> Fraction | None:
    try:
        found = terms(e, facts.frame(automaton, mode))
    except TooManyCasesError:
        return None
    return found[0][1].constant if len(found) == 1 else None


def _fix(facts: Facts, edge: Edge) -> Fix | None:
    """`urgent` before the word `edge`."""
    found = re.search(r"\bedge\b", facts.text(edge.span))
    if edge.span is None or found is None:
        return None
    at = edge.span.start + found.start()
    return Fix("make the edge urgent", (Edit(Span(edge.span.path, at, at), "urgent "),))
