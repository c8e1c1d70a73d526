"""The truth of a condition along one dwell: exact roots where one unknown moves, else proofs on shares of it."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from haverify.analyses.clock_model import PI
from haverify.analyses.placement import Placement, Tree
from haverify.analyses.poly_range import Ranges, pieces, simple_between
from haverify.analyses.signals_value import ZERO, Cut, Spans, joined, rest
from haverify.maths import sturm
from haverify.maths.univariate import primitive, sign_at, square_free
from haverify.obligations.circle import stronger
from haverify.obligations.formula import Formula, Literal, by_bounds, literals, negation, truth
from haverify.text.record import record

Q = Fraction
SHORT = 10**6  # denominators of roots that are looked for
ATTEMPTS = 40  # proofs tried on one dwell


@record
class Item:
    """A share of a dwell, from the end of the one before: a truth with its proof, or neither."""

    end: Cut
    value: bool | None
    tree: Tree | None = None


def where_true(f: Formula, v: str, ends: tuple[Q, Q], ranges: Ranges) -> tuple[Spans, Spans]:
    """Where a formula in one variable is true and where it is false; around a root that is no rational, neither."""
    whole: Spans = (((ends[0], 0), (ends[1], 1)),)
    known = f if isinstance(f, bool) else throughout(f, v, ends, ranges)
    if isinstance(known, bool):
        return (whole, ()) if known else ((), whole)
    elements = pieces(f, ends)
    good: list[tuple[Cut, Cut]] = []
    bad: list[tuple[Cut, Cut]] = []
    at: Cut = (ends[0], 0)
    for n, (piece, holds) in enumerate(elements):
        if not piece.is_root:
            (good if holds else bad).append((at, _begin(elements, n + 1, ends, f)))
            continue
        low, high = _root(elements, n, f)
        around = [elements[m][1] for m in (n - 1, n + 1) if 0 <= m < len(elements)]
        if low == high or all(x is holds for x in around):
            (good if holds else bad).append(((low, int(low < high)), (high, int(low == high))))
        at = (high, int(low == high))
    return joined(good), joined(bad)


def throughout(f: Formula, v: str, ends: tuple[Q, Q], ranges: Ranges) -> bool | None:
    """The truth of a formula on the whole interval, where the ranges of its polynomials decide it."""

    def of(leaf: Literal) -> bool | None:
        low, high = ranges.extremes(leaf.polynomial, {v: ends})
        return by_bounds(leaf.op, low.low, high.high)

    return truth(f, of)


def _begin(elements: list[tuple[sturm.Piece, bool]], n: int, ends: tuple[Q, Q], f: Formula) -> Cut:
    """Where the root that follows a stretch begins, or the end of all."""
    if n == len(elements):
        return (ends[1], 1)
    low, high = _root(elements, n, f)
    return (low, int(low < high))


def _root(elements: list[tuple[sturm.Piece, bool]], n: int, f: Formula) -> tuple[Q, Q]:
    """A root within narrow bounds; wide ones where the truth is the same on both sides of it and at it."""
    place = elements[n][0].place
    if place.low == place.high:
        return place.low, place.high
    for leaf in literals(f):
        p = square_free(primitive(leaf.polynomial.dense()))
        if sign_at(p, place.low) != sign_at(p, place.high):
            fine = sturm.refine(p, place)
            short = fine.middle.limit_denominator(SHORT)
            if fine.low <= short <= fine.high and sign_at(p, short) == 0:
                return short, short
            return fine.low, fine.high
    return place.low, place.high


def exact(f: Formula, g: Formula, p: Placement, last: Q, ranges: Ranges) -> list[Item]:
    """The truth where the dwell is the only unknown; `f` says where it is true, `g` where it is false."""
    if p.axis is None:
        return [Item((last, 1), True if f is True else False if g is True else None, "u")]
    v = p.axis
    ends = sorted((p.origin, p.origin + p.slope * last))
    f, g = stronger(f, PI), stronger(g, PI)
    good, bad = where_true(f, v, (ends[0], ends[1]), ranges)
    if g != negation(f):
        bad = where_true(g, v, (ends[0], ends[1]), ranges)[0]
    return items(_dwells(good, p), _dwells(bad, p), (last, 1))


def _dwells(spans: Spans, p: Placement) -> Spans:
    """Spans of the unknown that moves as spans of the dwell."""
    moved = [((low[0] - p.origin) / p.slope, (high[0] - p.origin) / p.slope, low[1], high[1]) for low, high in spans]
    if p.slope > 0:
        return joined([((a, x), (b, y)) for a, b, x, y in moved])
    return joined([((b, 1 - y), (a, 1 - x)) for a, b, x, y in moved])


def items(good: Spans, bad: Spans, end: Cut) -> list[Item]:
    """The shares of a dwell, in order, from where something is true and where it is false."""
    open_ = rest(joined((*good, *bad)), (ZERO, end))
    listed = [(s, True) for s in good] + [(s, False) for s in bad] + [(s, None) for s in open_]
    return [Item(s[1], value, None if value is None else "u") for s, value in sorted(listed, key=lambda x: x[0])]


def divided(low: Q, high: Q, attempt: Callable[[Q, Q], tuple[bool, Tree] | None]) -> list[Item]:
    """The truth where more is unknown: proofs on the whole, else on halves, the widest first."""
    open_, found = [(low, high)], list[tuple[Q, Item]]()
    for n, (a, b) in enumerate(open_):
        shown = attempt(a, b) if n < ATTEMPTS else None
        if shown is None and a < b and n < ATTEMPTS:
            middle = simple_between(a, b)
            open_ += [(a, middle), (middle, b)]
        else:
            found.append((a, Item((b, 1), *(shown or (None, None)))))
    return [item for _, item in sorted(found, key=lambda x: x[0])]


def merged(found: list[Item]) -> list[Item]:
    """Neighbouring shares about which nothing is known, as one."""
    out: list[Item] = []
    for item in found:
        if out and out[-1].value is None and item.value is None:
            out.pop()
        out.append(item)
    return out


def spans_of(found: list[Item]) -> tuple[Spans, Spans]:
    """Where it certainly holds, and where it is not certainly false."""
    must: list[tuple[Cut, Cut]] = []
    may: list[tuple[Cut, Cut]] = []
    at = ZERO
    for item in found:
        if item.value is not False:
            may.append((at, item.end))
            if item.value:
                must.append((at, item.end))
        at = item.end
    return joined(must), joined(may)
