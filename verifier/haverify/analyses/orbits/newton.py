"""Newton's method in intervals on the return of a section: a periodic orbit that exists, and no other near it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction

from haverify.analyses.orbits.linear import Matrix, inverse, product
from haverify.analyses.orbits.returns import Box, Lap, Track, finely
from haverify.maths.interval import Interval
from haverify.solvers.kernel import Settings
from haverify.text.record import holder, record

Q = Fraction
TRIES = 8  # boxes that are tried, each a few times larger than the one before
LARGER = 8.0
ROOM = 4.0  # times what the first step moves
LEAST = 2e-13  # of the size of a variable: no box is narrower at first
TIGHTENED = 3  # steps once the orbit is known


@record
class Fixed:
    """A fixed point of the return map, in a box that holds no other; the lap of all runs from the box."""

    box: Box
    lap: Lap


@holder
class Search:
    """The return map as functions of some variables, others being constant or given."""

    track: Track
    columns: tuple[str, ...]
    given: Mapping[str, Interval]
    sizes: Sequence[float]

    def fixed(self, guess: Sequence[float]) -> Fixed | None:
        """The fixed point near a guess, if Newton's method shows that there is one (Krawczyk's form of it).

        `K(X) = c - C (R(c) - c) + (1 - C (DR(X) - 1)) (X - c)`: in the interior of X it holds the only fixed point of
        R in X; C is near the inverse of DR - 1, and nothing else is asked of it.
        """
        settings, back = self._settings(), list[list[Interval]]()
        for _ in range(2):
            here = self._lap([Interval.at(x) for x in guess], settings)
            near = None if here is None else self._newton(here.slopes)
            if here is None or near is None:
                return None
            back = near
            moved = _applied(back, self._missing(here, guess))
            guess = [x - m.midpoint for x, m in zip(guess, moved, strict=True)]
        centre = [Interval.at(x) for x in guess]
        here = self._lap(centre, settings)
        if here is None:
            return None
        moved = _applied(back, self._missing(here, guess))
        radii = [max(ROOM * abs(m).high, LEAST * s) for m, s in zip(moved, self.sizes, strict=True)]
        for _ in range(TRIES):
            box = [c + Interval(-r, r) for c, r in zip(centre, radii, strict=True)]
            around = self._lap(box, settings)
            if around is None:
                return None
            found = self._krawczyk(guess, moved, back, around, box)
            if all(b.low < k.low and k.high < b.high for b, k in zip(box, found, strict=True)):
                return self._tightened(guess, moved, back, found)
            radii = [max(LARGER * r, 2 * abs(k - c).high) if not _inside(k, b) else r
                     for r, k, b, c in zip(radii, found, box, centre, strict=True)]  # fmt: skip
        return None

    def _tightened(
        self, guess: Sequence[float], moved: list[Interval], back: Matrix, box: list[Interval]
    ) -> Fixed | None:
        """The same fixed point in the smaller boxes that the steps come to."""
        lap = None
        for _ in range(TIGHTENED):
            wide = [b.hull(Interval.at(x)) for b, x in zip(box, guess, strict=True)]
            around = self._lap(wide, self._settings())
            if around is None:
                break
            lap = around
            found = [
                k.intersection(b) for k, b in zip(self._krawczyk(guess, moved, back, around, box), box, strict=True)
            ]
            if sum(k.width for k in found) > 0.9 * sum(b.width for b in box):
                break
            box, lap = found, around
        return None if lap is None else Fixed(dict(zip(self.columns, box, strict=True)), lap)

    def _settings(self) -> Settings:
        return finely(self.given, self.track.length, self.track.size)

    def _lap(self, box: Sequence[Interval], settings: Settings) -> Lap | None:
        return self.track.lap({**self.given, **dict(zip(self.columns, box, strict=True))}, settings)

    def _missing(self, lap: Lap, guess: Sequence[float]) -> list[Interval]:
        return [lap.state[v] - x for v, x in zip(self.columns, guess, strict=True)]

    def _newton(self, slopes: Matrix) -> Matrix | None:
        """Near the inverse of the derivative less one."""
        back = inverse([[Q(x.midpoint) - (i == j) for j, x in enumerate(row)] for i, row in enumerate(slopes)])
        return None if back is None else [[Interval.at(float(x)) for x in row] for row in back]

    def _krawczyk(
        self, guess: Sequence[float], moved: Sequence[Interval], back: Matrix, around: Lap, box: Sequence[Interval]
    ) -> list[Interval]:
        one = [[x - int(i == j) for j, x in enumerate(row)] for i, row in enumerate(around.slopes)]
        rest = [[int(i == j) - x for j, x in enumerate(row)] for i, row in enumerate(product(back, one))]
        off = _applied(rest, [b - x for b, x in zip(box, guess, strict=True)])
        return [Interval.at(x) - m + o for x, m, o in zip(guess, moved, off, strict=True)]


def _inside(k: Interval, b: Interval) -> bool:
    return b.low < k.low and k.high < b.high


def _applied(a: Matrix, x: Sequence[Interval]) -> list[Interval]:
    return [row[0] for row in product(a, [[y] for y in x])]
