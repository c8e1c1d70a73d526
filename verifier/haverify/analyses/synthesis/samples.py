"""Points of starts and of runs from them, in floats: they choose what to try and decide nothing."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from haverify.analyses.synthesis.system import System
from haverify.maths.polynomial import Polynomial
from haverify.obligations.formula import HOLDS, Formula, Junction, Literal, variables
from haverify.solvers.positivity.refute import bounds_of
from haverify.text.record import holder

STARTS = 60
STEPS = 240
HUGE = 1e7
SLACK = 1e-7
ROUGH = 1e-3


@holder
class Compiled:
    """A polynomial as arrays: `value` takes points (n, d)."""

    exponents: Any
    coefficients: Any

    def value(self, points: Any) -> Any:
        """The values at the points."""
        import numpy

        with numpy.errstate(all="ignore"):
            total = numpy.zeros(len(points))
            for e, c in zip(self.exponents, self.coefficients, strict=True):
                term = numpy.full(len(points), c)
                for k, power in e:
                    term = term * points[:, k] ** power
                total = total + term
            return total


def compiled(poly: Polynomial, names: Sequence[str]) -> Compiled:
    """For points with the coordinates `names`."""
    place = {v: k for k, v in enumerate(names)}
    terms = [([(place[v], e) for v, e in m], float(c)) for m, c in poly.terms.items()]
    return Compiled([e for e, _ in terms], [c for _, c in terms])


def names_of(system: System) -> tuple[str, ...]:
    """All names, those of the field first."""
    found = {v for p in system.field.values() for v in p.variables}
    for e in (*system.common.entries, system.goal, *(e for s in system.starts for e in s.entries)):
        found |= variables(e)
    return (*system.field, *sorted(found - set(system.field)))


def holds(e: Formula, points: Any, names: Sequence[str], slack: float = 0.0) -> Any:
    """Which points satisfy the entry, up to a relative slack."""
    import numpy

    if isinstance(e, bool):
        return numpy.full(len(points), e)
    if isinstance(e, Junction):
        parts = [holds(m, points, names, slack) for m in e.members]
        return numpy.all(parts, axis=0) if e.is_and else numpy.any(parts, axis=0)
    value = compiled(e.polynomial, names).value(points)
    room = slack * max(abs(float(c)) for c in e.polynomial.terms.values()) if e.polynomial.whole else 0.0
    if e.op == "==":
        return abs(value) <= max(room, 1e-9)
    return value != 0 if e.op == "!=" else value <= room


def branches(entries: Sequence[Formula], most: int = 16) -> list[list[Literal]]:
    """The literals of each choice of members of the disjunctions that fixed names allow; the first ones only."""
    found: list[list[Literal]] = [[]]
    for e in sorted(entries, key=lambda e: isinstance(e, Junction)):
        choices = _choices(e, most)
        found = [both for f in found for c in choices if _fixed(both := [*f, *c]) is not None][:most]
    return found


def _fixed(literals: Sequence[Literal]) -> dict[str, Fraction] | None:
    """The values that equations give to names one after the other; None where they make a literal false."""
    values: dict[str, Fraction] = {}
    while True:
        left = [(q.op, q.polynomial.fix(values)) for q in literals]
        if any(p.constant is not None and not HOLDS[op](p.constant) for op, p in left):
            return None
        ends = [(p.variables[0], p.univariate()) for op, p in left if op == "==" and len(p.variables) == 1]
        more = {v: -c[0] / c[1] for v, c in ends if len(c) == 2}
        if not more:
            return values
        values |= more


def _choices(e: Formula, most: int) -> list[list[Literal]]:
    if isinstance(e, bool):
        return [[]] if e else []
    if isinstance(e, Literal):
        return [[e]]
    return branches(e.members, most) if e.is_and else [c for m in e.members for c in _choices(m, most)]


def inside(literals: Sequence[Literal], names: Sequence[str], count: int, seed: int = 1) -> Any:
    """Up to `count` points that satisfy the literals, (n, d): random ones, moved by Gauss-Newton steps."""
    import numpy

    random = numpy.random.default_rng(seed)
    low, high = _ranges(literals, names)
    points = low + (high - low) * random.random((4 * count, len(names)))
    points[0] = (low + high) / 2
    corners = points[1 : 1 + count // 2]
    corners[:] = numpy.where(random.random(corners.shape) < 0.5, low, high)  # what is extreme there is often so
    random.shuffle(points[1:])
    for v, value in (_fixed(literals) or {}).items():
        points[:, list(names).index(v)] = float(value)
    points, good = moved(literals, names, points)
    return points[good][:count]


def moved(literals: Sequence[Literal], names: Sequence[str], points: Any) -> tuple[Any, Any]:
    """The points moved by Gauss-Newton steps until the literals hold, and which of them came to that."""
    import numpy

    value = [compiled(q.polynomial, names) for q in literals]
    slopes = [[compiled(q.polynomial.derivative(v), names) for v in names] for q in literals]
    for _ in range(40):
        points, worst = _step(literals, value, slopes, points)
        if worst.max(initial=0) < 1e-12:
            break
    good = numpy.all(numpy.isfinite(points), axis=1)
    for q in literals:
        good &= holds(q, points, names, 1e-9)
    return points, good


def _step(
    literals: Sequence[Literal], value: Sequence[Any], slopes: Sequence[Sequence[Any]], points: Any
) -> tuple[Any, Any]:
    """The points after one step for each literal, and how far each was off; what overflows is no point any more."""
    import numpy

    worst = numpy.zeros(len(points))
    with numpy.errstate(all="ignore"):
        for q, f, g in zip(literals, value, slopes, strict=True):
            if not q.polynomial.variables or q.op == "!=":
                continue
            v = f.value(points)
            gradient = numpy.stack([s.value(points) for s in g], axis=1)
            square = (gradient**2).sum(axis=1) + 1e-12
            off = v if q.op == "==" else numpy.maximum(v + (1e-6 * numpy.sqrt(square) if q.op == "<" else 0), 0)
            points = points - (off / square)[:, None] * gradient
            worst = numpy.maximum(worst, abs(off))
    return points, worst


def _ranges(literals: Sequence[Literal], names: Sequence[str]) -> tuple[Any, Any]:
    import numpy

    low, high = numpy.full(len(names), numpy.nan), numpy.full(len(names), numpy.nan)
    for v, (least, most) in bounds_of(literals).items():
        k = names.index(v)
        low[k] = numpy.nan if least is None else float(least)
        high[k] = numpy.nan if most is None else float(most)
    for k in range(len(names)):
        if low[k] != low[k] and high[k] != high[k]:
            low[k], high[k] = -2.0, 2.0
        elif low[k] != low[k]:
            low[k] = high[k] - 2 - abs(high[k])
        elif high[k] != high[k]:
            high[k] = low[k] + 2 + abs(low[k])
    return low, high


@holder
class Samples:
    """Points of the starts, and of runs from them (n, d) in the domain; `names` are the coordinates."""

    names: tuple[str, ...]
    starts: Any
    states: Any
    branch_starts: list[Any]


def sample(system: System, count: int = STARTS, steps: int = STEPS) -> Samples:
    """Starts of each branch, and states on the runs from them."""
    import numpy

    names = names_of(system)
    groups = []
    for start in system.starts:
        for literals in branches(start.entries):
            points = inside(literals, names, count)
            if len(points):
                groups.append(points)
    starts = numpy.concatenate(groups) if groups else numpy.zeros((0, len(names)))
    return Samples(names, starts, runs(system, names, starts, steps), groups)


def runs(system: System, names: Sequence[str], starts: Any, steps: int) -> Any:
    """States along the runs while they are in the domain, by Runge-Kutta steps, of a length for each."""
    import numpy

    if not len(starts):
        return starts
    rates = [compiled(system.field[v], names) if v in system.field else None for v in names]

    def slope(points: Any) -> Any:
        return numpy.stack([numpy.zeros(len(points)) if r is None else r.value(points) for r in rates], axis=1)

    found = [starts]
    points = starts
    with numpy.errstate(all="ignore"):
        speed = numpy.abs(slope(points) / (1 + numpy.abs(points))).max(axis=1)
        step = numpy.clip(0.02 / numpy.maximum(speed, 1e-3), 1e-6, 0.1)[:, None]
    for _ in range(steps):
        with numpy.errstate(all="ignore"):
            a = slope(points)
            b = slope(points + step / 2 * a)
            c = slope(points + step / 2 * b)
            d = slope(points + step * c)
            room = 1 + numpy.abs(points)
            rough = (numpy.abs(c - b) * step / room).max(axis=1, keepdims=True)
            good = rough < ROUGH
            points = numpy.where(good, points + step / 6 * (a + 2 * b + 2 * c + d), points)
            step = numpy.where(good, numpy.minimum(step * numpy.where(rough < ROUGH / 8, 1.5, 1.0), 0.2), step / 3)
            keep = numpy.all(numpy.isfinite(points), axis=1) & (numpy.abs(points).max(axis=1, initial=0) < HUGE)
        points, step = points[keep], step[keep]
        for e in system.common.entries:
            inside_it = holds(e, points, names, SLACK)
            points, step = points[inside_it], step[inside_it]
        if not len(points):
            break
        found.append(points)
    return numpy.concatenate(found)
