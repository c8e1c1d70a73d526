"""Attracting orbits: a box of the section on which the return map contracts, and all runs from P coming into it.

On a box W that the return map R takes into itself, a norm in which all derivatives are less than one makes all returns
tend to the only fixed point in W; runs that come into W then come as near to the orbit as one likes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import islice, product

from haverify.analyses.hybrid.conditions import members
from haverify.analyses.hybrid.model import HybridModel
from haverify.analyses.hybrid.starts import Box as Sides
from haverify.analyses.hybrid.starts import contracted, linear
from haverify.analyses.hybrid.starts import cut as pieces
from haverify.analyses.orbits.laps import Cut, Frame
from haverify.analyses.orbits.linear import ends, middle, square_norm
from haverify.analyses.orbits.linear import product as multiplied
from haverify.analyses.orbits.newton import Fixed
from haverify.analyses.orbits.orbit import Plane
from haverify.analyses.orbits.passing import Crossed, Section
from haverify.analyses.orbits.returns import Track, settings_of
from haverify.maths.interval import Interval
from haverify.model.expression import Expr, nodes
from haverify.model.hybrid import Assign
from haverify.obligations.residual import Situation, residual
from haverify.obligations.translate import OutsideFragmentError
from haverify.text.record import holder, record, replace

Q = Fraction
SHARES = (0.1, 0.03, 0.01, 3e-3, 1e-3, 3e-4, 1e-4, 1e-5)  # of the sizes of variables: boxes that may contract
ERROR, COARSE = 1e-12, 1e-9  # aimed at in a step
SAMPLES = 60  # of a lap
AGAIN = 3  # times at which they are tried
TRIES = 160  # flowpipes for this
STEPS = 600  # of one of them
LAPS = 12  # after which runs from P have to be near the orbit
HALVINGS = (0, 1, 2, 4, 6)  # of the states with P
CUTS = 1
LATE = (0.3, 0.05)  # of a lap before a run comes to the section
DEGREES = (2, 3)


@record
class Basin:
    """Coordinates of the section, the radius of a box of them that contracts to the orbit, by how much in a lap."""

    frame: Frame
    radius: float
    factor: float

    def holds(self, w: Mapping[str, Interval]) -> bool:
        """Whether coordinates are in the box."""
        return all(Interval(-self.radius, self.radius).encloses(w[v]) for v in self.frame.centre)


def basin(plane: Plane, fixed: Fixed) -> Basin | None:
    """A box around the fixed point that the return map takes into itself and contracts: the first of a few, by size."""
    frame = plane.frame(middle(fixed.lap.slopes), {v: x.midpoint for v, x in fixed.box.items()})
    if frame is None:
        return None
    track, here = plane.track(frame), _coordinates(frame, fixed.box)
    for radius, degree in product(SHARES, DEGREES):
        found = Basin(frame, radius, 1.0)
        box = dict.fromkeys(plane.columns, Interval(-radius, radius))
        lap = track.lap({**plane.given, **box}, settings_of(track.length, plane.size, degree, ERROR))
        if lap is None or not found.holds(here) or not found.holds(lap.state):
            continue
        factor = square_norm(*ends(lap.slopes))
        if factor < 1:
            return Basin(frame, radius, float(factor) ** 0.5)
    return None


def _coordinates(frame: Frame, state: Mapping[str, Interval]) -> dict[str, Interval]:
    apart = [[state[v] - c] for v, c in frame.centre.items()]
    found = multiplied([[Interval.at(q) for q in row] for row in frame.back], apart)
    return dict(zip(frame.centre, (row[0] for row in found), strict=True))


@record
class Part:
    """States with P in a mode: a box over the names of the state that holds them all."""

    mode: str
    box: Sides
    section: Section


def parts(model: HybridModel, claimed: Expr, sections: Sequence[Section]) -> list[Part]:
    """Boxes with all states that have P.

    Raises
    ------
    OutsideFragmentError    if P leaves a variable without a bound
    """
    found = []
    for s in sections:
        edge = None if isinstance(s, Crossed) else model.automaton.edges[s.edge]
        name = s.mode if isinstance(s, Crossed) else model.automaton.edges[s.edge].target
        at = Situation(name) if edge is None else Situation(name, edge.source, edge.name)
        mode = next(m for m in model.modes if m.name == name)
        told = [c for e in (residual(claimed, at), mode.domain) for c in members(e)]
        told += [e for a in edge.resets for e in _set(a)] if edge else []
        box = _bounded(model, [i for e in told for i in _inequalities(e)])
        if box is not None:
            found.append(Part(name, box, s))
    return found


def _bounded(model: HybridModel, told: Sequence[Expr]) -> Sides | None:
    """The box that linear inequalities leave; None where there is none."""
    sides = dict[str, tuple[Q | None, Q | None]]()
    for v in model.automaton.vars:
        sides[v.name] = model.values.interval(v.range) if v.range is not None else (None, None)
    declared = {p.name: p.range for p in (*model.spec.params, *model.automaton.params)}
    for p in model.names[len(model.automaton.vars) : -1]:
        sides[p] = model.values.interval(declared[p])
    for e in told:
        slopes, rest = linear(e, sides, model.values)
        if len(slopes) == 1:
            (name, a), (low, high) = *slopes.items(), sides[next(iter(slopes))]
            at = -rest / a
            sides[name] = (
                (at if low is None else max(low, at), high) if a > 0 else (low, at if high is None else min(high, at))
            )
    box = []
    for name, (low, high) in sides.items():
        if low is None or high is None:
            raise OutsideFragmentError(
                f"the section leaves `{name}` without a bound, and `attracting` is about all runs from it"
            )
        box.append((low, high))
    return contracted(tuple(box), list(sides), told, model.values) if all(a <= b for a, b in box) else None


def _set(a: Assign) -> list[Expr]:
    """What an assignment of a number says of the variable afterwards."""
    to = a.to
    if not isinstance(to, Expr) or any(n.op in ("var", "let", "input", "time") for n in nodes(to)):
        return []
    return [Expr("==", (Expr("var", (a.var,)), to))]


def _inequalities(e: Expr) -> list[Expr]:
    """An equation as two inequalities, a bounded magnitude as well; anything else as it is."""
    if e.op == "==":
        return [Expr("<=", e.children), Expr(">=", e.children)]
    if e.op in (">", ">="):
        return _inequalities(Expr("<" + e.op[1:], e.children[::-1]))
    if e.op in ("<", "<=") and e.children[0].op == "abs":
        (inner,), bound = e.children[0].children, e.children[1]
        return [Expr(e.op, (inner, bound)), Expr(e.op, (Expr("neg", (bound,)), inner))]
    return [e]


@holder
class Arrivals:
    """Runs from P that are followed into a basin; how many flowpipes may still be tried."""

    plane: Plane
    basin: Basin
    left: int = TRIES

    def come_in(self, part: Part) -> bool:
        """Whether all runs from a box certainly come into the basin."""
        return any(all(self._enters(part.mode, p) for p in pieces(part.box, n)) for n in HALVINGS if self.left > 0)

    def _enters(self, mode: str, piece: Sides) -> bool:
        plane, names = self.plane, self.plane.model.names[:-1]
        centre = {n: float((low + high) / 2) for n, (low, high) in zip(names, piece, strict=True)}
        start = {n: Interval.between(*ends) for n, ends in zip(names, piece, strict=True)}
        run = plane.guesses.run(mode, centre, LAPS * plane.orbit.period)
        crossings = plane.guesses.crossings(run, plane.mode, plane.quantity, SAMPLES * LAPS)
        points = ((t, {v: Interval.at(state[v]) for v in plane.columns}) for t, state in crossings)
        inside = (t for t, x in points if self.basin.holds(_coordinates(self.basin.frame, x)))
        return any(self._lands(mode, start, t, late) for t in islice(inside, AGAIN) for late in LATE)

    def _lands(self, mode: str, start: dict[str, Interval], t: float, late: float) -> bool:
        plane, self.left = self.plane, self.left - 1
        if self.left < 0:
            return False
        after = Q(max(t - late * plane.orbit.period, t / 2))
        cut = Cut(mode, plane.mode, plane.quantity, after, leaves=self.basin.frame)
        track = Track(plane.model, cut, t + 0.2 * plane.orbit.period, plane.size)
        settings = replace(settings_of(plane.orbit.period, plane.size, 3, COARSE), steps=STEPS)
        ends = track.ends(start, settings, CUTS)
        states = [dict(zip(track.names, [Interval(*x) for x in e.after], strict=True)) for e in ends or ()]
        return ends is not None and all(self.basin.holds(x) for x in states)
