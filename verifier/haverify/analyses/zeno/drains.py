"""A time to go for flows at constant rates: a sum of bounds that falls in every mode, and that no jump raises."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from math import inf

from haverify.analyses.induction.refute import Effort, refute
from haverify.analyses.zeno.closing import SLACKS, Closing, above, starts_in
from haverify.analyses.zeno.floats import value
from haverify.maths.bernstein import bounds
from haverify.maths.polynomial import Polynomial, constant, total, variable
from haverify.obligations.formula import Literal, compare, conjunction
from haverify.obligations.induction import TIME, Induction

Q = Fraction
MOST = 24
GLANCE = Effort(8, 8)


def drains(induction: Induction) -> Iterator[Closing]:
    """Formulas for an automaton whose rates do not depend on the state, where a sum of bounds falls everywhere."""
    modes = [m.name for m in induction.automaton.modes]
    moving = {m: induction.field(m) for m in modes}
    if any(not set(p.variables) <= induction.params.keys() for f in moving.values() for p in f.values()):
        return
    kept = _kept(induction)
    weights = _weights(induction, kept)
    if weights is None:
        return
    left = total(-p.scaled(w) for p, w in zip(kept, weights, strict=True) if w)
    latest = max((value(left, p, induction.functions) for m in modes for p in starts_in(induction, m)), default=inf)
    bounded = [compare("<=", p) for p, w in zip(kept, weights, strict=True) if w]
    for slack in SLACKS:
        end = above(latest, slack)
        if end is None:
            return
        formula = conjunction([*bounded, compare("<=", variable(TIME) + left - constant(end))])
        point = tuple(compare("==", p) for p, w in zip(kept, weights, strict=True) if w)
        yield Closing(dict.fromkeys(modes, formula), {m: [] for m in modes}, {}, end, None, {}, point)


def _kept(induction: Induction) -> list[Polynomial]:
    """Polynomials that are at most 0 in every state of a run: bounds of domains that starts, jumps and flows keep."""
    found = dict.fromkeys(p for m in induction.automaton.modes for p in _bounds(induction, m.name))
    kept = list(found)[:MOST]
    while True:
        stays = [p for p in kept if _stays(induction, p, kept)]
        if len(stays) == len(kept):
            return kept
        kept = stays


def _bounds(induction: Induction, mode: str) -> list[Polynomial]:
    entries = induction.premises(induction.common(mode)[0]).entries
    found = (f.polynomial for f in entries if isinstance(f, Literal) and f.op == "<=")
    return [p for p in found if p.total_degree() == 1]


def _stays(induction: Induction, p: Polynomial, kept: list[Polynomial]) -> bool:
    wrong = compare(">", p)
    others = conjunction(compare("<=", q) for q in kept)
    for line, m, _ in induction.lines():
        told = induction.premises(*induction.common(m), *induction.starts(line, m), wrong)
        if refute(told, GLANCE) is None:
            return False
    for k in range(len(induction.automaton.edges)):
        told = induction.premises(*induction.jump(k), others, induction.after(wrong, k))
        if refute(told, GLANCE) is None:
            return False
    for mode in induction.automaton.modes:
        common = induction.premises(*induction.common(mode.name))
        if refute(common.with_(wrong), GLANCE) is None:
            rising = compare(">", induction.derivative(p, mode.name))
            if refute(common.with_(rising), GLANCE) is None:
                return False
    return True


def _weights(induction: Induction, kept: list[Polynomial]) -> list[Fraction] | None:
    """Weights at least 0 with which the sum of what is kept falls by 1 in every mode, small for the starts."""
    from scipy.optimize import linprog

    modes = [m.name for m in induction.automaton.modes]
    rates = [[bounds(-induction.derivative(p, m), induction.params)[1] for p in kept] for m in modes]
    points = [x for m in modes for x in starts_in(induction, m)]
    if not kept or not points:
        return None
    cost = [sum(value(-p, x, induction.functions) for x in points) for p in kept]
    solved = linprog(cost, A_ub=[[float(r) for r in row] for row in rates], b_ub=[-1.0] * len(rates), method="highs")
    if not solved.success:
        return None
    weights = [Q(float(w)).limit_denominator(10**6) if w > 1e-9 else Q(0) for w in solved.x]
    worst = max(sum((w * r for w, r in zip(weights, row, strict=True)), Q(0)) for row in rates)
    return [w / -worst for w in weights] if worst < 0 else None
