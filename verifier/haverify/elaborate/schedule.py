"""`schedule on x from a { A until t1; B until t2; ... }`: a domain and an urgent edge for each slot."""

from __future__ import annotations

from fractions import Fraction

from haverify.elaborate import arithmetic as A
from haverify.elaborate.expressions import Env, real
from haverify.elaborate.paths import target_mode
from haverify.elaborate.resets import resets, state_variable
from haverify.elaborate.units import to_unit
from haverify.elaborate.values import exact_value
from haverify.maths.exact import people_text
from haverify.model.expression import Expr
from haverify.model.hybrid import Edge
from haverify.syntax import tree as t
from haverify.text.record import record
from haverify.text.span import Span


@record
class Slot:
    """What a slot adds: a domain for `mode` and, but for an open end, an edge."""

    mode: str
    domain: Expr
    edge: Edge | None


def slots(env: Env, schedule: t.Schedule) -> list[Slot]:
    """The slots of a schedule in order; times that do not increase are HA203."""
    clock = state_variable(env, t.Target(schedule.clock, None, schedule.span), "schedule on")
    x = Expr("var", (clock.name,), clock.unit, schedule.span)
    what = f"the schedule on {clock.name}"
    times = [to_unit(env.ctx, real(env, e), clock.unit, what, e.span) for e in _times(schedule)]
    _check_order(env, schedule, times)
    modes = [target_mode(env, t.Target(s.mode, None, _word(s.span, s.mode)))[0].name for s in schedule.slots]
    found = []
    for k, slot in enumerate(schedule.slots):
        domain = A.every(
            [A.compare("<=", times[k], x, slot.span), A.compare("<=", x, times[k + 1], slot.span)], slot.span
        )
        target = _target(env, slot, modes[k + 1] if k + 1 < len(modes) else None)
        guard = A.compare(">=", x, times[k + 1], slot.span)
        found.append(Slot(modes[k], domain, _edge(env, slot, modes[k], target, guard) if target else None))
    return found


def _word(span: Span, word: str) -> Span:
    return Span(span.path, span.start, span.start + len(word))


def _times(schedule: t.Schedule) -> list[t.Expr]:
    return [schedule.start, *(s.until for s in schedule.slots)]


def _target(env: Env, slot: t.Slot, following: str | None) -> str | None:
    if slot.then is not None:
        return target_mode(env, t.Target(slot.then, None, slot.span))[0].name
    return following


def _edge(env: Env, slot: t.Slot, source: str, target: str, guard: Expr) -> Edge:
    name = edge_name(source, target)
    return Edge(name, source, target, True, guard, resets(env, slot.assignments), slot.span)


def edge_name(source: str, target: str) -> str:
    """The name of an edge that has none."""
    return "_".join(n.replace("[", "_").replace("]", "") for n in (source, target))


def _check_order(env: Env, schedule: t.Schedule, times: list[Expr]) -> None:
    values = [exact_value(env.ctx, e) for e in times]
    for k, slot in enumerate(schedule.slots):
        a, b = values[k], values[k + 1]
        if a is not None and b is not None and b <= a:
            unit = f" {times[k].unit}" if times[k].unit else ""
            told = f"mode {slot.mode} ends at {_plain(b)}{unit}, before it begins ({_plain(a)}{unit})"
            if a == b:
                told = f"mode {slot.mode} has no length: it begins and ends at {_plain(a)}{unit}"
            env.ctx.report("HA203", told, slot.until.span, label="not later than the time before it")


def _plain(q: Fraction) -> str:
    return people_text(q)
