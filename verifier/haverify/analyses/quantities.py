"""What a part compares with its bounds, and how far that runs: the facts beside a verdict."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction

from haverify.analyses.always import Judged
from haverify.analyses.margin import Low, least
from haverify.analyses.questions import Question, Setting
from haverify.analyses.telling import decimal, values_at
from haverify.elaborate.notation import Notation
from haverify.maths.polynomial import Polynomial
from haverify.model.expression import Expr, nodes
from haverify.model.unit import ONE
from haverify.obligations.formula import Literal
from haverify.obligations.parts import Part
from haverify.obligations.translate import COMPARISONS, OutsideFragmentError

Q = Fraction
MOVING = frozenset({"let", "var", "time"})
FOLDED = frozenset({"abs", "neg", "min", "max", "clamp"})  # what is shown is what they are applied to


def facts_about(setting: Setting, j: Judged) -> tuple[str, ...]:
    """The range of each quantity that a part compares, in its worst cell, in the unit it has in the claim."""
    if j.question is None or not j.question.placement.bounded:
        return ()
    model = setting.model
    scope = model.timed_scope(model.index[j.part.mode]) if j.part.edge is None else model.landing(j.part.edge)
    found = []
    for e in compared(j.part):
        try:
            p = j.question.placement.apply(scope.polynomial(e))
        except OutsideFragmentError:
            continue
        found.append(_range_text(setting, j.question, e, p))
    return tuple(text for text in found if text)


def compared(part: Part) -> tuple[Expr, ...]:
    """The sides of comparisons that change along a run, without what folds their sign; each once, in order."""
    sides = (side for r in part.residuals for n in nodes(r) if n.op in COMPARISONS for side in n.children)
    return tuple(dict.fromkeys(e for side in sides for e in _unfolded(side)))


def _unfolded(e: Expr) -> Iterator[Expr]:
    if e.op in FOLDED:
        for c in e.children:
            yield from _unfolded(c)
    elif e.op == "scale":
        yield from (e,) if _moves(e) else ()
    elif _moves(e):
        yield e


def _moves(e: Expr) -> bool:
    return any(n.op in MOVING for n in nodes(e))


def _range_text(setting: Setting, q: Question, e: Expr, p: Polynomial) -> str:
    words = {(enum.name, v): v for enum in setting.model.spec.enums for v in enum.values}
    name = Notation(words).text(e)
    suffix = f" {e.unit}" if e.unit is not None and e.unit != ONE else ""
    if p.constant is not None:
        at = ", ".join(values_at(setting.model, q, {})) if q.placement.axis is None else ""
        return f"{name} is {_named(setting, e, p.constant)}{suffix}" + (f" at {at}" if at else "")
    low = least(Literal("<=", -p), True, q.placement.box, setting.ranges)
    high = least(Literal("<=", p), True, q.placement.box, setting.ranges)
    if low is None or high is None:
        return ""
    first = f"{decimal(low.low)}{suffix}{_at(setting, q, low)}"
    return f"{name} runs from {first} to {decimal(-high.low)}{suffix}{_at(setting, q, high)}"


def _named(setting: Setting, e: Expr, value: Fraction) -> str:
    """A number, or the value of an enumeration that it stands for."""
    automaton = setting.model.automaton
    types = {v.name: v.type for v in automaton.vars}
    types |= {o.name: o.type for lets in (automaton.lets, *(m.lets for m in automaton.modes)) for o in lets}
    type_ = types.get(e.name) if e.op in ("let", "var") else None
    enum = next((n for n in setting.model.spec.enums if n.name == type_ and n.low is None), None)
    return enum.values[int(value)] if enum is not None else decimal(value)


def _at(setting: Setting, q: Question, low: Low) -> str:
    point: Mapping[str, Q] = low.point
    at = ", ".join(values_at(setting.model, q, point))
    return f" (at {at})" if at else ""
