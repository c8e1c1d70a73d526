"""Runs from starts that are known in brackets: all of them violate the goal, and some of them are admissible."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from math import log2
from typing import Any

from haverify.analyses.induction.brackets import Bracketed, bracketed
from haverify.analyses.induction.invented import system_of
from haverify.analyses.induction.refutation import alone, names_of
from haverify.evidence.certificate import run_json
from haverify.evidence.run import Passage, Run
from haverify.maths.digits import rational_text
from haverify.model.expression import Expr, rebuild
from haverify.model.hybrid import HybridAutomaton, Range
from haverify.obligations.induction import Induction
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import record, replace

Q = Fraction
Json = Any
TINY = Q(1, 1024)
LATER = Q(1)  # s; how long a run is followed beyond the instant at which it seems to violate the goal


@record
class Rooted:
    """A run, its entry in a certificate without the hash, and its record."""

    run: Run
    entry: Json
    flow: Json


def by_rooted_run(induction: Induction) -> Rooted | None:
    """A run that violates the goal, from a start with values that are no rationals."""
    a = induction.automaton
    is_plain = not (induction.using or induction.claim.assume or induction.spec.assumptions or induction.inputs)
    if (
        not is_plain
        or len(a.modes) > 1
        or a.edges
        or induction.functions.known
        or names_of(induction) != list(_vars(a))
    ):
        return None
    try:
        return next((found for start, when in _starts(induction) if (found := _enclosed(induction, start, when))), None)
    except OverflowError:  # numbers that floats do not hold
        return None


def _vars(automaton: Any) -> Iterator[str]:
    return (v.name for v in automaton.vars)


def _starts(induction: Induction) -> Iterator[tuple[Bracketed, Q]]:
    from haverify.analyses.synthesis.aimed import aimed

    windows = [f for v in induction.automaton.vars for f in induction.window(v.name)]
    for near, when in aimed(system_of(induction, induction.automaton.modes[0].name)):
        for line, mode, _ in induction.lines():
            told = induction.premises(*induction.common(mode), *induction.starts(line, mode), *windows)
            for start in bracketed(told, [*_vars(induction.automaton), "time"], near, mode):
                yield start, Q(when).limit_denominator(1000) + LATER


def _enclosed(induction: Induction, start: Bracketed, span: Q) -> Rooted | None:
    """The run from all values in the brackets, if a flowpipe shows that it violates the goal."""
    from haverify.analyses.hybrid.model import hybrid_model
    from haverify.analyses.hybrid.question import question_of
    from haverify.analyses.hybrid.record import run_record
    from haverify.analyses.hybrid.runs import by_all

    ends = {v: start.ends(v) for v in _vars(induction.automaton)}
    sizes = {v: Q(2) ** round(log2(max(abs(low), abs(high)))) for v, (low, high) in ends.items() if low or high}
    free = {v.name for v in induction.automaton.vars if v.range is None}
    tiny = {v: size for v, size in sizes.items() if size < TINY and v in free}
    spec, automaton, claim = alone(induction, start.mode, ends, span)
    automaton = in_sizes(automaton, tiny)
    goal = replace(claim.goals[0], condition=sized(claim.goals[0].condition, tiny))
    try:
        model = hybrid_model(spec, automaton, [goal.condition])
        question = question_of(model, replace(claim, goals=(goal,)), goal)
        run = by_all(question)
    except OutsideFragmentError:
        return None
    if run is None:
        return None
    values = tuple((v, (low + high) / 2) for v, (low, high) in ends.items())
    run = replace(run, values=values, path=tuple(_unsized(p, tiny) for p in run.path))
    told = run_json(run)
    for v, pair in start.roots.items():
        told["values"][v] = [rational_text(q) for q in pair]
    piece = question.shown[0]
    flow = None if tiny else run_record(question, piece.start, piece.box, run.last)
    return Rooted(run, {"kind": "flow_run", "run": told}, flow)


def _unsized(p: Passage, sizes: dict[str, Q]) -> Passage:
    """An instant with its values in the units of the spec; powers of two lose nothing."""
    factors = {v: float(sizes.get(v, 1)) for v, _, _ in p.values}
    return replace(p, values=tuple((v, low * factors[v], high * factors[v]) for v, low, high in p.values))


def in_sizes(automaton: HybridAutomaton, sizes: dict[str, Q]) -> HybridAutomaton:
    """The automaton with variables that have no declared range in other units: flowpipes aim at one error for all."""

    def scaled(e: Any, v: str) -> Any:
        return e if v not in sizes else Expr("/", (e, Expr("num", (sizes[v],))))

    def of(to: Any, v: str) -> Any:
        return Range(scaled(to.low, v), scaled(to.high, v)) if isinstance(to, Range) else scaled(to, v)

    modes = []
    for m in automaton.modes:
        flow = tuple(replace(f, rate=of(sized(f.rate, sizes), f.var)) for f in m.flow)
        lets = tuple(replace(o, expr=sized(o.expr, sizes)) for o in m.lets)
        modes.append(replace(m, domain=sized(m.domain, sizes), flow=flow, lets=lets))
    init = tuple(replace(i, assigns=tuple(replace(a, to=of(a.to, a.var)) for a in i.assigns)) for i in automaton.init)
    lets = tuple(replace(o, expr=sized(o.expr, sizes)) for o in automaton.lets)
    return replace(automaton, modes=tuple(modes), init=init, lets=lets)


def sized(e: Any, sizes: dict[str, Q]) -> Any:
    """An expression with variables times their sizes."""
    if not isinstance(e, Expr):
        return e
    if e.op == "var" and e.name in sizes:
        return Expr("*", (Expr("num", (sizes[e.name],)), e))
    return rebuild(e, lambda a: sized(a, sizes))
