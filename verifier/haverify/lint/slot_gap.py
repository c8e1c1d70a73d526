"""HA204: a gap or an overlap between the slots of a variable that an edge joins without resetting it."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from haverify.diagnostics.diagnostic import Diagnostic, Edit, Fix, Label, Severity
from haverify.lint._facts import Facts
from haverify.lint._registry import rule
from haverify.lint._wording import edge_name, quantity
from haverify.model.expression import Expr, nodes
from haverify.model.hybrid import Edge, HybridAutomaton, Mode
from haverify.model.spec import Spec
from haverify.solvers.literals import number_of
from haverify.text.record import record

_FLIPPED = {"<": ">", "<=": ">=", ">": "<", ">=": "<="}


@record
class Meeting:
    """Where the source's slot of `variable` ends and the target's begins."""

    edge: Edge
    variable: str
    ends: Fraction
    end: Expr
    begins: Fraction
    begin: Expr


@rule("HA204")
def slot_gap(spec: Spec, facts: Facts) -> Iterator[Diagnostic]:
    """A gap means that the edge can never be taken: then this is an error. An overlap counts where no guard decides."""
    for automaton in spec.automata:
        for m in meetings(facts, automaton):
            if m.begins > m.ends:
                yield _gap(facts, automaton, m)
            elif m.begins < m.ends and _is_slot(facts, automaton, m) and not _is_guarded(m):
                yield _overlap(facts, automaton, m)


def meetings(facts: Facts, automaton: HybridAutomaton) -> Iterator[Meeting]:
    """For each edge, the variables it keeps, bounded above before it and below after it, and growing on the way."""
    modes = facts.modes(automaton)
    for edge in automaton.edges:
        kept = [v.name for v in automaton.vars if all(a.var != v.name for a in edge.resets)]
        for name in kept:
            end = bound(facts, automaton, modes[edge.source], name, "<")
            begin = bound(facts, automaton, modes[edge.target], name, ">")
            if end and begin and edge.source != edge.target:
                yield Meeting(edge, name, end[0], end[1], begin[0], begin[1])


def bound(facts: Facts, automaton: HybridAutomaton, mode: Mode, name: str, side: str) -> tuple[Fraction, Expr] | None:
    """The tightest constant bound on a variable in a domain, above (`<`) or below (`>`), and the number as written."""
    found = []
    for c in mode.domain.children if mode.domain.op == "and" else (mode.domain,):
        if c.op in _FLIPPED:
            left, right = c.children
            op = c.op if left.op == "var" else _FLIPPED[c.op]
            var, limit = (left, right) if left.op == "var" else (right, left)
            value = number_of(limit, facts.frame(automaton, mode)) if var.op == "var" and var.name == name else None
            if value is not None and op[0] == side:
                found.append((value, limit))
    if not found:
        return None
    return min(found, key=lambda f: f[0]) if side == "<" else max(found, key=lambda f: f[0])


def _is_slot(facts: Facts, automaton: HybridAutomaton, m: Meeting) -> bool:
    """Whether the two domains look like consecutive slots: bounded on both sides, the second one later."""
    modes = facts.modes(automaton)
    starts = bound(facts, automaton, modes[m.edge.source], m.variable, ">")
    closes = bound(facts, automaton, modes[m.edge.target], m.variable, "<")
    return starts is not None and closes is not None and starts[0] < m.begins and m.ends < closes[0]


def _is_guarded(m: Meeting) -> bool:
    return any(n.op == "var" and n.name == m.variable for n in nodes(m.edge.guard))


def _gap(facts: Facts, automaton: HybridAutomaton, m: Meeting) -> Diagnostic:
    unit = facts.scope(automaton).vars[m.variable].unit
    text = facts.text(m.end.span)
    fix = Fix("begin where the previous slot ends", (Edit(m.begin.span, text),)) if m.begin.span and text else None
    return Diagnostic(
        "HA204",
        f"{m.variable} in {quantity(m.ends, unit)} .. {quantity(m.begins, unit)} belongs to no slot: "
        f"{edge_name(m.edge)} can never be taken",
        span=m.begin.span or m.edge.span,
        label=f"mode {m.edge.target} begins here",
        labels=(Label(m.end.span, f"mode {m.edge.source} ends here"),) if m.end.span else (),
        help=f"begin where the previous slot ends: `{text}`" if text else None,
        fix=fix,
        key=f"{automaton.name}: gap of {m.variable} at {edge_name(m.edge)}",
        severity=Severity.ERROR,
    )


def _overlap(facts: Facts, automaton: HybridAutomaton, m: Meeting) -> Diagnostic:
    unit = facts.scope(automaton).vars[m.variable].unit
    return Diagnostic(
        "HA204",
        f"{m.variable} in {quantity(m.begins, unit)} .. {quantity(m.ends, unit)} belongs to two slots, "
        f"{m.edge.source} and {m.edge.target}",
        span=m.begin.span or m.edge.span,
        label=f"mode {m.edge.target} begins here",
        labels=(Label(m.end.span, f"mode {m.edge.source} ends here"),) if m.end.span else (),
        help=f"let one end where the other begins, or guard the edge: `when {m.variable} >= ...`",
        key=f"{automaton.name}: overlap of {m.variable} at {edge_name(m.edge)}",
    )
