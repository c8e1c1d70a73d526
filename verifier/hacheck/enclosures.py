"""Functions of time and of an initial set, enclosed: polynomials with integer coefficients, and a bound of their error.

The time t of a step lies in [0, 1], each set variable in [-1, 1]. All numbers are integers in units of `2^-bits`; what is
cut off, or lost by rounding, is added to the radius.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from fractions import Fraction
from math import ceil, floor
from typing import NamedTuple

from hacheck.rational import Beyond, spend

Key = int  # exponents of the set variables, six bits each
Part = tuple[int, int]  # the power of t, the degree in the set variables
WIDTH, HIGHEST = 6, 40
MAX_BITS, MAX_SIZE = 400, 4000


class Model(NamedTuple):
    """A polynomial, its terms by `Part`, and at most how far the function is from it."""

    parts: dict[Part, dict[Key, int]]
    radius: int


ZERO = Model({}, 0)


def degree(key: Key) -> int:
    """The degree of a monomial in the set variables."""
    return sum(exponents(key))


def exponents(key: Key) -> Iterable[int]:
    """The exponents of the set variables, as far as there are any."""
    while key:
        yield key & 63
        key >>= WIDTH


def norm(a: Model) -> int:
    """A bound of the magnitude."""
    return sum(sum(map(abs, terms.values())) for terms in a.parts.values()) + a.radius


def bounds(a: Model) -> tuple[int, int]:
    """Bounds of the values: what has even powers only, or none but of t, has one sign."""
    low, high = -a.radius, a.radius
    for (power, _), terms in a.parts.items():
        for key, c in terms.items():
            if any(e & 1 for e in exponents(key)):
                low, high = low - abs(c), high + abs(c)
            else:
                low, high = low + (c if not power and not key else min(c, 0)), high + (c if not power and not key else max(c, 0))
    return low, high


def middle(a: Model) -> int:
    """The value of the polynomial at t = 0 in the middle of the set."""
    return a.parts.get((0, 0), {}).get(0, 0)


def add(a: Model, b: Model, sign: int = 1) -> Model:
    """`a + sign * b` for an integer sign."""
    parts = {part: dict(terms) for part, terms in a.parts.items()}
    for part, terms in b.parts.items():
        mine = parts.setdefault(part, {})
        for key, c in terms.items():
            mine[key] = mine.get(key, 0) + sign * c
    return Model(parts, a.radius + abs(sign) * b.radius)


def widened(a: Model, radius: int) -> Model:
    """The same polynomial with a larger error."""
    return Model(a.parts, a.radius + radius)


def lowered(a: Model, time: int, degree: int) -> Model:
    """What is of a higher power of t, or a higher degree, is moved to the radius."""
    kept, lost = {}, a.radius
    for part, terms in a.parts.items():
        if part[0] <= time and part[1] <= degree:
            kept[part] = terms
        else:
            lost += sum(map(abs, terms.values()))
    return Model(kept, lost)


def slope(a: Model) -> Model:
    """The derivative by t of the polynomial; the radius is left out."""
    return Model({(i - 1, d): {k: i * c for k, c in t.items()} for (i, d), t in a.parts.items() if i}, 0)


def at_end(a: Model) -> Model:
    """The polynomial at t = 1; the radius is left out."""
    out: dict[Part, dict[Key, int]] = {}
    for (_, d), terms in a.parts.items():
        mine = out.setdefault((0, d), {})
        for key, c in terms.items():
            mine[key] = mine.get(key, 0) + c
    return Model(out, 0)


class Space:
    """Models up to a power of t and a degree in the set variables."""

    def __init__(self, bits: int, time: int, degree: int) -> None:
        self.bits, self.one, self.time, self.degree = bits, 1 << bits, time, degree

    def number(self, low: Fraction, high: Fraction | None = None) -> Model:
        """A number, or all numbers between two."""
        least, most = floor(low * self.one), ceil((low if high is None else high) * self.one)
        return Model({(0, 0): {0: (least + most) >> 1}}, (most - least + 1) >> 1)

    def constant(self, value: int, radius: int = 0) -> Model:
        """A number in units."""
        return Model({(0, 0): {0: value}}, radius)

    def up(self, product: int) -> int:
        """A product of two bounds, rounded up."""
        return -(-product >> self.bits)

    def scaled(self, a: Model, by: int) -> Model:
        """`by * a`, `by` in units."""
        parts = {part: {k: c * by >> self.bits for k, c in terms.items()} for part, terms in a.parts.items()}
        return Model(parts, self.up(a.radius * abs(by)) + sum(map(len, parts.values())))

    def mul(self, a: Model, b: Model) -> Model:
        """The product."""
        bits, lost = self.bits, 0
        out: dict[Part, dict[Key, int]] = {}
        right = [(i, d, terms.items(), sum(map(abs, terms.values()))) for (i, d), terms in b.parts.items()]
        whole, most = sum(r[3] for r in right), 0
        for (i, d), terms in a.parts.items():
            size = sum(map(abs, terms.values()))
            most += size
            for j, e, others, own in right:
                if i + j > self.time or d + e > self.degree:
                    lost += size * own
                    continue
                spend(1 + (len(terms) * len(others) >> 3))
                mine = out.setdefault((i + j, d + e), {})
                for key, c in terms.items():
                    for other, f in others:
                        k = key + other
                        mine[k] = mine[k] + c * f if k in mine else c * f
        parts = {part: {k: c >> bits for k, c in terms.items()} for part, terms in out.items()}
        lost += most * b.radius + whole * a.radius + a.radius * b.radius
        return _bounded(Model(parts, self.up(lost) + sum(map(len, parts.values()))), bits)

    def sum(self, products: Iterable[tuple[Model, Model]]) -> Model:
        """The sum of products."""
        out = ZERO
        for a, b in products:
            if a is not ZERO and b is not ZERO:
                out = add(out, self.mul(a, b))
        return out

    def polynomial(self, coefficients: list[tuple[int, int]], a: Model, rest: int) -> Model:
        """`sum c_k a^k`, each c_k given with the bound of its error, and a bound of all that is left out."""
        power, radius = self.constant(self.one), rest
        out = self.constant(*coefficients[0])
        for c, error in coefficients[1:]:
            power = self.mul(power, a)
            out = add(out, self.scaled(power, c))
            radius += self.up(error * norm(power))
        return widened(out, radius)

    def replaced(self, a: Model, variable: int, by: Model) -> Model:
        """t (variable -1) or a set variable replaced by a model without it, or linear in it, in the same range."""
        powers: dict[int, Model] = {}
        for (i, _), terms in a.parts.items():
            for key, c in terms.items():
                e = i if variable < 0 else key >> WIDTH * variable & 63
                rest = key if variable < 0 else key - (e << WIDTH * variable)
                mine = powers.setdefault(e, Model({}, 0)).parts
                mine.setdefault((0 if variable < 0 else i, degree(rest)), {})[rest] = c
        out = ZERO
        for e in range(max(powers, default=0), -1, -1):
            out = add(self.mul(out, by), powers.get(e, ZERO))
        return widened(out, a.radius)


def _bounded(a: Model, bits: int) -> Model:
    if norm(a).bit_length() > bits + MAX_BITS:
        raise Beyond("numbers grow beyond what the checker allows")
    return a
