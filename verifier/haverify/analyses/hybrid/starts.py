"""Starts: the box that an init line gives, what it says beyond that, points to try."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import product

from haverify.analyses.hybrid.conditions import COMPARISONS, MIRRORED, members
from haverify.maths.polynomial import variable
from haverify.model.expression import Expr, nodes
from haverify.model.hybrid import HybridAutomaton, Init, Mode, Range
from haverify.obligations.constants import Values
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import replace

Q = Fraction
Box = tuple[tuple[Q, Q], ...]
MOST_CORNERS = 4  # sides


class NoStartError(OutsideFragmentError):
    """Bounds of a start contradict each other."""


def start_box(
    automaton: HybridAutomaton,
    mode: Mode,
    init: Init,
    values: Values,
    params: Mapping[str, tuple[Q, Q]],
    assumed: Sequence[Expr],
) -> tuple[list[tuple[Q, Q]], list[Expr]]:
    """The least box of variables and params that the bounds on single ones give, and the conjuncts that say more."""
    bounds: dict[str, tuple[Q | None, Q | None]] = {v.name: (None, None) for v in automaton.vars}
    bounds |= params
    for assign in init.assigns:
        to = assign.to
        bounds[assign.var] = values.interval(to) if isinstance(to, Range) else (values.number(to),) * 2
    bounding = [c for e in (init.where, mode.domain, *assumed) for c in members(e)]
    more = [e for e in bounding if not _bounded(e, bounds, values)]
    declared = {v.name: v.range for v in automaton.vars}
    box = []
    for name, (low, high) in bounds.items():
        wide = declared.get(name)
        first, last = values.interval(wide) if wide is not None else (None, None)
        low, high = first if low is None else low, last if high is None else high
        if low is None or high is None:
            raise OutsideFragmentError(f"the start leaves `{name}` without a bound")
        if low > high:
            raise NoStartError(f"no start: `{name}` would have to lie between {low} and {high}")
        box.append((low, high))
    return box, more


def _bounded(e: Expr, bounds: dict[str, tuple[Q | None, Q | None]], values: Values) -> bool:
    """Whether a conjunct is a bound on one variable; the bound is noted (strict ones as if they were closed)."""
    if e.op not in COMPARISONS or e.op == "!=":
        return False
    left, right = e.children
    op = e.op
    if left.op not in ("var", "param", "abs"):
        left, right, op = right, left, MIRRORED[op]
    if left.op == "abs" and op in ("<", "<="):
        inner, minus = left.children[0], Expr("neg", (right,))
        above = _bounded(Expr(op, (inner, right)), bounds, values)
        below = _bounded(Expr(MIRRORED[op], (inner, minus)), bounds, values)
        return above and below
    if left.op not in ("var", "param") or left.name not in bounds:
        return False
    try:
        bound = values.number(right)
    except OutsideFragmentError:
        return False
    low, high = bounds[left.name]
    if op in (">", ">=", "=="):
        low = bound if low is None else max(low, bound)
    if op in ("<", "<=", "=="):
        high = bound if high is None else min(high, bound)
    bounds[left.name] = low, high
    return op in ("<=", ">=", "==")


def contracted(box: Box, names: Sequence[str], told: Iterable[Expr], values: Values) -> Box | None:
    """The part of a box of variables and params where some linear comparisons may hold; None where there is none."""
    sides = dict(zip(names, box, strict=True))
    for e in (c for condition in told for c in members(condition)):
        slopes, rest = linear(e, sides, values)
        for name, a in slopes.items():
            others = sum((max(b * q for q in sides[n]) for n, b in slopes.items() if n != name), rest)
            low, high = sides[name]  # where a x + others may be positive
            sides[name] = (max(low, -others / a), high) if a > 0 else (low, min(high, -others / a))
            if sides[name][0] > sides[name][1]:
                return None
    return tuple(sides[n] for n in names)


def linear(e: Expr, known: Mapping[str, object], values: Values) -> tuple[dict[str, Q], Q]:
    """Slopes and a number of a sum that is not negative where a comparison holds; no slopes for other conditions."""
    if e.op not in ("<", "<=", ">", ">="):
        return {}, Q(0)
    left, right = e.children if e.op[0] == ">" else e.children[::-1]
    gap = Expr("-", (left, right))
    names = {n.name: variable(n.name) for n in nodes(gap) if n.op in ("var", "param")}
    try:
        p = replace(values.scope("a start"), variables=names).polynomial(gap)
    except OutsideFragmentError:
        return {}, Q(0)
    if p.total_degree() > 1 or any(v not in known for v in p.variables):
        return {}, Q(0)
    at_zero = p.fix(dict.fromkeys(p.variables, Q(0))).constant
    return {v: p.derivative(v).constant or Q(0) for v in p.variables}, at_zero or Q(0)


def keeps(e: Expr, params: Mapping[str, tuple[Q, Q]], values: Values) -> bool:
    """Whether a conjunct only bounds a param: a box of starts that keeps it at first keeps it always."""
    return _bounded(e, dict(params), values)


def points(box: Box) -> Iterator[tuple[Q, ...]]:
    """The middle of a box, and where few of its sides are wide, its corners."""
    yield tuple((low + high) / 2 for low, high in box)
    ends = [side if side[0] < side[1] else side[:1] for side in box]
    if 0 < sum(len(e) > 1 for e in ends) <= MOST_CORNERS:
        yield from product(*ends)


def halves(box: Box) -> tuple[int, Box, Box]:
    """The box cut in two across its widest side, whose position comes first."""
    widths = [high - low for low, high in box]
    v = max(range(len(box)), key=lambda i: widths[i] / (1 + abs(box[i][0] + box[i][1]) / 2))
    low, high = box[v]
    middle = (low + high) / 2
    return v, (*box[:v], (low, middle), *box[v + 1 :]), (*box[:v], (middle, high), *box[v + 1 :])


def cut(box: Box, times: int) -> list[Box]:
    """The pieces of a box that is halved some times."""
    if times == 0 or is_point(box):
        return [box]
    return [piece for half in halves(box)[1:] for piece in cut(half, times - 1)]


def is_point(box: Box) -> bool:
    """Whether all sides are numbers."""
    return all(low == high for low, high in box)
