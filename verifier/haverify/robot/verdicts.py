"""What enclosures over the cycle decide: proved where every stretch keeps a limit, refuted where one breaks it.

A margin is `still + pace^2 * moving`, what weight leaves and what motion takes: linear in the square of the pace, so
its least value over a range of paces is at an end, and the paces at which it is never negative are an interval.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from math import isqrt

from haverify.maths.bernstein import Box
from haverify.maths.interval import Interval
from haverify.robot.body import Description
from haverify.robot.chain import loaded
from haverify.robot.collisions import nearest
from haverify.robot.cycle import Cycle
from haverify.robot.enclosures import GRAVITY, Stretch, enclosed_finely, tapes
from haverify.robot.mapping import Map
from haverify.text.record import record, replace

Q = Fraction
_BOXES = 16  # into which the params' values are split at most
_FINER = 0.01  # share of a range, where the first look leaves something undecided
_NOTHING = Interval(0.0, 0.0)


@record
class Margin:
    """What is left to a limit, `still + pace^2 * moving`, of `what`; `force` divides it where it is a moment."""

    what: str
    still: Interval
    moving: Interval = _NOTHING
    scale: int = 1
    force: tuple[Interval, Interval] | None = None

    def at(self, square: Interval) -> Interval:
        """Its value at the square of a pace."""
        value = self.still + square * self.moving
        if self.force is not None:
            force = self.force[0] + square * self.force[1]
            if force.low <= 0:  # there is no such point: the sign is what counts
                return Interval(min(value.low, 0.0), max(value.high, 0.0)) * 1e9
            value = value / force
        return value * self.scale


@record
class Decided:
    """A check with what its least margin lies in (`low`, `high`), in `unit`, and where: `start` to `end` (s, replay).

    `verdict` is proved if the margin is never negative, refuted if it certainly is at some instant, else unknown, for
    all values of the params together. `pace` is the one with the least margin, as a multiple of the replay's, and
    `holds` the least and greatest at which the check is proved; None: none. `boxes` are the values of other params
    for which it is proved.
    """

    name: str
    what: str
    verdict: str
    low: float
    high: float
    unit: str
    start: float
    end: float
    mode: str
    pace: Q
    holds: tuple[Q, Q] | None
    boxes: tuple[Box, ...]


def decided(d: Description, m: Map, cycle: Cycle) -> list[Decided]:
    """Every check that enclosures decide, for all values of the params."""
    pending, done = [cycle.box], list[list[Decided]]()
    while pending:
        box = pending.pop(0)
        made = tapes(d, m, cycle, box)
        found = judged(d, m, cycle, enclosed_finely(made))
        undecided = any(c.verdict == "unknown" for c in found)
        if undecided and not box:
            found = judged(d, m, cycle, enclosed_finely(made, _FINER))
        if box and undecided and len(pending) + len(done) + 2 <= _BOXES:
            pending += _halves(box)
        else:
            done.append(found)
    return [_together(each) for each in zip(*done, strict=True)]


def _halves(box: Box) -> list[Box]:
    name = max(box, key=lambda n: (box[n][1] - box[n][0]) / (abs(box[n][0]) + abs(box[n][1]) or 1))
    low, high = box[name]
    middle = (low + high) / 2
    return [{**box, name: (low, middle)}, {**box, name: (middle, high)}]


def _together(each: Sequence[Decided]) -> Decided:
    """One check over several boxes."""
    worst = min(each, key=lambda c: (c.high, c.low))
    words = {c.verdict for c in each}
    verdict = "refuted" if "refuted" in words else "unknown" if "unknown" in words else "proved"
    ranges = [c.holds for c in each]
    known = [r for r in ranges if r is not None]
    holds = None
    if len(known) == len(ranges):
        low, high = max(r[0] for r in known), min(r[1] for r in known)
        holds = (low, high) if low <= high else None
    boxes = tuple(b for c in each for b in c.boxes)
    return replace(worst, verdict=verdict, low=min(c.low for c in each), holds=holds, boxes=boxes)


def judged(d: Description, m: Map, cycle: Cycle, stretches: Sequence[Stretch]) -> list[Decided]:
    """Every check over stretches of one box, for all paces."""
    mass = d.robot.mass
    weight, friction = Interval.at(mass * GRAVITY), Interval.at(d.friction)
    height, edge = "lowest corner", "to the sole's edge"
    allowed = Interval.at(m.penetration)
    efforts = {j.name: Interval.at(j.limits.effort) for j in loaded(d, m) if j.limits is not None}
    rows: list[tuple[str, str, Callable[[Stretch], list[Margin]]]] = [
        ("swing sole above ground", "mm", lambda s: [_height(s, k, allowed, height) for k in range(4)]),
        ("ground pushes", "N", lambda s: [Margin("normal force", weight, _of(s, "push_z"))]),
        ("friction", "N", lambda s: [_grip(s, weight, friction)]),
        ("zero moment point fore-aft", "mm", lambda s: _edges(d, s, weight, "x", edge)),
        ("zero moment point sideways", "mm", lambda s: _edges(d, s, weight, "y", edge)),
        ("centre of mass fore-aft", "mm", lambda s: _over(d, s, "x", edge)),
        ("centre of mass sideways", "mm", lambda s: _over(d, s, "y", edge)),
        ("joint torques", "N m", lambda s: list(_torques(efforts, s))),
    ]
    found = []
    for name, unit, margins in rows:
        each = [(s, margins(s) if s.values else []) for s in stretches]
        found.append(_judged(name, unit, each, m, cycle))
    return [*found, _distance(d, m, cycle, stretches[0].box)]


def _distance(d: Description, m: Map, cycle: Cycle, box: Box) -> Decided:
    """How near bodies come that are no neighbours; it does not depend on the pace."""
    name, unit, found = "self-collision", "mm", nearest(d, m, cycle, box)
    if not found:
        what = "a shape is neither box nor ball" if found is None else "the robot has no shapes"
        return Decided(name, what, "unknown", *_UNBOUNDED, unit, 0.0, 0.0, "", Q(1), None, ())
    worst = min(found, key=lambda n: n.low)
    high = min(n.high for n in found)
    is_proved = worst.low >= 0 and all(n.is_sure for n in found)
    verdict = "refuted" if high < 0 else "proved" if is_proved else "unknown"
    start = float(next(p.start for p in cycle.pieces if p.mode == worst.mode))
    at = [(start + end) / float(m.speed) for end in (worst.start, worst.end)]
    holds = (cycle.slowest, cycle.fastest) if is_proved else None
    boxes = (box,) if box and is_proved else ()
    ends = (worst.low * 1000, high * 1000)
    return Decided(name, " and ".join(worst.pair), verdict, *ends, unit, at[0], at[1], worst.mode, Q(1), holds, boxes)


def _of(s: Stretch, name: str) -> Interval:
    assert s.values is not None, "asked for where there are values"
    return Interval(*s.values[name])


def _height(s: Stretch, corner: int, allowed: Interval, what: str) -> Margin:
    """The height of a corner above what is allowed."""
    return Margin(what, _of(s, f"sole_{corner}_z") + allowed, scale=1000)


def _grip(s: Stretch, weight: Interval, friction: Interval) -> Margin:
    """What friction can hold beyond the force along the ground, which grows with the square of the pace."""
    x, y = _of(s, "push_x"), _of(s, "push_y")
    along = (x.sqr() + y.sqr()).sqrt()
    return Margin("force along the ground", friction * weight, friction * _of(s, "push_z") - along)


def _ends(d: Description, axis: str) -> tuple[tuple[str, Interval], tuple[str, Interval]]:
    (back, front), (right, left) = ([Interval.at(v) for v in pair] for pair in (d.sole.x, d.sole.y))
    return (("front", front), ("back", back)) if axis == "x" else (("left", left), ("right", right))


def _edges(d: Description, s: Stretch, weight: Interval, axis: str, what: str) -> list[Margin]:
    """The distance of the zero moment point from two edges, as moments about them over the force."""
    (far, end), (near, start) = _ends(d, axis)
    com, force = _of(s, f"com_{axis}"), (weight, _of(s, "push_z"))
    return [
        Margin(what, weight * (end - com), _of(s, f"tip_{far}"), 1000, force),
        Margin(what, weight * (com - start), _of(s, f"tip_{near}"), 1000, force),
    ]


def _over(d: Description, s: Stretch, axis: str, what: str) -> list[Margin]:
    (_, end), (_, start) = _ends(d, axis)
    com = _of(s, f"com_{axis}")
    return [Margin(what, end - com, scale=1000), Margin(what, com - start, scale=1000)]


def _torques(efforts: Mapping[str, Interval], s: Stretch) -> Iterator[Margin]:
    for name, most in efforts.items():
        hold, move = _of(s, f"hold_{name}"), _of(s, f"move_{name}")
        yield Margin(name, most - hold, -move)
        yield Margin(name, most + hold, move)


def _judged(name: str, unit: str, margins: list[tuple[Stretch, list[Margin]]], m: Map, cycle: Cycle) -> Decided:
    """The least margin over all stretches and paces; where a stretch has no enclosure, nothing is proved."""
    ends = list(dict.fromkeys((cycle.slowest, cycle.fastest)))
    paces = list(dict.fromkeys((Q(1), *ends)))  # a force may vanish on the way to an end
    squares = {p: Interval.at((m.speed * p) ** 2) for p in paces}
    known = [(s, x, p, x.at(squares[p])) for s, xs in margins for x in xs for p in (paces if x.force else ends)]
    if not known:
        return Decided(name, "", "unknown", *_UNBOUNDED, unit, 0.0, 0.0, "", Q(1), None, ())
    low, high = min(k[3].low for k in known), min(k[3].high for k in known)
    stretch, margin, pace, _ = min(known, key=lambda k: (k[3].high, k[3].low))
    is_whole = all(xs for _, xs in margins)
    verdict = "refuted" if high < 0 else "proved" if low >= 0 and is_whole else "unknown"
    holds = _paces([x for _, xs in margins for x in xs], m, cycle) if is_whole else None
    start = next(p.start for p in cycle.pieces if p.mode == stretch.mode)
    at = [(float(start) + end) / float(m.speed) for end in (stretch.low, stretch.high)]
    boxes = (stretch.box,) if stretch.box and verdict == "proved" else ()
    return Decided(name, margin.what, verdict, low, high, unit, at[0], at[1], stretch.mode, pace, holds, boxes)


_UNBOUNDED = (float("-inf"), float("inf"))


def _paces(margins: Sequence[Margin], m: Map, cycle: Cycle) -> tuple[Q, Q] | None:
    """The paces, as multiples of the replay's, at which no margin is negative, rounded inwards to four decimals."""
    least, most = cycle.slowest**2, cycle.fastest**2
    for x in margins:
        still, moving = Q(x.still.low), Q(x.moving.low) * m.speed**2
        if moving < 0:
            most = min(most, still / -moving)
        elif still < 0:
            if not moving:
                return None
            least = max(least, still / -moving)
    if most < least:
        return None
    low = cycle.slowest if least == cycle.slowest**2 else _root(least, up=True)
    high = cycle.fastest if most == cycle.fastest**2 else _root(most, up=False)
    return (low, high) if low <= high else None


def _root(square: Q, up: bool) -> Q:
    """The square root of a number that is not negative, to four decimals, rounded up or down."""
    scaled = square * 10**8
    root = isqrt(scaled.numerator // scaled.denominator)
    return Q(root + 1 if up else root, 10**4)
