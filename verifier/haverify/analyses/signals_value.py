"""Bounded STL in three values on a timeline of dwells whose lengths are known exactly or within bounds (LANGUAGE S21).

Instants are pairs of a dwell and the time `s` since it began. A set of them is, for each dwell, a list of disjoint
intervals `[cut, cut)`; the cut `(x, 0)` lies just before the number x, `(x, 1)` just after it, so that closed, open and
single-point intervals are all of this form and moving one by a number keeps its ends.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from functools import cached_property
from itertools import accumulate

from haverify.text.record import record

Q = Fraction
Cut = tuple[Q, int]
Span = tuple[Cut, Cut]
Spans = tuple[Span, ...]  # disjoint, not touching, in order
Place = tuple[int, Cut]  # a dwell, and a cut in it
ZERO: Cut = (Q(0), 0)


@record
class Dwell:
    """One stay in a mode: it lasts at least `low` and at most `high`, and begins at a time within `clock`."""

    low: Q
    high: Q
    clock: tuple[Q, Q]

    @property
    def end(self) -> Cut:
        """Just after its last instant."""
        return (self.high, 1)


@record
class Window:
    """The ends of `[a, b]`, each known within bounds (they are scaled by the rate of the clocks)."""

    a: tuple[Q, Q]
    b: tuple[Q, Q]


@record
class Signal:
    """Where a formula certainly holds (`must`), and where it is not certainly false (`may`), dwell by dwell."""

    must: tuple[Spans, ...]
    may: tuple[Spans, ...]


@record
class Timeline:
    """The dwells of a run, or of all runs that go through the same cells."""

    dwells: tuple[Dwell, ...]

    @cached_property
    def _lows(self) -> list[Q]:
        return [Q(0), *accumulate(d.low for d in self.dwells)]

    @cached_property
    def _highs(self) -> list[Q]:
        return [Q(0), *accumulate(d.high for d in self.dwells)]

    def least(self, i: int, j: int) -> Q:
        """The least time from the beginning of dwell i to that of dwell j >= i."""
        return max(self._lows[j] - self._lows[i], self.dwells[j].clock[0] - self.dwells[i].clock[1])

    def most(self, i: int, j: int) -> Q:
        """The greatest time from the beginning of dwell i to that of dwell j >= i."""
        return min(self._highs[j] - self._highs[i], self.dwells[j].clock[1] - self.dwells[i].clock[0])

    def within(self, limit: Q) -> int:
        """The last dwell that may begin as soon as this after the start."""
        return max(i for i in range(len(self.dwells)) if self.least(0, i) <= limit)

    @cached_property
    def everywhere(self) -> tuple[Spans, ...]:
        """All instants."""
        return tuple(((ZERO, d.end),) for d in self.dwells)


def joined(spans: Sequence[Span]) -> Spans:
    """The union of spans in any order, empty ones left out."""
    out: list[Span] = []
    found = [s for s in spans if s[0] < s[1]]
    for low, high in sorted(found) if len(found) > 1 else found:
        if out and low <= out[-1][1]:
            out[-1] = (out[-1][0], max(out[-1][1], high))
        else:
            out.append((low, high))
    return tuple(out)


def common(a: Spans, b: Spans) -> Spans:
    """The intersection."""
    out: list[Span] = []
    i = j = 0
    while i < len(a) and j < len(b):
        low, high = max(a[i][0], b[j][0]), min(a[i][1], b[j][1])
        if low < high:
            out.append((low, high))
        if a[i][1] <= b[j][1]:
            i += 1
        else:
            j += 1
    return tuple(out)


def rest(a: Spans, whole: Span) -> Spans:
    """The complement in `whole`."""
    cuts = [whole[0], *(c for s in a for c in s), whole[1]]
    return joined([(max(low, whole[0]), min(high, whole[1])) for low, high in zip(cuts[::2], cuts[1::2], strict=True)])


def denied(t: Timeline, x: Signal) -> Signal:
    """`not`."""
    must = tuple(rest(s, (ZERO, d.end)) for s, d in zip(x.may, t.dwells, strict=True))
    may = tuple(rest(s, (ZERO, d.end)) for s, d in zip(x.must, t.dwells, strict=True))
    return Signal(must, may)


def both(x: Signal, y: Signal) -> Signal:
    """`and`."""
    return Signal(tuple(map(common, x.must, y.must)), tuple(map(common, x.may, y.may)))


def either(x: Signal, y: Signal) -> Signal:
    """`or`."""

    def union(a: Spans, b: Spans) -> Spans:
        return joined((*a, *b))

    return Signal(tuple(map(union, x.must, y.must)), tuple(map(union, x.may, y.may)))


def chains(t: Timeline, sets: Iterable[tuple[int, Spans]]) -> list[tuple[Place, Place]]:
    """The maximal connected parts of a set: from a cut in one dwell to a cut in the same or a later one."""
    found: list[tuple[Place, Place]] = []
    for i, spans in sets:
        for low, high in spans:
            if found and low == ZERO and found[-1][1] == (i - 1, t.dwells[i - 1].end):
                found[-1] = (found[-1][0], (i, high))
            else:
                found.append(((i, low), (i, high)))
    return found


def shifted(c: Cut, by: Q) -> Cut:
    """The cut moved by a number."""
    return (c[0] + by, c[1])


def _surely(t: Timeline, first: Place, last: Place, w: Window, need: int) -> Iterator[tuple[int, Span]]:
    """Where, in dwells up to `need`, an instant in the window certainly lies between the two places."""
    (j, low), (k, high) = first, last
    a, b = w.a[1], w.b[0]
    certain = low < (t.dwells[j].low, 1)  # that the run gets to where it begins
    end = min(high, (t.dwells[k].low, 1))
    for i in range(min(k, need), -1, -1):
        if i < j and (not certain or shifted(low, t.least(i + 1, j)) >= (b, 1)):
            return
        begin = ZERO if i > j else shifted(low, t.most(i, j) - b) if certain else low
        if i == k:
            until = high if a == 0 else shifted(end, -a)
        elif shifted(end, t.least(i + 1, k)) > (a, 0):
            until = t.dwells[i].end
        else:
            until = shifted(end, t.least(i, k) - a)
        yield i, (max(begin, ZERO), min(until, t.dwells[i].end))


def _perhaps(t: Timeline, j: int, span: Span, w: Window, need: int) -> Iterator[tuple[int, Span]]:
    """Where, in dwells up to `need`, an instant in the window may lie in a span of dwell j."""
    low, high = span
    a, b = w.a[0], w.b[1]
    for i in range(min(j, need), -1, -1):
        if i < j and shifted(low, t.least(i + 1, j)) >= (b, 1):
            return
        ends = shifted(low, t.least(i, j) - b), shifted(high, t.most(i, j) - a)
        yield i, (max(ends[0], ZERO), min(ends[1], t.dwells[i].end))


def _part(t: Timeline, first: Place, last: Place, i: int) -> Span:
    """What lies in dwell i of all between two places."""
    low = first[1] if i == first[0] else ZERO
    return (low, last[1] if i == last[0] else t.dwells[i].end)


def _with_next(t: Timeline, last: Place) -> Place:
    """A place moved behind the instant that follows, if one does: `until` wants nothing of the first formula there."""
    k, cut = last
    if cut == t.dwells[k].end:
        return (k + 1, (Q(0), 1)) if k + 1 < len(t.dwells) else last
    return (k, (cut[0], 1))


def _inside(t: Timeline, sets: Sequence[Spans], first: Place, last: Place) -> list[tuple[int, Spans]]:
    """A set cut to what lies between two places."""
    return [(i, common(sets[i], (_part(t, first, last, i),))) for i in range(first[0], last[0] + 1) if sets[i]]


def _loose(t: Timeline, sets: Sequence[Spans]) -> list[Spans]:
    """The set and all instants which a run may have skipped by leaving early."""
    return [joined((*s, ((d.low, 1), d.end))) for s, d in zip(sets, t.dwells, strict=True)]


def until(t: Timeline, x: Signal, y: Signal, w: Window, need: int) -> Signal:
    """`x until[a, b] y`, at the instants of dwells up to `need`."""
    must: list[list[Span]] = [list(s) if w.a[1] == 0 else [] for s in y.must]
    may: list[list[Span]] = [list(s) if w.a[0] == 0 else [] for s in y.may]

    def note(found: list[list[Span]], i: int, span: Span, first: Place, last: Place) -> None:
        if first[0] <= i <= last[0] and span[0] < span[1]:
            found[i] += common((span,), (_part(t, first, last, i),))

    for first, last in chains(t, enumerate(x.must)):
        for start, end in chains(t, _inside(t, y.must, first, _with_next(t, last))):
            for i, span in _surely(t, start, end, w, need):
                note(must, i, span, first, last)
    for first, last in chains(t, enumerate(_loose(t, x.may))):
        for j, spans in _inside(t, y.may, first, _with_next(t, last)):
            for inner in spans:
                for i, span in _perhaps(t, j, inner, w, need):
                    note(may, i, span, first, last)
    return Signal(tuple(map(joined, must)), tuple(map(joined, may)))


def eventually(t: Timeline, x: Signal, w: Window, need: int) -> Signal:
    """`eventually[a, b] x`: until, from anything."""
    return until(t, Signal(t.everywhere, t.everywhere), x, w, need)


def globally(t: Timeline, x: Signal, w: Window, need: int) -> Signal:
    """`globally[a, b] x`: not eventually not."""
    return denied(t, eventually(t, denied(t, x), w, need))


def at_start(x: Signal) -> bool | None:
    """The truth at the first instant of all."""
    if x.must[0] and x.must[0][0][0] == ZERO:
        return True
    return None if x.may[0] and x.may[0][0][0] == ZERO else False
