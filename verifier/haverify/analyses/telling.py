"""Parts, places and ranges in the words of the spec."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction

from haverify.analyses.always import Judged
from haverify.analyses.clock_model import CLOCK, ClockModel
from haverify.analyses.margin import middle
from haverify.analyses.questions import Question
from haverify.maths.exact import significant
from haverify.maths.polynomial import variable
from haverify.model.expression import Expr, nodes
from haverify.obligations.parts import Part
from haverify.obligations.translate import COMPARISONS

Q = Fraction
VARYING = frozenset({"let", "var", "param", "time", "pi"})


def decimal(q: Q) -> str:
    """A rational to six significant digits."""
    return significant(q)


def part_text(part: Part, violated: bool = False) -> str:
    """What a part asks; of a state that blocks, whether there is one."""
    if part.kind == "stuck":
        return f"mode {part.where} {'can block' if violated else 'never blocks'}"
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
    return ", ".join([j.part.where, *values_at(model, j.question, j.low.point)])


def values_at(model: ClockModel, q: Question, point: Mapping[str, Q]) -> list[str]:
    """The variables at a point of a question's box, the time where it is followed, the params that the point fixes."""
    values = state_at(model, q, point)
    shown = [f"{v} = {decimal(x)}{_suffix(model, v)}" for v, x in values.items() if v in model.reals]
    time = _time_at(model, q, point)
    if time is not None:
        shown.append(f"time = {decimal(time)} s")
    return shown + [f"{p} = {decimal(x)}" for p, x in point.items() if p in model.params]


def _time_at(model: ClockModel, q: Question, point: Mapping[str, Q]) -> Q | None:
    sigma = q.placement.replaced.get(CLOCK)
    if sigma is None or model.rho is None or not all(v in point for v in (*sigma.variables, *model.rho.variables)):
        return None
    return sigma.value(point) / model.rho.value(point)


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


def constants_read(model: ClockModel, part: Part) -> tuple[str, ...]:
    """The constants that the outputs of a part read in its mode, in order."""
    return tuple(dict.fromkeys(n.name for n in _unfolded(model, part) if n.op == "const"))


def has_quotient(model: ClockModel, part: Part) -> bool:
    """Whether a part divides by what is no rational: then its polynomials are not in the unit of the claim."""
    return any(
        (n.op == "scale" and str(n.args[1]).startswith("-"))
        or (n.op == "^" and str(n.args[1]).startswith("-"))
        or (n.op == "/" and any(m.op in VARYING for m in nodes(n.children[1])))
        for n in _unfolded(model, part)
    )


def _unfolded(model: ClockModel, part: Part) -> Iterator[Expr]:
    """The nodes of a part's residuals and of the lets they read."""
    scope = model.scope(model.index[part.mode])
    stack = list(part.residuals)
    seen: set[str] = set()
    while stack:
        for n in nodes(stack.pop()):
            yield n
            if n.op == "let" and n.name in scope.lets and n.name not in seen:
                seen.add(n.name)
                stack.append(scope.lets[n.name][1])
