"""What enclosures over the cycle decide: proved where every stretch keeps a limit, refuted where one breaks it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from haverify.maths.interval import Interval
from haverify.robot.body import Description
from haverify.robot.cycle import Cycle
from haverify.robot.enclosures import Stretch
from haverify.robot.mapping import Map
from haverify.text.record import record


@record
class Decided:
    """A check with what its least margin lies in (`low`, `high`), in `unit`, and where: `start` to `end` (s, replay).

    `verdict` is proved if the margin is never negative, refuted if it certainly is at some instant, else unknown.
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


def decided(d: Description, m: Map, cycle: Cycle, stretches: Sequence[Stretch]) -> list[Decided]:
    """Every check that enclosures decide."""
    pace, allowed = float(m.speed), Interval.at(m.penetration)
    starts = {p.mode: float(p.start) for p in cycle.pieces}
    (back, front), (right, left) = ([Interval.at(v) for v in pair] for pair in (d.sole.x, d.sole.y))
    edge, height = "to the sole's edge", "lowest corner"
    rows: list[tuple[str, str, str, Callable[[Stretch], Iterator[Interval]]]] = [
        ("swing sole above ground", height, "mm", lambda s: _soles(s, allowed)),
        ("ground pushes", "normal force", "N", lambda s: iter([_of(s, "force_z")])),
        ("friction", "force along the ground", "N^2", lambda s: iter([_of(s, "grip")])),
        ("zero moment point fore-aft", edge, "mm", lambda s: _edges(s, "front", "back")),
        ("zero moment point sideways", edge, "mm", lambda s: _edges(s, "left", "right")),
        ("centre of mass fore-aft", edge, "mm", lambda s: _over(s, "com_x", back, front)),
        ("centre of mass sideways", edge, "mm", lambda s: _over(s, "com_y", right, left)),
    ]
    found = []
    for name, what, unit, margins in rows:
        each = [(s, list(margins(s)) if s.values else []) for s in stretches]
        found.append(_judged(name, what, unit, each, starts, pace))
    return found


def _of(s: Stretch, name: str) -> Interval:
    assert s.values is not None, "asked for where there are values"
    return Interval(*s.values[name])


def _soles(s: Stretch, allowed: Interval) -> Iterator[Interval]:
    """The heights of the corners above what is allowed."""
    return ((_of(s, f"sole_{k}_z") + allowed) * 1000 for k in range(4))


def _edges(s: Stretch, one: str, other: str) -> Iterator[Interval]:
    """The distance of the zero moment point from two edges; of the moments' sign where the force may vanish."""
    force = _of(s, "force_z")
    for edge in (one, other):
        moment = _of(s, f"over_{edge}")
        yield moment / force * 1000 if force.low > 0 else Interval(min(moment.low, 0.0), max(moment.high, 0.0)) * 1e9


def _over(s: Stretch, name: str, low: Interval, high: Interval) -> Iterator[Interval]:
    where = _of(s, name)
    return iter([(where - low) * 1000, (high - where) * 1000])


def _judged(
    name: str,
    what: str,
    unit: str,
    margins: list[tuple[Stretch, list[Interval]]],
    starts: dict[str, float],
    pace: float,
) -> Decided:
    """The least margin over all stretches; a stretch without an enclosure leaves what is not refuted unknown."""
    known = [(s, min(x.low for x in xs), min(x.high for x in xs)) for s, xs in margins if xs]
    if not known:
        return Decided(name, what, "unknown", float("-inf"), float("inf"), unit, 0.0, 0.0, "")
    low, high = min(k[1] for k in known), min(k[2] for k in known)
    worst = min(known, key=lambda k: (k[2], k[1]))[0]
    verdict = "refuted" if high < 0 else "proved" if low >= 0 and len(known) == len(margins) else "unknown"
    start = starts[worst.mode]
    return Decided(
        name, what, verdict, low, high, unit, (start + worst.low) / pace, (start + worst.high) / pace, worst.mode
    )
