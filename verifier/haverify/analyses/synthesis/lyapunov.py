"""Quadratic forms that decrease near equilibria: solutions of Lyapunov's equation, rounded. Guesses, all of them."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import Any

from haverify.analyses.synthesis.integrals import Field
from haverify.analyses.synthesis.samples import Samples, compiled
from haverify.maths.polynomial import Polynomial, constant, total, variable

NEWTON_STEPS = 30
LARGEST = 12


def forms(field: Field, names: tuple[str, ...], samples: Samples) -> Iterator[Polynomial]:
    """`(x - e)^T P (x - e)` for stable equilibria e near the sampled states, and P of one or two kinds."""
    import numpy

    if not 1 < len(names) <= LARGEST or not len(samples.states):
        return
    seen: list[Any] = []
    states = samples.states[numpy.abs(samples.states).max(axis=1) < 1e4]
    for state in states[:: max(1, len(states) // 8)]:
        point = _equilibrium(field, names, samples.names, state)
        if point is None or any(numpy.allclose(point, other, atol=1e-5) for other in seen):
            continue
        seen.append(point)
        yield from _around(field, names, samples.names, point)


def _equilibrium(field: Field, names: tuple[str, ...], all_names: tuple[str, ...], state: Any) -> Any:
    """A zero of the field near a state, names outside of `names` being kept."""
    import numpy

    places = [all_names.index(v) for v in names]
    rates = [compiled(field[v], all_names) for v in names]
    slopes = [[compiled(field[v].derivative(w), all_names) for w in names] for v in names]
    point = state.copy()
    for _ in range(NEWTON_STEPS):
        value = numpy.array([r.value(point[None])[0] for r in rates])
        matrix = numpy.array([[s.value(point[None])[0] for s in row] for row in slopes])
        step = numpy.linalg.lstsq(matrix, -value, rcond=None)[0]
        if not numpy.all(numpy.isfinite(step)):
            return None
        point[places] += numpy.clip(step, -1, 1)
        if numpy.abs(step).max() < 1e-10:
            return point if numpy.abs(value).max() < 1e-8 else None
    return None


def _around(field: Field, names: tuple[str, ...], all_names: tuple[str, ...], point: Any) -> Iterator[Polynomial]:
    import numpy
    from scipy.linalg import solve_continuous_lyapunov

    matrix = numpy.array(
        [[compiled(field[v].derivative(w), all_names).value(point[None])[0] for w in names] for v in names]
    )
    if numpy.linalg.eigvals(matrix).real.max() > -1e-6:
        return
    middle = [Fraction(float(point[all_names.index(v)])).limit_denominator(1000) for v in names]
    for weight in (numpy.eye(len(names)), numpy.diag(numpy.arange(1.0, len(names) + 1))):
        found = solve_continuous_lyapunov(matrix.T, -weight)
        found = found / numpy.abs(found).max()
        yield _form(names, middle, found)


def _form(names: tuple[str, ...], middle: list[Fraction], matrix: Any) -> Polynomial:
    shifted = [variable(v) - constant(m) for v, m in zip(names, middle, strict=True)]
    return total(
        (a * b).scaled(Fraction(round(float(matrix[i][j]) * 256), 256))
        for i, a in enumerate(shifted)
        for j, b in enumerate(shifted)
    )
