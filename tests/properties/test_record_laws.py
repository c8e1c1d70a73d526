"""Laws of recorded flows: operations enclose, and sampled runs are where hacheck finds them from the record."""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.unit.hacheck.flowing import Flowing

from hacheck import elementary
from hacheck.core import Core
from hacheck.enclosures import Model, Space, bounds, exponents, key, norm
from hacheck.rational import Beyond
from hacheck.records import Record
from hacheck.scope import Scope

Json = Any
SPACE = Space(60, 4, 3)
Field = Callable[[float, float], tuple[float, float]]


def value(m: Model, t: float, z: list[float], one: int) -> float:
    """The polynomial at a point."""
    return sum(
        c / one * t**i * math.prod(x**e for x, e in zip(z, exponents(k), strict=False))
        for i, terms in m.parts.items()
        for k, c in terms.items()
    )


COEFFICIENT = st.integers(-(1 << 55), 1 << 55)


@st.composite
def models(draw: st.DrawFn) -> Model:
    """Polynomials of t and two set variables around a number between 1 and 3, with an error."""
    parts: dict[int, dict[int, int]] = {}
    for i in range(3):
        for e in ((0, 0), (1, 0), (0, 1), (1, 1)):
            parts.setdefault(i, {})[key(e)] = draw(COEFFICIENT)
    parts[0][0] = draw(st.integers(1 << 60, 3 << 60))
    return Model(parts, draw(st.integers(0, 1 << 40)))


OPERATIONS: list[tuple[Callable[[Model, Model], Model], Callable[[float, float], float]]] = [
    (SPACE.mul, lambda a, b: a * b),
    (lambda a, _: elementary.inverse(SPACE, a), lambda a, _: 1 / a),
    (lambda a, _: elementary.root(SPACE, a), lambda a, _: math.sqrt(a)),
    (lambda a, _: elementary.exponential(SPACE, a), lambda a, _: math.exp(a)),
    (lambda a, _: elementary.log(SPACE, a), lambda a, _: math.log(a)),
    (lambda a, _: elementary.waves(SPACE, a)[0], lambda a, _: math.sin(a)),
    (lambda a, _: elementary.waves(SPACE, a)[1], lambda a, _: math.cos(a)),
    (lambda a, _: SPACE.replaced(a, -1, Model({0: {0: 1 << 58}, 1: {0: 1 << 59}}, 0)), lambda a, _: a),
]
UNIT = st.floats(-1, 1)


@given(models(), models(), st.integers(0, len(OPERATIONS) - 1), st.floats(0, 1), UNIT, UNIT, UNIT, UNIT)
def test_operations_enclose(
    a: Model, b: Model, which: int, t: float, z: float, y: float, off: float, away: float
) -> None:
    operation, exact = OPERATIONS[which]
    try:
        found = operation(a, b)
    except Beyond:
        return
    before = 0.25 + t / 2 if which == len(OPERATIONS) - 1 else t
    at = [value(m, before, [z, y], SPACE.one) + s * m.radius / SPACE.one for m, s in ((a, off), (b, away))]
    wanted = exact(*at)
    assert abs(wanted - value(found, t, [z, y], SPACE.one)) <= found.radius / SPACE.one + 1e-12 * (1 + abs(wanted))
    low, high = bounds(found)
    slack = 1e-12 * (1 + abs(wanted))
    assert low / SPACE.one - slack <= wanted <= high / SPACE.one + slack
    assert max(-low, high) <= norm(found)


EXPONENTS = st.tuples(st.integers(0, 3), st.integers(0, 3))
BENT = st.dictionaries(st.integers(0, 3), st.dictionaries(EXPONENTS.map(key), COEFFICIENT, max_size=4), max_size=4)
SHARES = st.fractions(-1, 1, max_denominator=1 << 20)


def exactly(m: Model, t: Fraction, z: list[Fraction]) -> Fraction:
    """The polynomial at a point, in units."""
    terms = ((i, exponents(k), c) for i, terms in m.parts.items() for k, c in terms.items())
    return sum((c * t**i * math.prod(x**e for x, e in zip(z, es, strict=False)) for i, es, c in terms), Fraction(0))


