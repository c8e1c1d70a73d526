"""HA305: a plain edge of a clock whose guard opens well before the domain ends."""

from __future__ import annotations

import re
from collections.abc import Iterator
from fractions import Fraction

from haverify.diagnostics.diagnostic import Diagnostic, Edit, Fix, Label
from haverify.lint._facts import Facts
from haverify.lint._registry import rule
from haverify.lint._wording import edge_name, quantity
from haverify.lint.slot_gap import bound
from haverify.model.expression import Expr
from haverify.model.hybrid import Edge, HybridAutomaton, Mode
from haverify.model.spec import Spec
from haverify.solvers.literals import number_of
from haverify.text.record import record
from haverify.text.span import Span


@rule("HA305")
def lazy_edge(spec: Spec, facts: Facts) -> Iterator[Diagnostic]:
    """Only the single edge of a mode, with a threshold on a variable of constant positive slope as its whole guard."""
    for automaton in filter(facts.has_start, spec.automata):
        found = [w for mode in automaton.modes if (w := _waiting(facts, automaton, mode)) is not None]
        if found:
            yield _finding(facts, automaton, found)


@record
class Waiting:
    """An edge that may fire from `opens` on while the domain lasts until `ends`, as `end` says."""

    edge: Edge
    variable: str
    opens: Fraction
    ends: Fraction
    end: Expr


def _waiting(facts: Facts, automaton: HybridAutomaton, mode: Mode) -> Waiting | None:
    edges = [e for e in automaton.edges if e.source == mode.name]
    if len(edges) != 1 or edges[0].urgent or edges[0].name in facts.synced:
        return None
    opens = _threshold(facts, automaton, mode, edges[0].guard)
    if opens is None or not _is_clock(mode, opens[0]):
        return None
    ends = bound(facts, automaton, mode, opens[0], "<")
    return Waiting(edges[0], *opens, *ends) if ends is not None and ends[0] > opens[1] else None


def _finding(facts: Facts, automaton: HybridAutomaton, found: list[Waiting]) -> Diagnostic:
    """One message for an automaton: its other edges of this kind are named in a note."""
    w, *others = found
    unit = facts.scope(automaton).vars[w.variable].unit
    return Diagnostic(
        "HA305",
        f"{edge_name(w.edge)} may fire from {w.variable} = {quantity(w.opens, unit)} on, but the run may stay in mode "
        f"{w.edge.source} up to {quantity(w.ends, unit)}",
        span=w.edge.guard.span or w.edge.span,
        labels=(Label(w.end.span, "the domain ends here"),) if w.end.span else (),
        notes=("the same holds for " + ", ".join(edge_name(o.edge) for o in others),) if others else (),
        help="if it has to fire when its guard opens, write `urgent edge`",
        fix=_fix(facts, [o.edge for o in found]),
        key=f"{automaton.name}: {edge_name(w.edge)} may wait",
    )


def _is_clock(mode: Mode, variable: str) -> bool:
    rate = next((f.rate for f in mode.flow if f.var == variable), None)
    return isinstance(rate, Expr) and rate.op == "num" and isinstance(rate.args[0], Fraction) and rate.args[0] > 0


def _threshold(facts: Facts, automaton: HybridAutomaton, mode: Mode, guard: Expr) -> tuple[str, Fraction] | None:
    """`variable` and bound of a guard `variable > bound` or `variable >= bound`."""
    if guard.op not in (">", ">=") or guard.children[0].op != "var":
        return None
    value = number_of(guard.children[1], facts.frame(automaton, mode))
    return None if value is None else (guard.children[0].name, value)


def _fix(facts: Facts, edges: list[Edge]) -> Fix | None:
    """`urgent` before the word `edge` of each."""
    edits = []
    for edge in edges:
        found = re.search(r"\bedge\b", facts.text(edge.span))
        if edge.span is None or found is None:
            return None
        at = edge.span.start + found.start()
        edits.append(Edit(Span(edge.span.path, at, at), "urgent "))
    return Fix("make the edges urgent" if len(edges) > 1 else "make the edge urgent", tuple(dict.fromkeys(edits)))
