"""Margins: how far a formula is from being false on a box, in the unit of its comparisons.

The robustness of a literal `p < 0` or `p <= 0` is `-p`, of `p == 0` it is `-|p|`, of `p != 0` it is `|p|`;
a conjunction
has the least of its members', a disjunction the greatest. The margin on a box is the least robustness
where the premises
hold. It is found exactly for conjunctions in one variable, else enclosed by branch and bound.
"""

from __future__ import annotations

import heapq
from collections.abc import Mapping
from fractions import Fraction
from itertools import count

from haverify.analyses.poly_range import Box, Ranges, simple_between, worst_ends
from haverify.maths.polynomial import Polynomial
from haverify.obligations.formula import Formula, Junction, Literal, by_bounds, holds, literals, truth
from haverify.text.record import record

Q = Fraction
STEPS = 150
WIDE = 4  # variables beyond which branch and bound is not tried
CLOSE = Q(1, 10**7)  # relative width at which branch and bound stops


@record
class Low:
    """A least robustness, `low <= value <= high`, met at `point` or near it; `leaf` is the literal that sets it."""

    low: Q
    high: Q
    point: Mapping[str, Q]
    leaf: Literal | None = None


def least(f: Formula, premise: Formula, box: Box, ranges: Ranges) -> Low | None:
    """The margin of `f` on the box where `premise` holds, None where it has no number or the premise never holds."""
    if isinstance(f, bool):
        return None
    if premise is True and _is_conjunction(f):
        found = [_of_literal(leaf, box, ranges) for leaf in literals(f)]
        if all(x is not None for x in found):
            return min((x for x in found if x is not None), key=lambda x: x.low)
    return _branch(f, premise, box, ranges)


def _is_conjunction(f: Formula) -> bool:
    return isinstance(f, Literal) or (
        isinstance(f, Junction) and f.is_and and all(isinstance(m, Literal) for m in f.members)
    )


def _of_literal(leaf: Literal, box: Box, ranges: Ranges) -> Low | None:
    """The least of `-p` for an inequality, where at most one variable is not linear: exact, or the value's
    enclosure."""
    if leaf.op not in ("<", "<="):
        return None
    p = leaf.polynomial
    if len(p.variables) < 2:
        return _at_ends(p, {}, leaf, box, ranges, 0)
    ends = worst_ends(leaf, box, ranges)
    left = p.fix(ends)
    chosen = {v: middle(box[v]) for v in left.variables if len(left.variables) > 1}
    return _at_ends(left, {**chosen, **ends}, leaf, box, ranges, 4)


def middle(ends: tuple[Q, Q]) -> Q:
    """The number half way."""
    return (ends[0] + ends[1]) / 2


def _at_ends(p: Polynomial, chosen: Mapping[str, Q], leaf: Literal, box: Box, ranges: Ranges, free: int) -> Low | None:
    """The least of `-p`, a linear variable being at one of its ends."""
    names = p.variables
    if not names:
        value = p.constant or Q(0)
        return Low(-value, -value, chosen, leaf)
    if len(names) == 1:
        _, greatest = ranges.extremes(p, box)
        return Low(-greatest.high, -greatest.low, {**chosen, names[0]: greatest.at}, leaf)
    linear = next((v for v in names if _ends_decide(p, v, box)), None)
    if linear is None or not free:
        return None
    found = [_at_ends(p.fix({linear: e}), {**chosen, linear: e}, leaf, box, ranges, free - 1) for e in box[linear]]
    if any(x is None for x in found):
        return None
    return min((x for x in found if x is not None), key=lambda x: x.low)


def _ends_decide(p: Polynomial, v: str, box: Box) -> bool:
    """Whether `p = a v^k + b` with one k and `v^k` monotone on the box: then its extremes are at ends of `v`."""
    powers = {e for m in p.whole for n, e in m if n == v}
    low, high = box[v]
    return len(powers) == 1 and (powers.pop() % 2 == 1 or low >= 0 or high <= 0)


def _branch(f: Formula, premise: Formula, box: Box, ranges: Ranges) -> Low | None:
    """Branch and bound on the least robustness, the premise sampled at middles and corners."""
    names = sorted({v for leaf in (*literals(f), *literals(premise)) for v in leaf.polynomial.variables})
    if len(names) > WIDE:
        return None
    order = count()
    best: Low | None = None
    queue: list[tuple[Q, int, Box]] = [(_lower(f, box, ranges), next(order), {v: box[v] for v in names})]
    for _ in range(STEPS):
        if not queue or (best is not None and best.high - queue[0][0] <= CLOSE * max(abs(best.high), Q(1, 1000))):
            break
        _, _, part = heapq.heappop(queue)
        best = _sampled(f, premise, part, best)
        for half in _halves(f, premise, part, ranges):
            known = truth(premise, lambda leaf, h=half: by_bounds(leaf.op, *ranges.bounds(leaf.polynomial, h)))  # type: ignore[misc]
            if known is not False:
                bound = _lower(f, half, ranges)
                if best is None or bound < best.high:
                    heapq.heappush(queue, (bound, next(order), half))
    if best is None:
        return None
    low = min(best.high, queue[0][0]) if queue else best.high
    return Low(low, best.high, best.point, best.leaf)


def _sampled(f: Formula, premise: Formula, part: Box, best: Low | None) -> Low | None:
    points = [{v: (low + high) / 2 for v, (low, high) in part.items()}]
    points += [{v: e[0] for v, e in part.items()}, {v: e[1] for v, e in part.items()}]
    for point in points:
        if holds(premise, point):
            value, leaf = robustness(f, point)
            if best is None or value < best.high:
                best = Low(value, value, point, leaf)
    return best


def _halves(f: Formula, premise: Formula, part: Box, ranges: Ranges) -> list[Box]:
    weight = dict.fromkeys(part, Q(0))
    for leaf in (*literals(f), *literals(premise)):
        for v in leaf.polynomial.variables:
            low, high = ranges.bounds(leaf.polynomial.derivative(v), part)
            weight[v] += max(abs(low), abs(high)) * (part[v][1] - part[v][0])
    if not part:
        return []
    v = max(part, key=lambda name: (weight[name], name))
    if part[v][0] == part[v][1]:
        return []
    middle = simple_between(*part[v])
    return [{**part, v: (part[v][0], middle)}, {**part, v: (middle, part[v][1])}]


def _lower(f: Formula, box: Box, ranges: Ranges) -> Q:
    """A lower bound of the robustness on the box."""
    if isinstance(f, Literal):
        low, high = ranges.bounds(f.polynomial, box)
        if f.op in ("<", "<="):
            return -high
        if f.op == "==":
            return -max(abs(low), abs(high))
        return max(low, -high, Q(0))
    if isinstance(f, bool):
        return Q(10**9) if f else Q(-(10**9))
    values = [_lower(m, box, ranges) for m in f.members]
    return min(values) if f.is_and else max(values)


def robustness(f: Formula, point: Mapping[str, Q]) -> tuple[Q, Literal | None]:
    """The robustness at a point, and the literal that sets it."""
    if isinstance(f, Literal):
        p = f.polynomial.value(point)
        return (-p if f.op in ("<", "<=") else -abs(p) if f.op == "==" else abs(p)), f
    if isinstance(f, bool):
        return (Q(10**9) if f else Q(-(10**9))), None
    found = [robustness(m, point) for m in f.members]
    return (min if f.is_and else max)(found, key=lambda x: x[0])
