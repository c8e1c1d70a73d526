"""Boxes and what conditions on single variables leave of them; everything a run can do stays inside."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from haverify.maths.bernstein import bounds as range_on
from haverify.maths.polynomial import Polynomial
from haverify.obligations.formula import Formula, Junction, Literal, by_bounds
from haverify.text.record import record

Q = Fraction
End = Fraction | None  # None: infinite


@record
class Interval:
    """The numbers from `low` to `high`; None is infinite; an open end does not belong."""

    low: End = None
    high: End = None
    open_low: bool = False
    open_high: bool = False

    @property
    def is_point(self) -> bool:
        """Whether it holds exactly one number."""
        return self.low is not None and self.low == self.high

    @property
    def is_empty(self) -> bool:
        """Whether it holds none."""
        if self.low is None or self.high is None:
            return False
        return self.low > self.high or (self.low == self.high and (self.open_low or self.open_high))

    def meet(self, other: Interval) -> Interval:
        """The numbers in both."""
        low, open_low = _higher((self.low, self.open_low), (other.low, other.open_low))
        high, open_high = _lower((self.high, self.open_high), (other.high, other.open_high))
        return Interval(low, high, open_low, open_high)

    def hull(self, other: Interval) -> Interval:
        """The least interval around both."""
        low = None if self.low is None or other.low is None else min(self.low, other.low)
        high = None if self.high is None or other.high is None else max(self.high, other.high)
        open_low = (self.open_low or self.low != low) and (other.open_low or other.low != low)
        open_high = (self.open_high or self.high != high) and (other.open_high or other.high != high)
        return Interval(low, high, open_low, open_high)

    def contains(self, other: Interval) -> bool:
        """Whether every number of `other` lies in the closure of this one."""
        below = self.low is None or (other.low is not None and self.low <= other.low)
        return below and (self.high is None or (other.high is not None and other.high <= self.high))

    @property
    def closed(self) -> Interval:
        """With both ends."""
        return Interval(self.low, self.high) if self.open_low or self.open_high else self


EVERYTHING = Interval()
Box = dict[str, Interval]


def point(x: Fraction) -> Interval:
    """The interval that holds `x` alone."""
    return Interval(x, x)


def _higher(a: tuple[End, bool], b: tuple[End, bool]) -> tuple[End, bool]:
    if a[0] is None or (b[0] is not None and b[0] > a[0]):
        return b
    return a if b[0] is None or a[0] > b[0] else (a[0], a[1] or b[1])


def _lower(a: tuple[End, bool], b: tuple[End, bool]) -> tuple[End, bool]:
    if a[0] is None or (b[0] is not None and b[0] < a[0]):
        return b
    return a if b[0] is None or a[0] < b[0] else (a[0], a[1] or b[1])


def narrow(f: Formula, box: Box, params: Mapping[str, tuple[Q, Q]], strict: bool = False) -> Box | None:
    """The box cut down by the bounds that `f` puts on single variables; None where that leaves nothing.

    Literals on several variables are not used, those on params only by their range. Unless `strict`, bounds are read
    as closed and `!=` is not used: certificates know no open ends.
    """
    if isinstance(f, bool):
        return box if f else None
    if isinstance(f, Literal):
        return _narrow_literal(f, box, params, strict)
    if f.is_and:
        for m in f.members:
            narrowed = narrow(m, box, params, strict)
            if narrowed is None:
                return None
            box = narrowed
        return box
    return _narrow_alternatives(f, box, params, strict)


def _narrow_alternatives(f: Junction, box: Box, params: Mapping[str, tuple[Q, Q]], strict: bool) -> Box | None:
    result: Box | None = None
    for m in f.members:
        part = narrow(m, box, params, strict)
        if part is not None:
            result = part if result is None else {v: result[v].hull(part[v]) for v in box}
    return result


def _narrow_literal(f: Literal, box: Box, params: Mapping[str, tuple[Q, Q]], strict: bool) -> Box | None:
    found = single(f.polynomial, box)
    if found is None or not all(v in params for v in found[2].variables):
        return box
    name, factor, rest = found
    low, high = range_on(rest, params)
    if name is None:
        return None if strict and by_bounds(f.op, low, high) is False else box
    cut = box[name].meet(_allowed(f.op, factor, low, high, strict))
    if cut.is_empty or (strict and f.op == "!=" and low == high and cut.is_point and cut.low == -low / factor):
        return None
    return box if cut == box[name] else {**box, name: cut}


def _allowed(op: str, factor: Q, low: Q, high: Q, strict: bool) -> Interval:
    """Where `factor * v + r op 0` for some r in [low, high]."""
    if op == "!=":
        return EVERYTHING
    ends = sorted((-low / factor, -high / factor))
    if op == "==":
        return Interval(ends[0], ends[1])
    is_open = strict and op == "<"
    return Interval(None, ends[1], False, is_open) if factor > 0 else Interval(ends[0], None, is_open, False)


def single(p: Polynomial, box: Mapping[str, object]) -> tuple[str | None, Q, Polynomial] | None:
    """`(v, a, r)` with `p = a v + r`, `a` a rational, `r` free of the box's variables; v is None where `p` has none."""
    names = [v for v in p.variables if v in box]
    if not names:
        return None, Q(0), p
    if len(names) > 1:
        return None
    parts = p.coefficients(names[0])
    factor = parts[1].constant if len(parts) == 2 else None
    return None if factor is None else (names[0], factor, parts[0])


def image(p: Polynomial, box: Box, params: Mapping[str, tuple[Q, Q]]) -> Interval:
    """An interval around the values of `p` on the box: exact ends for a polynomial of degree one in each variable."""
    names = p.variables
    if len(names) == 1 and names[0] in box and p.degree(names[0]) == 1:
        return _affine(p, box[names[0]], names[0])
    ends = dict(params)
    for v in names:
        if v in box:
            low, high = box[v].low, box[v].high
            if low is None or high is None:
                return EVERYTHING
            ends[v] = (low, high)
    low, high = range_on(p, ends)
    return Interval(low, high)


def _affine(p: Polynomial, x: Interval, name: str) -> Interval:
    base, slope = p.coefficients(name)
    a, b = slope.constant or Q(0), base.constant or Q(0)
    low = None if x.low is None else a * x.low + b
    high = None if x.high is None else a * x.high + b
    return Interval(low, high) if a > 0 else Interval(high, low)
