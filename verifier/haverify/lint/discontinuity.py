"""HA213: an output that jumps at an edge which resets nothing it depends on."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from haverify.diagnostics.diagnostic import Diagnostic
from haverify.lint._clock import Curve, cells_of, curve
from haverify.lint._facts import Facts
from haverify.lint._reach import live_edges
from haverify.lint._registry import rule
from haverify.lint._wording import edge_name, quantity
from haverify.model.expression import Expr, nodes
from haverify.model.hybrid import Edge, HybridAutomaton, Mode, Output
from haverify.model.spec import Spec

Q = Fraction


@rule("HA213")
def discontinuity(spec: Spec, facts: Facts) -> Iterator[Diagnostic]:
    """A jump counts when it is larger than all the output moves within either of the two modes, and both move it.

    Outputs of which a claim mentions `pre` have a limit stated: there the verdict speaks.
    """
    for automaton in filter(facts.has_start, spec.automata):
        limited, edges = _limited(spec, automaton), live_edges(facts, automaton)
        for output in _outputs(automaton):
            if output.name not in limited and output.type == "real":
                for edge in edges:
                    yield from _check(facts, automaton, output, edge)


def _limited(spec: Spec, automaton: HybridAutomaton) -> set[str]:
    conditions = (g.condition for c in spec.claims if c.on == automaton.name for g in c.goals)
    before = (n for e in conditions for n in nodes(e) if n.op == "pre")
    return {n.name for p in before for n in nodes(p) if n.op == "let"}


def _outputs(automaton: HybridAutomaton) -> list[Output]:
    outputs = {o.name: o for o in automaton.lets}
    for mode in automaton.modes:
        outputs |= {o.name: o for o in mode.lets if o.name not in outputs}
    return list(outputs.values())


def _check(facts: Facts, automaton: HybridAutomaton, output: Output, edge: Edge) -> Iterator[Diagnostic]:
    modes = facts.modes(automaton)
    before = _curve(facts, automaton, modes[edge.source], output)
    after = _curve(facts, automaton, modes[edge.target], output)
    if before is None or after is None or before.variable != after.variable:
        return
    clock = before.variable
    at = facts.remembered(("instant", id(edge), clock), lambda: _instant(facts, automaton, edge, clock))
    if at is None or any(a.var == clock for a in edge.resets):
        return
    step = after.poly.value({clock: at}) - before.poly.value({clock: at})
    if abs(step) > max(_move(before.ends), _move(after.ends)):
        moves = _move(before.extremes()), _move(after.extremes())
        if min(moves) > 0 and abs(step) > max(moves):
            variable = facts.scope(automaton).vars[clock]
            yield _finding(automaton, output, edge, step, f"{variable.name} = {quantity(at, variable.unit)}", moves)


def _finding(
    automaton: HybridAutomaton, output: Output, edge: Edge, step: Q, instant: str, moves: tuple[Q, Q]
) -> Diagnostic:
    within = " and ".join(quantity(m, output.unit) for m in moves)
    return Diagnostic(
        "HA213",
        f"`{output.name}` jumps by {quantity(step, output.unit)} at {edge_name(edge)}, {instant}",
        span=output.span or edge.span,
        notes=(f"within the two modes it moves by {within}",),
        help=f"if it is meant, state it: `always jumped implies abs({output.name} - pre({output.name})) <= ...`",
        key=f"{automaton.name}: {output.name} jumps at {edge_name(edge)}",
    )


def _move(ends: tuple[Q, Q]) -> Q:
    return ends[1] - ends[0]


def _curve(facts: Facts, automaton: HybridAutomaton, mode: Mode, output: Output) -> Curve | None:
    key = ("curve", automaton.name, mode.name, output.name)
    return facts.remembered(key, lambda: curve(facts, automaton, mode, Expr("let", (output.name,))))


def _instant(facts: Facts, automaton: HybridAutomaton, edge: Edge, clock: str) -> Q | None:
    """The only value of the clock at which runs take the edge, None where there are several or none."""
    cells = cells_of(facts, automaton)
    if cells is None:
        return None
    index = next(k for k, e in enumerate(automaton.edges) if e is edge)
    exits = [x for c in cells.of_mode(cells.model.index[edge.source]) if (x := cells.exit(c, index)) is not None]
    found = {(x.before[clock].low, x.before[clock].high) for x in exits}
    low, high = found.pop() if len(found) == 1 else (None, None)
    return low if low == high else None
