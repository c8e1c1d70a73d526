"""Parts, places and ranges in the words of the spec."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from haverify.analyses.always import Judged
from haverify.analyses.clock_model import ClockModel
from haverify.analyses.margin import middle
from haverify.analyses.questions import Question, Setting
from haverify.maths.polynomial import variable
from haverify.model.expression import Expr, nodes
from haverify.obligations.parts import Part
from haverify.obligations.translate import COMPARISONS, OutsideFragmentError, Scope

Q = Fraction


def decimal(q: Q) -> str:
    """A rational to six significant digits."""
    return f"{float(q):.6g}"


def part_text(part: Part) -> str:
    """What a part asks."""
    if part.kind == "stuck":
        return f"mode {part.where} never blocks"
    what = part.output or "the condition"
    return f"{what} in mode {part.where}" if part.kind == "dwell" else f"{what} at the jump {part.where}"


def unit_of(part: Part) -> str | None:
    """The unit that all comparisons of a part share; None where they mix units."""
    found = {_unit(n) for r in part.residuals for n in nodes(r) if n.op in COMPARISONS}
    return found.pop() if len(found) == 1 else None if found else ""


def _unit(comparison: Expr) -> str:
    units = [c.unit for c in comparison.children if c.unit is not None]
    return str(units[0]) if units else ""


def place_text(model: ClockModel, j: Judged) -> str:
    """Where the margin of a part occurs: mode or jump, and the values of the variables there."""
    if j.low is None or j.question is None:
        return j.part.where
    values = state_at(model, j.question, j.low.point)
    shown = [f"{v} = {decimal(x)}{_suffix(model, v)}" for v, x in values.items() if v in model.reals]
    open_params = {p: x for p, x in j.low.point.items() if p in model.params}
    shown += [f"{p} = {decimal(x)}" for p, x in open_params.items()]
    return ", ".join([j.part.where, *shown])


def _suffix(model: ClockModel, name: str) -> str:
    unit = next((v.unit for v in model.automaton.vars if v.name == name), None)
    text = "" if unit is None else str(unit)
    return f" {text}" if text and text != "1" else ""


def state_at(model: ClockModel, q: Question, point: Mapping[str, Q]) -> dict[str, Q]:
    """The values of the variables at a point of a question's box; unknowns the point does not fix are at
    their middle."""
    box, replaced = q.placement.box, q.placement.replaced
    found = {}
    for v in model.automaton.vars:
        p = replaced.get(v.name) or variable(v.name)
        if all(n in box or n in point for n in p.variables):
            found[v.name] = p.value({n: point[n] if n in point else middle(box[n]) for n in p.variables})
    return found


def facts_about(setting: Setting, j: Judged) -> tuple[str, ...]:
    """The range of each output of a part in its worst cell, where that is a polynomial of the clock."""
    if j.question is None or j.part.kind != "dwell" or not j.part.output:
        return ()
    model = setting.model
    scope = model.timed_scope(model.index[j.part.mode])
    found = [_range_text(setting, j.question, n, scope) for n in j.part.output.split(",") if n in scope.lets]
    return tuple(text for text in found if text)


def _range_text(setting: Setting, q: Question, name: str, scope: Scope) -> str:
    model = setting.model
    try:
        p = q.placement.apply(scope.polynomial(Expr("let", (name,))))
    except OutsideFragmentError:
        return ""
    if len(p.variables) != 1 or not q.placement.bounded:
        return ""
    v = p.variables[0]
    low, high = setting.ranges.extremes(p, q.placement.box)
    unit = next((o.unit for m in model.automaton.modes for o in m.lets if o.name == name), None)
    unit = unit or next((o.unit for o in model.automaton.lets if o.name == name), None)
    suffix = f" {unit}" if unit is not None and str(unit) != "1" else ""
    far = high if abs(high.high) >= abs(low.low) else low
    at = ", ".join(
        f"{n} = {decimal(x)}{_suffix(model, n)}" for n, x in state_at(model, q, {v: far.at}).items() if n in model.reals
    )
    word = "largest" if far is high else "least"
    return f"{name} runs from {decimal(low.low)}{suffix} to {decimal(high.high)}{suffix}, {word} at {at}"


def constants_read(model: ClockModel, part: Part) -> tuple[str, ...]:
    """The constants that the outputs of a part read in its mode, in order."""
    scope = model.scope(model.index[part.mode])
    found: dict[str, None] = {}
    stack = list(part.residuals)
    seen: set[str] = set()
    while stack:
        for n in nodes(stack.pop()):
            if n.op == "const":
                found[n.name] = None
            elif n.op == "let" and n.name in scope.lets and n.name not in seen:
                seen.add(n.name)
                stack.append(scope.lets[n.name][1])
    return tuple(found)
