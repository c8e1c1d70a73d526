"""Inputs with bounded rates as variables: any slope within the bounds, and runs are judged while values are in range.

Such an input is a continuous function of time with slopes between two numbers, and jumps leave it alone (LANGUAGE S3):
a variable with an inclusion for its flow, whose start is any value of the range. Flows that leave the range are those
of no input. Where the range alone shows a claim, it is the sharper bound after some time; this is for the others, and
for inputs in conditions and resets, which flowpipes cannot drive.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from haverify.model.claim import Claim
from haverify.model.expression import Expr, nodes, rebuild
from haverify.model.hybrid import Assign, Edge, FlowLine, HybridAutomaton, Init, Input, Mode, Output, Range, Variable
from haverify.model.spec import Spec
from haverify.text.record import record, replace

Change = Callable[[Expr], Expr]


@record
class Rated:
    """A claim on an automaton in which inputs are variables, and the spec that they belong to."""

    spec: Spec
    automaton: HybridAutomaton
    claim: Claim


def with_rates(spec: Spec, automaton: HybridAutomaton, claim: Claim) -> Rated | None:
    """The same claim where inputs with bounded rates are variables; None where the automaton and the claim read none.

    Soundness           the runs of the automaton are, inputs included, those that are judged to their end
    """
    read = {n.name for e in _expressions(automaton, claim) for n in nodes(e) if n.op == "input"}
    taken = {v.name for v in automaton.vars}
    inputs = [i for i in (*spec.inputs, *automaton.inputs) if i.name in read and _has_rate(i)]
    if not inputs or any(i.name in taken for i in inputs) or automaton.is_system:
        return None
    names = {i.name for i in inputs}

    def moved(e: Expr) -> Expr:
        return Expr("var", e.args, e.unit, e.span) if e.op == "input" and e.name in names else rebuild(e, moved)

    rated = _moved_automaton(automaton, inputs, moved)
    bounds = tuple(b for i in inputs for b in _bounds(i))
    claims = {c.name: _moved_claim(c, moved) for c in spec.claims}
    made = replace(
        spec,
        inputs=tuple(i for i in spec.inputs if i.name not in names),
        assumptions=(*map(moved, spec.assumptions), *bounds),
        automata=tuple(rated if a is automaton else a for a in spec.automata),
        claims=tuple(claims.values()),
    )
    return Rated(made, rated, _moved_claim(claim, moved))


def _has_rate(i: Input) -> bool:
    return i.type == "real" and i.range is not None and i.rate is not None and i.every is None


def _bounds(i: Input) -> Iterator[Expr]:
    assert i.range is not None
    here = Expr("var", (i.name,), i.unit, i.span)
    yield Expr("<=", (i.range.low, here), span=i.span)
    yield Expr("<=", (here, i.range.high), span=i.span)


def _expressions(automaton: HybridAutomaton, claim: Claim) -> Iterator[Expr]:
    yield from (g.condition for g in claim.goals)
    yield from claim.assume
    yield from (o.expr for o in automaton.lets)
    for m in automaton.modes:
        yield m.domain
        yield from (o.expr for o in m.lets)
        yield from (e for line in m.flow for e in _ends(line.rate))
    for edge in automaton.edges:
        yield edge.guard
        yield from (e for a in edge.resets for e in _ends(a.to))
    for i in automaton.init:
        yield i.where
        yield from (e for a in i.assigns for e in _ends(a.to))


def _ends(to: Expr | Range) -> tuple[Expr, ...]:
    return (to.low, to.high) if isinstance(to, Range) else (to,)


def _moved_automaton(automaton: HybridAutomaton, inputs: list[Input], moved: Change) -> HybridAutomaton:
    def to(x: Expr | Range) -> Expr | Range:
        return Range(moved(x.low), moved(x.high)) if isinstance(x, Range) else moved(x)

    def lets(given: tuple[Output, ...]) -> tuple[Output, ...]:
        return tuple(replace(o, expr=moved(o.expr)) for o in given)

    def assigns(given: tuple[Assign, ...]) -> tuple[Assign, ...]:
        return tuple(replace(a, to=to(a.to)) for a in given)

    slopes = tuple(FlowLine(i.name, i.rate, i.span) for i in inputs if i.rate is not None)
    first = tuple(Assign(i.name, i.range, i.span) for i in inputs if i.range is not None)

    def mode(m: Mode) -> Mode:
        flow = tuple(replace(line, rate=to(line.rate)) for line in m.flow)
        return replace(m, domain=moved(m.domain), flow=(*flow, *slopes), lets=lets(m.lets))

    def edge(e: Edge) -> Edge:
        return replace(e, guard=moved(e.guard), resets=assigns(e.resets))

    def init(i: Init) -> Init:
        return replace(i, where=moved(i.where), assigns=(*assigns(i.assigns), *first))

    names = {i.name for i in inputs}
    return replace(
        automaton,
        inputs=tuple(i for i in automaton.inputs if i.name not in names),
        vars=(*automaton.vars, *(Variable(i.name, "real", i.unit, None, i.span) for i in inputs)),
        lets=lets(automaton.lets),
        init=tuple(map(init, automaton.init)),
        modes=tuple(map(mode, automaton.modes)),
        edges=tuple(map(edge, automaton.edges)),
    )


def _moved_claim(claim: Claim, moved: Change) -> Claim:
    goals = tuple(replace(g, condition=moved(g.condition)) for g in claim.goals)
    return replace(claim, goals=goals, assume=tuple(map(moved, claim.assume)))
