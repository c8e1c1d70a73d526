"""Runs in floats: they say where to look for a violation and decide nothing."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction

from haverify.maths.polynomial import Polynomial
from haverify.obligations.formula import Formula, Literal
from haverify.obligations.functions import Functions

Vector = list[float]
Compiled = Callable[[Vector], float]
HUGE = 1e8
NEAR = 1e-7
FLOATS: dict[str, Callable[[float], float]] = {
    "sin": math.sin,
    "cos": math.cos,
    "exp": math.exp,
    "log": lambda x: math.log(x) if x > 0 else math.nan,
    "sqrt": lambda x: math.sqrt(x) if x >= 0 else math.nan,
    "inv": lambda x: 1 / x if x else math.nan,
}


def compiled(p: Polynomial, names: Sequence[str], functions: Functions) -> Compiled:
    """A polynomial in names and functions of them, in floats."""
    text = _text(p, {n: f"v[{k}]" for k, n in enumerate(names)}, functions)
    return eval(f"lambda v: {text}", dict(FLOATS))  # type: ignore[no-any-return]


def _text(p: Polynomial, places: Mapping[str, str], functions: Functions) -> str:
    terms = []
    for m, c in p.terms.items():
        powers = [f"{_named(n, places, functions)}**{e}" if e > 1 else _named(n, places, functions) for n, e in m]
        terms.append("*".join([repr(float(c)), *powers]))
    return "+".join(terms) or "0.0"


def _named(name: str, places: Mapping[str, str], functions: Functions) -> str:
    if name in functions.known:
        op, a = functions.known[name]
        return f"{op}({_text(a, places, functions)})"
    return places.get(name, repr(math.pi))


def violated(f: Formula, names: Sequence[str], functions: Functions) -> Callable[[Vector], bool]:
    """Whether a formula is plainly true at a point; equations never are."""
    if isinstance(f, bool):
        return lambda _: f
    if isinstance(f, Literal):
        value = compiled(f.polynomial, names, functions)
        room = NEAR * max(abs(float(c)) for c in f.polynomial.terms.values())
        return (lambda v: value(v) < -room) if f.op != "!=" else (lambda v: abs(value(v)) > room)
    found = [violated(m, names, functions) for m in f.members]
    return (lambda v: all(g(v) for g in found)) if f.is_and else (lambda v: any(g(v) for g in found))


def walk(
    rates: Sequence[Compiled], start: Sequence[Fraction], until: float, steps: int
) -> Iterator[tuple[float, Vector]]:
    """Instants and states along a run, by Runge-Kutta steps that follow its speed."""
    point, time = [float(q) for q in start], 0.0
    while time < until and steps > 0:
        steps -= 1
        yield time, point
        try:
            slope = [r(point) for r in rates]
            speed = max(abs(a) / (1 + abs(x)) for a, x in zip(slope, point, strict=True))
            step = min(until - time, until / 50, 0.02 / max(speed, 1e-6))
            point = _step(rates, point, slope, step)
        except (ArithmeticError, ValueError):
            return
        time += max(step, 1e-12)
        if not all(abs(x) < HUGE for x in point):
            return
    yield time, point


def _step(rates: Sequence[Compiled], point: Vector, first: Vector, h: float) -> Vector:
    def moved(slope: Vector, by: float) -> Vector:
        return [x + by * a for x, a in zip(point, slope, strict=True)]

    second = [r(moved(first, h / 2)) for r in rates]
    third = [r(moved(second, h / 2)) for r in rates]
    fourth = [r(moved(third, h)) for r in rates]
    whole = zip(point, first, second, third, fourth, strict=True)
    return [x + h / 6 * (a + 2 * b + 2 * c + d) for x, a, b, c, d in whole]
