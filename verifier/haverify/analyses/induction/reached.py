"""Whether runs come to a state, as far as runs in floats tell; they decide nothing."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from haverify.analyses.induction.counterexample import Leaving
from haverify.analyses.induction.refutation import names_of, starts
from haverify.analyses.induction.runs import Compiled, Vector, compiled, violated, walk
from haverify.obligations.formula import negation
from haverify.obligations.induction import Induction
from haverify.text.record import record

SPAN = 20.0
STEPS = 400


@record
class Nearest:
    """The point of a run from a start that is nearest to a state; the `runs` looked at, as points in `names`."""

    names: tuple[str, ...]
    point: Vector | None
    time: float
    runs: tuple[tuple[Vector, ...], ...]


def nearest(induction: Induction, found: Leaving) -> Nearest:
    """How near sampled runs come, without a jump, to a state of the mode they start in."""
    names = [*names_of(induction), "time"]
    target = [float(found.point.get(n, 0)) for n in names]
    best, where, when = float("inf"), None, 0.0
    runs: list[tuple[Vector, ...]] = []
    moving = [v.name for v in induction.automaton.vars if v.type == "real"]
    places = [names.index(v) for v in moving]
    for start in starts(induction):
        if start.mode != found.mode:
            continue
        points = _run(induction, start.mode, [start.point[n] for n in names], names)
        runs.append(tuple(p for _, p in points))
        for t, p in points:
            far = max((abs(p[k] - target[k]) / (1 + abs(target[k])) for k in places), default=0.0)
            if far < best:
                best, where, when = far, [p[k] for k in places], t
    return Nearest(tuple(moving), where, when, tuple(tuple([p[k] for k in places] for p in run) for run in runs))


def _run(induction: Induction, mode: str, start: Sequence[Fraction], names: list[str]) -> list[tuple[float, Vector]]:
    """A run inside of the domain of a mode."""
    outside = violated(negation(induction.premises(*induction.common(mode)).conjunction()), names, induction.functions)
    points: list[tuple[float, Vector]] = []
    try:
        for t, p in walk(rates(induction, mode, names), start, SPAN, STEPS):
            if outside(p):
                break
            points.append((t, list(p)))
    except OverflowError:
        pass
    return points


def rates(induction: Induction, mode: str, names: Sequence[str]) -> list[Compiled]:
    """The field of a mode in floats, 0 for what does not move."""
    fields = induction.field(mode)
    return [compiled(fields[n], names, induction.functions) if n in fields else lambda _: 0.0 for n in names]


def reached_text(induction: Induction, near: Nearest) -> str:
    """How far the state is from being reached, for people."""
    if near.point is None:
        return "spurious so far: no run of this mode alone was sampled"
    units = {v.name: f" {v.unit}" for v in induction.automaton.vars if v.unit is not None and str(v.unit) != "1"}
    said = ", ".join(f"{n} = {q:.4g}{units.get(n, '')}" for n, q in zip(near.names, near.point, strict=True))
    return f"spurious so far: of {len(near.runs)} sampled runs none comes nearer than {said}, after {near.time:.3g} s"
