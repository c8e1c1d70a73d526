"""States that runs through several modes come to, in floats: flows from starts, jumps from states next to guards."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import ceil, log2
from typing import Any

from haverify.analyses.synthesis.candidates import TALL
from haverify.analyses.synthesis.samples import Samples, branches, compiled, inside, moved, names_of, runs
from haverify.analyses.synthesis.system import Hybrid, Jump
from haverify.obligations.formula import Literal, variables

ROUNDS = 8
STARTS = 40
STEPS = 160
NEAR = 0.05  # how far a state may be from a guard that it is moved onto, relative to its size


def reached(hybrid: Hybrid) -> dict[str, Samples]:
    """For each mode samples whose states are those of runs through all modes."""
    import numpy

    names = _names(hybrid)
    random = numpy.random.default_rng(11)
    starts = {m: _starts(hybrid, m, names) for m in hybrid.systems}
    states = {m: [points] for m, points in starts.items()}
    fresh = dict(starts)
    for _ in range(ROUNDS):
        walked = {m: _walked(hybrid, m, names, points) for m, points in fresh.items()}
        fresh = {m: numpy.zeros((0, len(names))) for m in walked}
        for m, points in walked.items():
            states[m].append(points)
        for jump in hybrid.jumps:
            landed = _landed(jump, walked[jump.source], names, random)
            fresh[jump.target] = numpy.concatenate([fresh[jump.target], landed])
        for m, points in fresh.items():
            states[m].append(points)
            fresh[m] = points[random.permutation(len(points))[:STARTS]]
        if not any(len(points) for points in fresh.values()):
            break
    return {m: Samples(names, starts[m], numpy.concatenate(states[m]), [starts[m]]) for m in starts}


def _names(hybrid: Hybrid) -> tuple[str, ...]:
    found = dict.fromkeys(v for s in hybrid.systems.values() for v in names_of(s))
    landed = {v for j in hybrid.jumps for p in j.landing.values() for v in p.variables}
    landed |= {v for j in hybrid.jumps for e in j.known.entries for v in variables(e)}
    return (*found, *sorted(landed - set(found)))


def _starts(hybrid: Hybrid, mode: str, names: tuple[str, ...]) -> Any:
    import numpy

    groups = [inside(q, names, STARTS) for s in hybrid.systems[mode].starts for q in branches(s.entries)]
    return numpy.concatenate(groups) if groups else numpy.zeros((0, len(names)))


def _walked(hybrid: Hybrid, mode: str, names: tuple[str, ...], points: Any) -> Any:
    return runs(hybrid.systems[mode], names, points, STEPS) if len(points) else points


def _landed(jump: Jump, points: Any, names: Sequence[str], random: Any) -> Any:
    """Where states next to the guard come to."""
    import numpy

    if not len(points):
        return points
    points = points[random.permutation(len(points))[:2000]]
    found = []
    for literals in branches(jump.known.entries):
        own = [q for q in literals if isinstance(q, Literal)]
        put, is_good = moved(own, names, points)
        with numpy.errstate(all="ignore"):
            near = numpy.abs(put - points).max(axis=1) <= NEAR * (1 + numpy.abs(points).max(axis=1))
        found.append(put[near & is_good][:STARTS])
    before = numpy.concatenate(found) if found else points[:0]
    after = before.copy()
    for v, p in jump.landing.items():
        after[:, list(names).index(v)] = compiled(p, names).value(before)
    return after


def frame_of(samples: dict[str, Samples]) -> dict[str, tuple[Fraction, Fraction]]:
    """For each name a middle and a size of what its values are in all modes."""
    import numpy

    names = next(iter(samples.values())).names
    states = numpy.concatenate([s.states for s in samples.values()])
    states = states[numpy.abs(states).max(axis=1, initial=0) < TALL]
    found = {}
    for k, v in enumerate(names):
        low, high = (float(states[:, k].min()), float(states[:, k].max())) if len(states) else (0.0, 0.0)
        size = 2.0 ** ceil(log2(max((high - low) / 2, 2.0**-20)))
        found[v] = (Fraction(round((low + high) / 2 / size * 4), 4) * Fraction(size), Fraction(size))
    return found
