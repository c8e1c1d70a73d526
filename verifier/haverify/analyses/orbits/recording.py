"""Recorded laps around a periodic orbit, and recorded ways to it, as the kernel follows them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import zip_longest
from math import ldexp
from typing import Any

from haverify.analyses.hybrid.conditions import Condition
from haverify.analyses.hybrid.listing import Judged, listings
from haverify.analyses.hybrid.model import HybridModel
from haverify.analyses.hybrid.record import polynomial, precision, step_json
from haverify.analyses.hybrid.starts import linear
from haverify.analyses.orbits.basin import Part
from haverify.analyses.orbits.laps import BEGIN, Cut, Frame, derived, modelled, opened
from haverify.analyses.orbits.orbit import Plane
from haverify.maths.interval import Interval
from haverify.model.expression import Expr, number
from haverify.simulate.derivative import ZERO
from haverify.solvers.kernel import Budget, ModeListing, RecordedStretch, Settings, Step, grown, recorded
from haverify.text.record import holder, record, replace

Q = Fraction
Json = Any
Sides = dict[str, tuple[Q, Q]]
ORDER, ERROR, LONGEST, LEAST = 14, 1e-12, 1 / 24, 1e-10
VARIED, DEGREE = 2, 3  # of polynomials in the set: beside derivatives, and without
DEEPEST = 9  # halvings of a box
BENT = 1 / 30  # of the section's size: where terms of the highest degree are larger, the checker's errors are too large
STEPS, STRETCHES = 1000, 60
LATE, BEYOND = 0.8, 1.2  # of a lap: it ends in between
LAPS = 2.2  # after which runs have come to the section
PRECISION = 46  # bits behind the point; errors grow in a lap
FARTHER = 1.6  # times its length: so far a step is followed to the plane
NEARLY = 0.3  # of the width of a set: so near to a border it is not known to be inside
LEEWAY = 1e-5  # of the period, for the checker's errors
ROOM, ROOMY = 0.99, 1.03  # of a section: what comes into it; times what comes: one that holds it
LESS, MOST = 0.98, 30  # a section after a lap, as a part of that before it; how many there are


@record
class Way:
    """Stretches one after the other, with the edges in between; the last one ends where the plane is crossed."""

    rows: tuple[RecordedStretch, ...]
    edges: tuple[int, ...]

    @property
    def monomials(self) -> list[list[int]]:
        """Those of all steps."""
        return self.rows[0].steps[0][0]

    def steps(self) -> Iterator[tuple[list[list[int]], Step]]:
        """All steps."""
        return (step for row in self.rows for step in row.steps)


@record
class Basin:
    """The record of ways to a section larger by the first share, and one of laps from share to share, if any."""

    into: Json
    shares: list[float]
    narrower: Json | None


@holder
class Following:
    """The automaton as the kernel follows it: with derivatives, from coordinates of a section, or as it is."""

    plane: Plane
    cut: Cut

    def __post_init__(self) -> None:
        model, cut = self.plane.model, self.cut
        whole, count = opened(model, cut), len(model.modes)
        modes = [*whole.modes[:count], *(m for m in whole.modes if m.name == BEGIN)]
        edges = [*whole.edges[: len(model.automaton.edges)], *(e for e in whole.edges if e.source == BEGIN)]
        self.track: HybridModel = modelled(model, replace(whole, modes=tuple(modes), edges=tuple(edges)))
        places = len(modes)
        nothing = tuple(() for _ in range(places))
        landing: dict[int, Condition] = dict.fromkeys(range(len(edges)), True)
        self.modes: list[ModeListing] = listings(self.track, Judged((True,) * places, landing, True, nothing, nothing))
        self.vars = [v.name for v in self.track.automaton.vars]

    def rows(self, mode: str, start: dict[str, Interval], degree: int, laps: float) -> list[RecordedStretch]:
        """The stretches from a set of states, up to a time."""
        period, size = self.plane.orbit.period, self.plane.size
        sides = [start.get(n, Interval.at(0)) for n in self.track.names]
        settings = Settings(ORDER, degree, ERROR * max(1e-6, size), min(0.02, period * LONGEST), period * LONGEST,
                            period * LEAST, STEPS, 4)  # fmt: skip
        where = self.track.mode(mode), [(x.low, x.high) for x in sides], list[tuple[int, str]]()
        return recorded(grown(self.modes, where, laps * period, "horizon", settings, Budget(STRETCHES, STRETCHES, 0)))

    def edge(self, before: RecordedStretch, after: RecordedStretch) -> int:
        """The number of the edge between two stretches."""
        assert after.edge is not None, "a stretch after the first begins with a jump"
        return self.track.edges[before.mode][after.edge]


@holder
class Recording:
    """Laps of a section, which is a frame in a mode, and ways that lead to it."""

    plane: Plane
    mode: str
    frame: Frame
    share: Q  # of the sizes of variables, which the section has about

    def __post_init__(self) -> None:
        ((self.variable, self.value),) = self.frame.others.items()
        self.quantity = Expr("-", (Expr("var", (self.variable,)), number(self.value)))

        self._lap = self._lap_of(1.0, tuple(self.frame.centre), VARIED)

    def _lap_of(self, share: float, columns: tuple[str, ...], degree: int) -> tuple[Following, Way | None]:
        """The lap of the section, or of one that is larger by a factor, with derivatives by some variables."""
        borders = dict(self.plane.borders())
        cut = Cut(self.mode, self.mode, self.quantity, Q(10**6), columns, borders, self.frame)
        following = Following(self.plane, cut)
        start = {"time": Interval.at(-1), **dict.fromkeys(self.frame.centre, Interval(-share, share))}
        rows = following.rows(BEGIN, start, degree, BEYOND)
        return following, next(self._ways(following, rows, 1, LATE * self.plane.orbit.period), None)

    def lap(self) -> Json | None:
        """The record of the lap of the whole section; None where none is found."""
        following, way = self._lap
        return None if way is None else self._file(following, list(self.frame.centre), [way])

    def basin(self, areas: Sequence[Part]) -> Basin | None:
        """Records of ways into the section from all states of some boxes, by sections that are larger if need be."""
        following = Following(self.plane, Cut(self.mode, self.mode, self.quantity, Q(10**6)))
        boxes = [(a.mode, dict(zip(self.plane.names, a.box, strict=True))) for a in areas]
        trees = [self._tree(following, mode, box, DEEPEST) for mode, box in boxes]
        shares, laps = [1.0], list[Way]()
        if None in trees:
            trees = [next(self._ways(following, self._rows(following, *b), 0, 0.0), None) for b in boxes]
            if None in trees:
                return None
            first = max(self._far(following, way) for way in trees)
            shares, laps = self._narrower(first * ROOMY)
            if not laps:
                return None
        varied = {v for _, box in boxes for v, (low, high) in box.items() if low < high}
        into = self._file(following, [v for v in self.plane.names if v in varied], trees)
        narrower = self._file(following, list(self.frame.centre), laps) if laps else None
        return None if into is None or (laps and narrower is None) else Basin(into, shares, narrower)

    def _narrower(self, first: float) -> tuple[list[float], list[Way]]:
        """Sections that are larger than this one by factors, each with a lap that leads to the next; none at last."""
        shares, laps = [first], list[Way]()
        while shares[-1] > 1:
            following, way = self._lap_of(shares[-1], (), DEGREE)
            after = 2 * first if way is None else max(1.0, self._far(following, way) * ROOMY)
            if way is None or after > shares[-1] * LESS or len(laps) >= MOST:
                return [], []
            shares.append(after)
            laps.append(way)
        return shares, laps

    def _rows(self, following: Following, mode: str, box: Sides) -> list[RecordedStretch]:
        return following.rows(mode, {v: Interval.between(*s) for v, s in box.items()}, DEGREE, LAPS)

    def _tree(self, following: Following, mode: str, box: Sides, depth: int) -> Any:
        """A way, or a variable with the trees of its halves; None where no way is found for some piece."""
        rows = self._rows(following, mode, box)
        way = next((w for w in self._ways(following, rows, 0, 0.0) if self._comes_in(following, w)), None)
        if way is not None and not self._is_bent(way, DEGREE):
            return way
        if depth == 0:
            return None
        shares = {v: (high - low) / Q(self.plane.sizes[v]) for v, (low, high) in box.items()}
        widest = max(shares, key=lambda v: shares[v])
        low, high = box[widest]
        half = (low + high) / 2
        found = []
        for side in ((low, half), (half, high)):
            found.append(self._tree(following, mode, {**box, widest: side}, depth - 1))
            if found[-1] is None:
                return None
        return (widest, *found)

    def _ways(self, following: Following, rows: list[RecordedStretch], first: int, late: float) -> Iterator[Way]:
        """Ways to the plane in the direction of the orbit, after some time, along stretches without a choice."""
        sign, names = self._sign(), following.track.names
        k, clock = names.index(self.variable), names.index("time")
        chain, edges = list[RecordedStretch](), list[int]()
        number: int | None = first
        while number is not None and number < len(rows):
            row = rows[number]
            for n, (_, (h, series)) in enumerate(row.steps):
                far = h * FARTHER
                before, there, after = (_reach(series[k], t, sign, float(self.value)) for t in (0.0, h, far))
                is_there = following.track.modes[row.mode].name == self.mode
                if is_there and sum(series[clock][0][:1]) + h > late and before[1] < 0 <= there[1] and after[0] > 0:
                    last = row.steps[n][0], (_passed(series[k], far, sign, float(self.value)), series)
                    yield Way((*chain, replace(row, steps=[*row.steps[:n], last])), tuple(edges))
            following_rows = [i for i, r in enumerate(rows) if r.parent == number]
            if row.end != "jumped" or len(following_rows) != 1 or not row.steps:
                return
            (number,) = following_rows
            edges.append(following.edge(row, rows[number]))
            chain.append(self._bordered(following, row, edges[-1]))

    def _bordered(self, following: Following, row: RecordedStretch, edge: int) -> RecordedStretch:
        """A stretch that leads to a border: without the last step, if the one before it leads there when made longer.

        Where it ends near the border, the checker would not know that all states are still inside.
        """
        border = dict(self.plane.borders()).get(edge)
        values, known = self.plane.model.values, self.plane.sizes
        slopes, rest = ({}, Q(0)) if border is None else linear(Expr("<=", (ZERO, border)), known, values)
        if not slopes or len(row.steps) < 2:
            return row
        names, (monomials, (h, series)) = following.track.names, row.steps[-2]
        parts = [(float(q), series[names.index(v)]) for v, q in slopes.items()]
        powers = [_sum([[q * c for c in x[i]] for q, x in parts if i < len(x)]) for i in range(max(map(len, series)))]
        at_zero = -float(rest)
        sign = 1 if _reach(powers, h * FARTHER, 1, at_zero)[0] > 0 else -1
        there, after = (_reach(powers, t, sign, at_zero) for t in (h, h * FARTHER))
        if after[0] <= 0 or there[1] < NEARLY * (there[0] - there[1]) or there[0] > 0:
            return row
        last = monomials, (_passed(powers, h * FARTHER, sign, at_zero), series)
        return replace(row, steps=[*row.steps[:-2], last])

    def _sign(self) -> int:
        """The direction in which the orbit crosses the plane."""
        simulated = self.plane.guesses.model
        state = {**{v: float(c) for v, c in self.frame.centre.items()}, self.variable: float(self.value)}
        values = [state.get(n, 0.0) for n in simulated.names]
        rates = simulated.kernel.slopes(simulated.mode(self.mode), values)
        return 1 if rates[simulated.names.index(self.variable)] > 0 else -1

    def _comes_in(self, following: Following, way: Way) -> bool:
        """Whether a way ends in the section, but for small errors."""
        return self._far(following, way) < ROOM

    def _far(self, following: Following, way: Way) -> float:
        """How far from the middle of the section a way ends, in units of that."""
        return max((sum(map(abs, row)) for row in self._ends(following, way)), default=0.0)

    def contracts(self) -> float:
        """How much the lap contracts, by the recorded polynomials; 1 where it does not, or leaves the section."""
        following, way = self._lap
        if way is None or not self._comes_in(following, way) or self._is_bent(way, VARIED):
            return 1.0
        found = [self._ends(following, way, c) for c in self.frame.centre]
        return max((sum(sum(map(abs, column[i])) for column in found) for i in range(len(found))), default=0.0)

    def period(self) -> tuple[float, float]:
        """Between what the laps of the section last, with some room."""
        following, way = self._lap
        assert way is not None, "a lap was found"
        names, (h, series) = following.track.names, way.rows[-1].steps[-1][1]
        k, clock = names.index(self.variable), names.index("time")
        t = self._instant(series[k], h)
        off, speed = _at(series[k], t), _speed(series[k], t)
        row = [x - y / speed for x, y in zip_longest(_at(series[clock], t), [0.0, *off[1:]], fillvalue=0.0)]
        wide = sum(map(abs, row[1:])) * 2 + row[0] * (LEEWAY + float(self.share) / 100)
        return row[0] - wide, row[0] + wide

    def _is_bent(self, way: Way, degree: int) -> bool:
        """Whether some terms of the highest degree are large beside the section."""
        tops = [m for m, exponents in enumerate(way.monomials) if sum(exponents) == degree]
        sizes = [float(self.share) * self.plane.sizes[v] for v in self.plane.names]
        return any(
            sum(abs(row[m]) * h**i for i, row in enumerate(x) for m in tops if m < len(row)) > BENT * size
            for _, (h, series) in way.steps() for x, size in zip(series, sizes, strict=False)
        )  # fmt: skip

    def _ends(self, following: Following, way: Way, by: str | None = None) -> list[list[float]]:
        """Where a way ends in coordinates of the section, or the derivatives of that: polynomials of the set."""
        names, (h, series) = following.track.names, way.rows[-1].steps[-1][1]
        k = names.index(self.variable)
        t = self._instant(series[k], h)

        def at(v: str) -> list[float]:
            return _at(series[names.index(v if by is None else derived(v, by))], t)

        off, speed = at(self.variable), _speed(series[k], t)
        off[0] -= float(self.value) if by is None else 0.0
        found = []
        for v, c in self.frame.centre.items():
            share = _speed(series[names.index(v)], t) / speed
            row = [x - share * y for x, y in zip_longest(at(v), off, fillvalue=0.0)]
            row[0] -= float(c) if by is None else 0.0
            found.append(row)
        columns = list(zip_longest(*found, fillvalue=0.0))
        back = [[float(q) for q in row] for row in self.frame.back]
        return [[sum(q * x for q, x in zip(row, terms, strict=True)) for terms in columns] for row in back]

    def _instant(self, series: list[list[float]], h: float) -> float:
        """When the middle of a set is on the plane, in a step in which it gets there."""
        low, high, sign = 0.0, h, self._sign()
        for _ in range(60):
            t = (low + high) / 2
            low, high = (t, high) if (_at(series, t)[0] - float(self.value)) * sign < 0 else (low, t)
        return low

    # What is written

    def _file(self, following: Following, varied: list[str], trees: Sequence[Any]) -> Json | None:
        """The record of some trees of ways; None where it would not do."""
        ways = [w for tree in trees for w in _leaves(tree)]
        if None in ways:
            return None
        bits = precision([step for w in ways for _, step in w.steps()], PRECISION)
        monomials = ways[0].monomials
        if bits is None or any(m != monomials for w in ways for m, _ in w.steps()) or len(monomials[0]) != len(varied):
            return None
        return {
            "schema": "haverify.flow/1", "automaton": self.plane.model.automaton.name, "bits": bits, "order": ORDER,
            "set": varied, "monomials": monomials,
            "starts": [{"pieces": self._pieces(following, tree, bits)} for tree in trees],
        }  # fmt: skip

    def _pieces(self, following: Following, tree: Any, bits: int) -> Json:
        if isinstance(tree, Way):
            return self._stretch(following, tree, 0, bits)
        split, low, high = tree
        return {"split": split, "low": self._pieces(following, low, bits), "high": self._pieces(following, high, bits)}

    def _stretch(self, following: Following, way: Way, number: int, bits: int) -> Json:
        count, names, row = len(following.vars), len(following.track.names), way.rows[number]
        steps = []
        for _, (h, series) in row.steps:
            pace = series[names][0] if len(series) > names else None
            steps.append(step_json(max(1, round(ldexp(h, bits))), series[:count], bits, pace))
        if number == len(way.rows) - 1:
            return {"steps": steps}
        after = way.rows[number + 1]
        begun = [polynomial(x[0], 1.0, bits) for x in after.steps[0][1][1][:count]]
        jump = {"edge": way.edges[number], "x": begun, **self._stretch(following, way, number + 1, bits)}
        return {"steps": steps, "jumps": [jump]}


def _leaves(tree: Any) -> Iterator[Any]:
    if isinstance(tree, tuple):
        for inner in tree[1:]:
            yield from _leaves(inner)
    else:
        yield tree


def _sum(rows: list[list[float]]) -> list[float]:
    return [sum(column) for column in zip_longest(*rows, fillvalue=0.0)]


def _at(series: list[list[float]], t: float) -> list[float]:
    """The coefficients of the set's monomials at an instant, but for rounding."""
    count = max(1, *map(len, series))
    return [sum(row[m] * t**i for i, row in enumerate(series) if m < len(row)) for m in range(count)]


def _speed(series: list[list[float]], t: float) -> float:
    return sum(i * row[0] * t ** (i - 1) for i, row in enumerate(series) if i and row)


def _reach(series: list[list[float]], t: float, sign: int, value: float) -> tuple[float, float]:
    """Bounds of `sign` times how far a polynomial is from a value, at an instant, but for rounding."""
    terms = _at(series, t)
    middle, off = sign * (terms[0] - value), sum(map(abs, terms[1:]))
    return middle - off, middle + off


def _passed(series: list[list[float]], h: float, sign: int, value: float) -> float:
    """A part of a step after which all of a set is beyond a plane, if it is at the end."""
    low, high = 0.0, h
    for _ in range(30):
        t = (low + high) / 2
        low, high = (low, t) if _reach(series, t, sign, value)[0] > 0 else (t, high)
    return min(h, high + h / 20)
