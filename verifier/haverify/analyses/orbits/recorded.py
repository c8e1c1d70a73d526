"""What a certificate says of a periodic orbit: a box of P's own plane, and a recorded lap of it with derivatives.

They prove nothing by themselves: the checker bounds how far solutions are from what is recorded, and how they depend
on their start (docs/core.md section 8). Of one mode without jumps, params, domains that end runs.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import ldexp
from typing import Any

from haverify.analyses.hybrid.listing import Judged, listings
from haverify.analyses.hybrid.record import precision, step_json
from haverify.analyses.orbits.basin import Part
from haverify.analyses.orbits.laps import Cut, derived, modelled, opened
from haverify.analyses.orbits.linear import inverse
from haverify.analyses.orbits.newton import Fixed
from haverify.analyses.orbits.orbit import Passed, Plane
from haverify.analyses.orbits.passing import Crossed
from haverify.maths.digits import rational_text
from haverify.maths.interval import Fault, Interval
from haverify.model.expression import Expr, number
from haverify.solvers.kernel import Budget, RecordedStretch, Settings, Step, grown, recorded
from haverify.text.record import holder, record, replace

Q = Fraction
Json = Any
Sides = dict[str, tuple[Q, Q]]
Leaf = list[tuple[list[list[int]], Step]]
ORDER, ERROR, LONGEST, LEAST = 14, 1e-12, 1 / 24, 1e-10
NEAR, ROUND = Q(1, 400_000), Q(1, 4000)  # of a variable's size: boxes with a fixed point, and to which runs come
DEEPEST = 6  # halvings of a box
SPREAD = Q(1, 160)  # of a variable's size: wider sets are not followed at once
MOST_MOVING = 16  # variables; the checker takes no more
STEPS = 1000
LATE, BEYOND = 0.8, 1.2  # of a lap: it ends in between
PRECISION = 46  # bits behind the point; errors grow in a lap
SLACK = {False: Q(1, 50_000), True: Q(1, 2000)}  # of the period: laps from such boxes, of fixed points or round ones


@record
class Recorded:
    """What the certificate says of an orbit, and the files of its records."""

    entry: dict[str, Json]
    files: dict[str, Json]


@record
class Pinned:
    """The plane `variable = value` that P names, and the box of all states with P."""

    variable: str
    value: Q
    box: Sides


def recorded_orbit(plane: Plane, fixed: Fixed, passed: Passed, areas: Sequence[Part], attracting: bool,
                   name: str) -> Recorded | None:  # fmt: skip
    """The certificate's part about an orbit that is proved; None where the checker would not follow."""
    pinned = _pinned(plane, passed, areas)
    if pinned is None or len(plane.names) ** 2 > MOST_MOVING:
        return None
    share = ROUND if attracting else NEAR
    box = {v: _around(passed.state[v], share * Q(plane.sizes[v])) for v in pinned.box}
    period = [Q(fixed.lap.time.midpoint) * (1 + sign * SLACK[attracting]) for sign in (-1, 1)]
    shown = _contraction(plane, fixed, pinned) if attracting else _newton(fixed)
    if shown is None:
        return None
    try:
        wanted = [("", box, 2, tuple(box))] + ([(" basin", pinned.box, 3, ())] if attracting else [])
        laps = [Recording(plane, pinned, by, degree).file(sides) for _, sides, degree, by in wanted]
    except Fault:
        return None
    if any(file is None for file in laps):
        return None
    files = {name + word: file for (word, *_), file in zip(wanted, laps, strict=True)}
    entry = {
        "section": [pinned.variable, rational_text(pinned.value)], "flow": name, **shown,
        "box": {v: [rational_text(q) for q in side] for v, side in box.items()},
        "period": [rational_text(q) for q in period], **({"basin": f"{name} basin"} if attracting else {}),
    }  # fmt: skip
    return Recorded(entry, files)


def _pinned(plane: Plane, passed: Passed, areas: Sequence[Part]) -> Pinned | None:
    """The plane that P names, in the only mode of an automaton without params; None where it names none."""
    simple = len(plane.model.modes) == 1 and not plane.model.automaton.edges
    if not simple or len(areas) != 1 or plane.model.names[:-1] != plane.names:
        return None
    sides = dict(zip(plane.names, areas[0].box, strict=True))
    flat = [v for v, (low, high) in sides.items() if low == high]
    if not isinstance(passed.section, Crossed) or len(flat) != 1:
        return None
    return Pinned(flat[0], sides[flat[0]][0], {v: s for v, s in sides.items() if v != flat[0]})


def _around(x: Interval, radius: Q) -> tuple[Q, Q]:
    middle = Q(x.midpoint)
    return middle - radius, middle + radius


def _newton(fixed: Fixed) -> dict[str, Json] | None:
    """Near the inverse of the derivative less one; of a section that has the plane's own coordinates or one only."""
    back = inverse([[Q(x.midpoint) - (i == j) for j, x in enumerate(row)] for i, row in enumerate(fixed.lap.slopes)])
    return None if back is None else {"back": [[rational_text(Q(float(q))) for q in row] for row in back]}


