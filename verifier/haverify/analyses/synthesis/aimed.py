"""Starts whose sampled runs violate a goal: what the starts leave free is moved towards the best of them.

Cross-entropy: normal distributions are fitted again and again to the runs that came nearest. Floats decide nothing.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from typing import Any

from haverify.analyses.synthesis.samples import branches, compiled, inside, moved, names_of, runs
from haverify.analyses.synthesis.system import System
from haverify.obligations.formula import Literal, negation

ROUNDS, MANY, BEST, STEPS = 30, 80, 12, 320
WIDE = (100.0, 10.0, 1.0)
KEPT = 0.3  # of the spread before
PATIENCE, SLOW = 4, 0.98  # rounds in which it has to become that much less
AFTER = 4  # rounds after the first violation, which make it plainer


def aimed(system: System) -> Iterator[tuple[dict[str, float], float]]:
    """Starts, and instants at which the goal fails on their runs."""
    import numpy

    names = names_of(system)
    for start in (b for s in system.starts for b in branches(s.entries)):
        some = inside(start, names, MANY)
        for wrong, points, factor in product(branches([negation(system.goal)]), _alike(start, names, some), WIDE):
            noise = numpy.random.default_rng(1).standard_normal((MANY, len(names)))
            moved_on, good = moved(start, names, points.mean(axis=0) + points.std(axis=0) * factor * noise)
            found = _followed(system, names, start, wrong, moved_on[good])
            if found is not None:
                yield found
                break


def _alike(start: Sequence[Literal], names: Sequence[str], points: Any) -> list[Any]:
    """The points by the signs of the names that equations of higher degree tell."""
    read = {v for q in start if q.op == "==" and q.polynomial.total_degree() > 1 for v in q.polynomial.variables}
    places = [k for k, v in enumerate(names) if v in read]
    groups: dict[tuple[bool, ...], list[Any]] = {}
    for p in points:
        groups.setdefault(tuple(bool(p[k] > 0) for k in places), []).append(p)
    import numpy

    return [numpy.array(g) for g in groups.values() if len(g) > 1]


def _followed(
    system: System, names: Sequence[str], start: Sequence[Literal], wrong: Sequence[Literal], points: Any
) -> tuple[dict[str, float], float] | None:
    """The best start after some rounds, if the goal fails plainly on its run."""
    import numpy

    random = numpy.random.default_rng(2)
    spread = points.std(axis=0)
    best, below, trail = None, 0, list[float]()
    for _ in range(ROUNDS):
        if not len(points):
            return None
        depths, times = _nearest(system, names, wrong, points)
        order = numpy.argsort(depths)
        if best is None or depths[order[0]] < best[0]:
            best = depths[order[0]], points[order[0]], times[order[0]]
        if best[0] < 0:
            below += 1
        trail.append(best[0])
        if below > AFTER or (len(trail) > PATIENCE and trail[-1] > SLOW * trail[-1 - PATIENCE] > 0):
            break
        elite = points[order[:BEST]]
        spread = numpy.maximum(elite.std(axis=0), KEPT * spread)
        fresh = elite.mean(axis=0) + spread * random.standard_normal((MANY, len(names)))
        points, good = moved(start, names, numpy.vstack([best[1][None], elite[:2], fresh]))
        points = points[good]
    if best is None or not best[0] < 0:
        return None
    return dict(zip(names, map(float, best[1]), strict=True)), float(best[2])


def _nearest(system: System, names: Sequence[str], wrong: Sequence[Literal], points: Any) -> tuple[Any, Any]:
    """For each start, the least value over its run of what is below 0 where the goal fails, and when."""
    import numpy

    marked = numpy.hstack([points, numpy.arange(len(points), dtype=float)[:, None]])
    states = runs(system, (*names, "@start"), marked, STEPS)
    values = [compiled(q.polynomial, names).value(states[:, :-1]) for q in wrong if q.op != "!="]
    depth = numpy.max(values, axis=0) if values else numpy.full(len(states), -1.0)
    owner = states[:, -1].astype(int)
    order = numpy.lexsort((depth, owner))
    first = order[numpy.searchsorted(owner[order], numpy.arange(len(points)))]
    return depth[first], states[first, list(names).index("time")]