@given(BENT, st.integers(-1, 1), st.integers(0, 1 << 60), st.integers(-(1 << 60), 1 << 60), st.tuples(*[SHARES] * 3))
def test_a_part_of_the_range_encloses(
    parts: dict[int, dict[int, int]], variable: int, a: int, b: int, at: tuple[Fraction, Fraction, Fraction]
) -> None:
    """What is moved into a part of the range of t or of a set variable is what it was there, up to its error."""
    start, by = (a, (b + SPACE.one) * (SPACE.one - a) >> 61) if variable < 0 else ((a + b) >> 1, (a - b) >> 1)
    before = Model(parts, 5)
    after = SPACE.moved(before, variable, start, by)
    t, *z = abs(at[0]), at[1], at[2]
    there = [t, *z]
    there[variable + 1] = Fraction(start, SPACE.one) + Fraction(by, SPACE.one) * there[variable + 1]
    assert abs(exactly(after, t, z) - exactly(before, there[0], there[1:])) <= after.radius - before.radius


VAN_DER_POL = """automaton A {
  var x
  var y
  init Run where 1.3 <= x <= 1.5 and 2.35 <= y <= 2.45
  mode Run { flow { x' = y; y' = (1 - x^2) * y - x } }
}
property p on A { within 2; always y <= 3 }"""
PENDULUM = """automaton A {
  var x
  var y
  init Run where 0.9 <= x <= 1 and 0 <= y <= 0.1
  mode Run { flow { x' = y / (1 + x^2 / 100); y' = -sin(x) - y * exp(-x) / 10 } }
}
property p on A { within 1.5; always x <= 2 }"""
FIELDS: list[tuple[str, Field]] = [
    (VAN_DER_POL, lambda x, y: (y, (1 - x * x) * y - x)),
    (PENDULUM, lambda x, y: (y / (1 + x * x / 100), -math.sin(x) - y * math.exp(-x) / 10)),
]


def along(field: Field, x: tuple[float, float], h: float, steps: int) -> tuple[float, float]:
    """The solution after some time, by a method of order four with an error far below what is tested."""
    d = h / steps
    for _ in range(steps):
        a = field(*x)
        b = field(x[0] + d / 2 * a[0], x[1] + d / 2 * a[1])
        c = field(x[0] + d / 2 * b[0], x[1] + d / 2 * b[1])
        e = field(x[0] + d * c[0], x[1] + d * c[1])
        x = (x[0] + d / 6 * (a[0] + 2 * b[0] + 2 * c[0] + e[0]), x[1] + d / 6 * (a[1] + 2 * b[1] + 2 * c[1] + e[1]))
    return x


def outside(made: Flowing, field: Field, count: int) -> int:
    """How many sampled runs are not, at some step, where polynomials and errors say."""
    core = Core(made.core)
    scope = Scope(core, next(iter(core.automata.values())), False)
    record = Record(scope, made.record)
    box = {v: (Fraction(a), Fraction(b)) for v, (a, b) in made.record["starts"][0]["box"].items()}
    here, one, missed = record.start("Run", box), record.space.one, set()
    numbers = random.Random(1)
    zs = [[numbers.uniform(-1, 1), numbers.uniform(-1, 1)] for _ in range(count)]
    sides = [(float(a + b) / 2, float(b - a) / 2) for a, b in (box["x"], box["y"])]
    runs = [(sides[0][0] + sides[0][1] * z[0], sides[1][0] + sides[1][1] * z[1]) for z in zs]
    for stay in (stay for step in made.steps for stay in record.steps(here, {}, step)):
        states, h, here = stay.states, stay.h, stay.after
        for n, z in enumerate(zs):
            half = along(field, runs[n], norm(h) / one / 2, 40)
            runs[n] = along(field, half, norm(h) / one / 2, 40)
            for t, x in ((0.5, half), (1.0, runs[n])):
                near = [abs(x[i] - value(states[v], t, z, one)) for i, v in enumerate("xy")]
                allowed = [states[v].radius / one + 1e-8 for v in "xy"]
                if any(a > b for a, b in zip(near, allowed, strict=True)):
                    missed.add(n)
    return len(missed)


@pytest.mark.parametrize(("text", "field"), FIELDS)
def test_sampled_runs_are_inside(tmp_path: Path, text: str, field: Field) -> None:
    assert outside(Flowing(tmp_path, text), field, 10) == 0


@pytest.mark.parametrize(("text", "field"), FIELDS)
def test_runs_of_another_field_are_not(tmp_path: Path, text: str, field: Field) -> None:
    """The test above can fail."""
    assert outside(Flowing(tmp_path, text), lambda x, y: (field(x, y)[0] + 1e-2, field(x, y)[1]), 5) > 0
