"""When edges are certainly enabled: from which scaled dwell on, and with an outcome."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from haverify.analyses.bounds import EVERYTHING, Box, Interval, image, single
from haverify.analyses.cell import Cell, moved
from haverify.analyses.clock_model import ClockEdge, ClockModel
from haverify.maths.bernstein import bounds as range_on
from haverify.maths.polynomial import Polynomial
from haverify.obligations.formula import Formula, Junction, Literal, by_bounds, literal, transform, truth
from haverify.text.record import field, holder, record

Q = Fraction
BEYOND = Q(1, 10**9)  # scaled dwell past a strict bound at which outcomes still have to be allowed (LANGUAGE S8)


@record
class Opening:
    """A condition begins to hold, for good, at some scaled dwell from `first` to `last`.

    `states` are those in which it does, `until` all states from entry up to then.
    """

    first: Q
    last: Q
    states: Box
    until: Box


@holder
class _Bounds:
    """The bounds that a conjunction puts on variables that move towards them."""

    first: Q = Q(0)
    last: Q = Q(0)
    strict: bool = False
    instants: int = 0  # bounds that hold at one instant only
    bounds: int = 0
    moving: dict[str, Interval] = field(default_factory=dict)  # where the variable is, from entry to its bound
    reached: dict[str, Interval] = field(default_factory=dict)  # where the bound holds


def opening(f: Formula, model: ClockModel, cell: Cell) -> Opening | None:
    """When a formula begins to hold; None where that is not certain for all entries and params.

    Each conjunct bounds a single variable and holds from some scaled dwell on, or holds all the time; or a single one
    holds at one instant (`==`), and the others all the time.
    """
    if isinstance(f, bool):
        return _opening(_Bounds(), model, cell) if f else None
    found = _Bounds()
    still = {v: x for v, x in cell.entry.items() if not model.mode(cell.mode).slopes[v]}
    for m in f.members if isinstance(f, Junction) and f.is_and else (f,):
        if not certainly(model, m, still) and not (isinstance(m, Literal) and _collect(found, m, model, cell)):
            return None
    return None if found.instants and found.bounds > 1 else _opening(found, model, cell)


def _collect(found: _Bounds, f: Literal, model: ClockModel, cell: Cell) -> bool:
    """Note a bound on a variable that moves towards it; False where the literal is none."""
    one = single(f.polynomial, cell.entry)
    if one is None or f.op == "!=":
        return False
    v, factor, rest = one
    if v is None:
        return False
    slope, entry = model.mode(cell.mode).slopes[v], cell.entry[v]
    if not slope or entry.low is None or entry.high is None or (slope * factor > 0 and f.op != "=="):
        return False
    if not all(n in model.params for n in rest.variables):
        return False
    low, high = sorted(-x / factor for x in range_on(rest, model.params))
    dwells = [(bound - end) / slope for bound in (low, high) for end in (entry.low, entry.high)]
    if f.op == "==" and min(dwells) < 0:
        return False  # some state is past the instant
    found.bounds, found.instants = found.bounds + 1, found.instants + (f.op == "==")
    found.first, found.last = max(found.first, min(dwells)), max(found.last, *dwells)
    found.strict = found.strict or f.op == "<"
    found.moving[v] = found.moving.get(v, entry.closed).hull(Interval(low, high))
    holds = Interval(None, high) if factor > 0 else Interval(low, None)
    if f.op == "==":
        holds = Interval(low, high)
    found.reached[v] = found.reached.get(v, EVERYTHING).meet(holds)
    return True


def _opening(found: _Bounds, model: ClockModel, cell: Cell) -> Opening:
    slopes: Mapping[str, Q] = model.mode(cell.mode).slopes
    margin = BEYOND if found.strict else Q(0)
    states = {v: moved(x, slopes[v], found.first, found.last + margin) for v, x in cell.entry.items()}
    until = {v: moved(x, slopes[v], Q(0), found.last) for v, x in cell.entry.items()}
    if len(found.moving) == 1:
        v, reach = next(iter(found.moving.items()))
        states[v] = states[v].meet(moved(reach.meet(found.reached[v]), slopes[v], Q(0), margin))
        until[v] = until[v].meet(reach)
    return Opening(found.first, found.last, states, until)


def due(model: ClockModel, cell: Cell, edge: ClockEdge) -> Opening | None:
    """When the edge becomes enabled, with an outcome, for every state of the cell; None where none is known."""
    found = opening(edge.guard, model, cell)
    return found if found is not None and certainly_lands(model, edge, found.states) else None


def certainly_lands(model: ClockModel, edge: ClockEdge, before: Box) -> bool:
    """Whether the edge has an outcome in the target's domain from every state of the box."""
    sets = [r for r in edge.resets.values() if r.is_set]
    if not all(certainly(model, literal("<=", r.low - r.high), before) for r in sets):
        return False
    domain = model.mode(edge.target).domain
    ends = [{v: r.low for v, r in edge.resets.items()}]
    if sets:
        ends.append({v: r.high for v, r in edge.resets.items()})
    return any(certainly(model, transform(domain, lambda p, e=e: p.substitute(e)), before) for e in ends)  # type: ignore[misc]


def certainly(model: ClockModel, f: Formula, box: Box) -> bool:
    """Whether the formula holds on the whole box, by the range of each of its polynomials."""

    def of(leaf: Literal) -> bool | None:
        inside = image_or_none(leaf.polynomial, box, model)
        if inside is None:
            return None
        if inside.low is None or inside.high is None:
            return _half_bounded(leaf.op, inside)
        return by_bounds(leaf.op, inside.low, inside.high)

    return truth(f, of) is True


def _half_bounded(op: str, inside: Interval) -> bool | None:
    if inside.high is None or op not in ("<", "<="):
        return None
    return True if by_bounds(op, inside.high, inside.high) else None


def image_or_none(p: Polynomial, box: Box, model: ClockModel) -> Interval | None:
    """An interval around `p` on the box, None where a variable is unknown."""
    return image(p, box, model.params) if all(v in box or v in model.params for v in p.variables) else None


def outcome(model: ClockModel, edge: ClockEdge, before: Box) -> Box:
    """The box of outcomes, the target's domain not yet considered."""
    after = dict(before)
    for v, reset in edge.resets.items():
        low = image(reset.low, before, model.params)
        after[v] = low if not reset.is_set else Interval(low.low, image(reset.high, before, model.params).high)
    return after