def _contraction(plane: Plane, fixed: Fixed, pinned: Pinned) -> dict[str, Json] | None:
    """Units in which a lap contracts, and by how much; None where it does not in those of the variables' sizes."""
    sizes = [Q(plane.sizes[v]) for v in pinned.box]
    slopes = fixed.lap.slopes
    norm = max(
        (sum(Q(abs(x).high) * d for x, d in zip(row, sizes, strict=True)) / own
         for row, own in zip(slopes, sizes, strict=True)), default=Q(0),
    )  # fmt: skip
    if norm >= 1:
        return None
    return {"factor": rational_text(Q(round((1 + norm) / 2 * 1000), 1000)), "sizes": [rational_text(d) for d in sizes]}


@holder
class Recording:
    """Laps from the plane that P names, with derivatives by some variables, as the kernel follows them."""

    plane: Plane
    pinned: Pinned
    by: tuple[str, ...]
    degree: int

    def __post_init__(self) -> None:
        plane, pinned = self.plane, self.pinned
        quantity = Expr("-", (Expr("var", (pinned.variable,)), number(pinned.value)))
        cut = opened(plane.model, Cut(plane.mode, plane.mode, quantity, Q(10**6), self.by))
        self.track = modelled(plane.model, replace(cut, modes=cut.modes[:1], edges=()))
        self.modes = listings(self.track, Judged((True,), {}, True, ((),), ((),)))

    def file(self, box: Sides) -> Json | None:
        """The record of laps from a box, cut into pieces; None where no lap of some piece is found."""
        leaves = list[Leaf]()
        tree = self._tree(box, DEEPEST, leaves)
        bits = precision([step for leaf in leaves for _, step in leaf], PRECISION)
        if tree is None or bits is None:
            return None
        varied = [v for v, (low, high) in box.items() if low < high]
        if any(m != leaves[0][0][0] for leaf in leaves for m, _ in leaf) or len(leaves[0][0][0][0]) != len(varied):
            return None
        return {
            "schema": "haverify.flow/1", "automaton": self.plane.model.automaton.name, "bits": bits, "order": ORDER,
            "set": [v for v in self.plane.names if v in varied], "monomials": leaves[0][0][0],
            "starts": [{"pieces": self._written(tree, bits)}],
        }  # fmt: skip

    def _tree(self, box: Sides, depth: int, leaves: list[Leaf]) -> Any:
        """A leaf, or a variable with the trees of its halves."""
        shares = {v: (high - low) / Q(self.plane.sizes[v]) for v, (low, high) in box.items()}
        widest = max(shares, key=lambda v: shares[v])
        leaf = self._lap(box) if shares[widest] <= SPREAD else None
        if leaf is not None:
            leaves.append(leaf)
            return leaf
        if depth == 0:
            return None
        low, high = box[widest]
        half = (low + high) / 2
        found = [self._tree({**box, widest: side}, depth - 1, leaves) for side in ((low, half), (half, high))]
        return None if None in found else (widest, *found)

    def _written(self, tree: Any, bits: int) -> Json:
        if isinstance(tree, tuple):
            split, low, high = tree
            return {"split": split, "low": self._written(low, bits), "high": self._written(high, bits)}
        count = len(self.track.automaton.vars)
        return {"steps": [step_json(max(1, round(ldexp(h, bits))), series[:count], bits) for _, (h, series) in tree]}

    def _lap(self, box: Sides) -> Leaf | None:
        """Steps of which the last one leads all runs across the plane, in the direction in which they left it."""
        period = self.plane.orbit.period
        one = {derived(v, c): Interval.at(int(v == c)) for v in self.by for c in self.by}
        given = {**{v: Interval.between(*s) for v, s in box.items()}, **one}
        given[self.pinned.variable] = Interval.between(self.pinned.value, self.pinned.value)
        sides = [given.get(n, Interval.at(0)) for n in self.track.names]
        settings = Settings(ORDER, self.degree, ERROR * max(1e-6, self.plane.size), min(0.02, period * LONGEST),
                            period * LONGEST, period * LEAST, STEPS, 4)  # fmt: skip
        start = 0, [(x.low, x.high) for x in sides], list[tuple[int, str]]()
        (row, *_) = recorded(grown(self.modes, start, BEYOND * period, "horizon", settings, Budget(1, 1, 0)))
        return self._cut(row, LATE * period)

    def _cut(self, row: RecordedStretch, late: float) -> Leaf | None:
        k, time, steps = self.track.names.index(self.pinned.variable), 0.0, row.steps
        if not steps or len(steps[0][1][1][k]) < 2 or not steps[0][1][1][k][1]:
            return None
        sign = 1 if steps[0][1][1][k][1][0] > 0 else -1
        for n, (_, (h, series)) in enumerate(steps):
            time += h
            before, after = (_reach(series[k], t, sign, float(self.pinned.value)) for t in (0.0, h))
            if time > late and before[1] < 0 < after[0]:
                return list(steps[: n + 1])
        return None


def _reach(series: list[list[float]], t: float, sign: int, value: float) -> tuple[float, float]:
    """Bounds of `sign` times how far a polynomial is from a value, at an instant, but for rounding."""
    terms = [sum(row[m] * t**i for i, row in enumerate(series) if m < len(row)) for m in range(max(map(len, series)))]
    middle, off = sign * (terms[0] - value), sum(map(abs, terms[1:]))
    return middle - off, middle + off
