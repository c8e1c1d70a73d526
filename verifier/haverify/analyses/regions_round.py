"""Round numbers: points that people can read, with the same truth as a point that was found."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction

Point = dict[str, Fraction]
_STEPS = (Fraction(1), Fraction(1, 2), Fraction(1, 10), Fraction(1, 20), Fraction(1, 100))


def rounded(
    point: Mapping[str, Fraction],
    ranges: Mapping[str, tuple[Fraction, Fraction]],
    serves: Callable[[Point], bool],
) -> Point:
    """The point with each value, one after the other, replaced by the roundest one with which it still serves."""
    out = dict(point)
    for name in sorted(out):
        for q in _candidates(out[name], ranges[name]):
            if serves({**out, name: q}):
                out[name] = q
                break
    return out


def _candidates(q: Fraction, ends: tuple[Fraction, Fraction]) -> Iterator[Fraction]:
    """Round numbers near q within its range, rounder ones first; the ends of the range count as round."""
    seen = {q}
    for step in _STEPS:
        if q % step == 0:
            return
        nearest = round(q / step) * step
        for near in (nearest, nearest + step, nearest - step):
            if ends[0] <= near <= ends[1] and near not in seen:
                seen.add(near)
                yield near
    for end in ends:
        if end not in seen:
            yield end
    if q.denominator > 10**6:
        yield q.limit_denominator(10**4)
