"""Sensitivity: how the margin of a part depends on each constant that its outputs read, at the instant
where it occurs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction

from haverify.analyses.always import Judged
from haverify.analyses.clock_model import ClockModel
from haverify.analyses.context import Context
from haverify.analyses.goals import Answer, rounded_down
from haverify.analyses.margin import middle
from haverify.analyses.questions import Question, Setting
from haverify.evidence.evidence import PartResult, Sensitivity
from haverify.evidence.verdict import Refuted, Unknown
from haverify.maths.polynomial import Polynomial
from haverify.obligations.formula import conjunction, literals
from haverify.obligations.parts import Part
from haverify.obligations.spread import spread
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import replace

Q = Fraction


def with_sensitivities(
    context: Context, settings: Sequence[Setting], answers: Sequence[Answer], refuted: bool
) -> Iterator[PartResult]:
    """All parts; the one with the worst margin, of the claim's verdict, with its sensitivities."""
    worst = _worst(answers, refuted)
    for g, answer in enumerate(answers):
        for i, part in enumerate(answer.parts):
            if (g, i) == worst and i < len(answer.judged):
                yield replace(part, sensitivities=sensitivities(context, settings[g], answer.judged[i], part.constants))
            else:
                yield part


def _worst(answers: Sequence[Answer], refuted: bool) -> tuple[int, int] | None:
    best: tuple[Q, int, int] | None = None
    for g, answer in enumerate(answers):
        for i, part in enumerate(answer.parts):
            if isinstance(part.verdict, Unknown) or part.verdict.margin is None:
                continue
            if refuted and not isinstance(part.verdict, Refuted):
                continue
            if best is None or part.verdict.margin.low < best[0]:
                best = (part.verdict.margin.low, g, i)
    return None if best is None else best[1:]


def sensitivities(context: Context, setting: Setting, j: Judged, constants: Sequence[str]) -> tuple[Sensitivity, ...]:
    """The partial derivatives of the margin at its instant; the margin's literal is `p <= 0`, so they are
    those of `-p`."""
    if j.low is None or j.low.leaf is None or j.question is None or not constants:
        return ()
    try:
        p = _with_symbols(context.open_constants, setting, j.part, j.question, j.low.leaf.polynomial, constants)
    except OutsideFragmentError:
        return ()
    if p is None:
        return ()
    known = {
        **_nominal(context.model, p),
        **{v: middle(j.question.placement.box[v]) for v in p.variables if v in j.question.placement.box},
        **j.low.point,
    }
    found = []
    for name in constants:
        if name in p.variables:
            slope = -p.derivative(name).value(known)
            half = context.model.values.constants[name].half
            zero = None if not slope else -j.low.low / slope
            found.append(
                Sensitivity(
                    name,
                    _short(slope),
                    None if zero is None else _short(zero),
                    None if half is None else _short(slope * half),
                )
            )
    return tuple(found)


def _short(q: Q) -> Q:
    return rounded_down(q)


def _nominal(model: ClockModel, p: Polynomial) -> dict[str, Q]:
    return {v: _value(model, v) for v in p.variables if v in model.values.constants}


def _value(model: ClockModel, name: str) -> Q:
    cases = model.values.constant(name)
    assert isinstance(cases, list), "a number"
    return (cases[0].numerator.constant or Q(0)) / (cases[0].denominator.constant or Q(1))


def _with_symbols(
    model: ClockModel, setting: Setting, part: Part, q: Question, wanted: Polynomial, constants: Sequence[str]
) -> Polynomial | None:
    """The literal that sets the margin, its constants left open."""
    scope = model.landing(part.edge) if part.edge is not None else model.timed_scope(model.index[part.mode])
    body = conjunction(scope.formula(spread(r)) for r in part.residuals)
    for leaf in literals(body):
        p = q.placement.apply(leaf.polynomial)
        others = {v: _value(setting.model, v) for v in p.variables if v in setting.model.values.constants}
        if p.fix(others) == wanted:
            return p.fix({v: x for v, x in others.items() if v not in constants})
    return None
