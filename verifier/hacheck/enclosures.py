"""Functions of time and of an initial set, enclosed: polynomials with integer coefficients, and a bound of their error.

The time t of a step lies in [0, 1], each set variable in [-1, 1]. All numbers are integers in units of `2^-bits`; what
is cut off, or lost by rounding, is added to the radius.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from math import ceil, comb, floor
from typing import NamedTuple

from hacheck.rational import Beyond, spend

Key = int  # the degree of a monomial in the set variables, then their exponents, six bits each
Terms = dict[Key, int]
WIDTH, HIGHEST, MOST_VARIABLES = 6, 40, 100
ODD = sum(1 << WIDTH * (i + 1) for i in range(MOST_VARIABLES))  # the last bit of each exponent
MAX_BITS, TINY = 400, 10


class Model(NamedTuple):
    """A polynomial, its terms by the power of t, and at most how far the function is from it."""

    parts: dict[int, Terms]
    radius: int


ZERO = Model({}, 0)


def key(exponents: Iterable[int]) -> Key:
    """The monomial with these exponents of the set variables."""
    given = list(exponents)
    if len(given) > MOST_VARIABLES:
        raise Beyond("a set has many variables")
    return sum(e * ((1 << WIDTH * (i + 1)) + 1) for i, e in enumerate(given))


def degree(key: Key) -> int:
    """The degree of a monomial in the set variables."""
    return key & 63


def exponents(key: Key) -> Iterator[int]:
    """The exponents of the set variables, as far as there are any."""
    while key := key >> WIDTH:
        yield key & 63


def size(terms: Terms) -> int:
    """The sum of the magnitudes."""
    return sum(map(abs, terms.values()))


def norm(a: Model) -> int:
    """A bound of the magnitude."""
    return sum(map(size, a.parts.values())) + a.radius


def bounds(a: Model) -> tuple[int, int]:
    """Bounds of the values: what has even powers only, or none but of t, has one sign."""
    low, high = -a.radius, a.radius
    for power, terms in a.parts.items():
        for k, c in terms.items():
            if k & ODD:
                low -= abs(c)
                high += abs(c)
            elif not power and not k:
                low += c
                high += c
            elif c < 0:
                low += c
            else:
                high += c
    return low, high


def middle(a: Model) -> int:
    """The value of the polynomial at t = 0 in the middle of the set."""
    return a.parts.get(0, {}).get(0, 0)


def add(a: Model, b: Model, sign: int = 1) -> Model:
    """`a + sign * b` for an integer sign."""
    parts = {power: dict(terms) for power, terms in a.parts.items()}
    for power, terms in b.parts.items():
        mine = parts.setdefault(power, {})
        for k, c in terms.items():
            mine[k] = mine.get(k, 0) + sign * c
    return Model(parts, a.radius + abs(sign) * b.radius)


def widened(a: Model, radius: int) -> Model:
    """The same polynomial with a larger error."""
    return Model(a.parts, a.radius + radius)


def lowered(a: Model, time: int, most: int) -> Model:
    """What is of a higher power of t, or a higher degree, is moved to the radius."""
    kept = {i: {k: c for k, c in t.items() if degree(k) <= most} for i, t in a.parts.items() if i <= time}
    return Model(kept, norm(a) - norm(Model(kept, 0)))


def slope(a: Model) -> Model:
    """The derivative by t of the polynomial; the radius is left out."""
    return Model({i - 1: {k: i * c for k, c in t.items()} for i, t in a.parts.items() if i}, 0)


def at_end(a: Model) -> Model:
    """The polynomial at t = 1; the radius is left out."""
    out: Terms = defaultdict(int)
    for terms in a.parts.values():
        for k, c in terms.items():
            out[k] += c
    return Model({0: dict(out)}, 0)


class Space:
    """Models up to a power of t and a degree in the set variables."""

    def __init__(self, bits: int, time: int, degree: int) -> None:
        self.bits, self.one, self.time, self.degree = bits, 1 << bits, time, degree

    def number(self, low: Fraction, high: Fraction | None = None) -> Model:
        """A number, or all numbers between two."""
        least, most = floor(low * self.one), ceil((low if high is None else high) * self.one)
        return Model({0: {0: (least + most) >> 1}}, (most - least + 1) >> 1)

    def constant(self, value: int, radius: int = 0) -> Model:
        """A number in units."""
        return Model({0: {0: value}}, radius)

    def up(self, product: int) -> int:
        """A product of two bounds, rounded up."""
        return -(-product >> self.bits)

    def scaled(self, a: Model, by: int) -> Model:
        """`by * a`, `by` in units."""
        parts = {i: {k: c * by >> self.bits for k, c in terms.items()} for i, terms in a.parts.items()}
        return Model(parts, self.up(a.radius * abs(by)) + sum(map(len, parts.values())))

    def mul(self, a: Model, b: Model) -> Model:
        """The product."""
        for x, y in ((a, b), (b, a)):
            if not x.radius and x.parts.keys() <= {0} and x.parts.get(0, {}).keys() <= {0}:
                return self.scaled(y, middle(x))
        out: dict[int, Terms] = defaultdict(lambda: defaultdict(int))
        right = [(j, *self._by_degree(terms), size(terms)) for j, terms in b.parts.items()]
        lost = norm(a) * b.radius + sum(r[3] for r in right) * a.radius
        for i, terms in a.parts.items():
            own = size(terms)
            for j, upto, beyond, whole in right:
                if i + j > self.time:
                    lost += own * whole
                    continue
                spend(3 + (len(terms) * len(upto[-1]) >> 1))
                mine = out[i + j]
                for k, c in terms.items():
                    left = self.degree - (k & 63)
                    lost += abs(c) * (beyond[left] if left >= 0 else whole)
                    for other, d in upto[left] if left >= 0 else ():
                        mine[k + other] += c * d
        return self._rounded(out, lost)

    def _by_degree(self, terms: Terms) -> tuple[list[list[tuple[Key, int]]], list[int]]:
        """For each degree the terms up to it, and the size of those beyond."""
        upto: list[list[tuple[Key, int]]] = [[] for _ in range(self.degree + 1)]
        own, beyond = [0] * (self.degree + 1), size(terms)
        for term in terms.items():
            if term[0] & 63 <= self.degree:
                upto[term[0] & 63].append(term)
                own[term[0] & 63] += abs(term[1])
        rest = []
        for d in range(self.degree + 1):
            upto[d] = upto[d - 1] + upto[d] if d else upto[d]
            beyond -= own[d]
            rest.append(beyond)
        return upto, rest

    def _rounded(self, products: dict[int, Terms], lost: int) -> Model:
        """Products in units again; tiny terms are moved to the radius."""
        bits, parts, radius = self.bits, {}, self.up(lost)
        if radius.bit_length() > bits + MAX_BITS:
            raise Beyond("numbers grow beyond what the checker allows")
        for i, terms in products.items():
            kept = {}
            for k, c in terms.items():
                c >>= bits
                if c >> TINY in (0, -1):
                    radius += abs(c)
                else:
                    kept[k] = c
            radius += len(terms)
            parts[i] = kept
        return Model(parts, radius)

    def sum(self, products: Iterable[tuple[Model, Model]]) -> Model:
        """The sum of products."""
        out = ZERO
        for a, b in products:
            if a is not ZERO and b is not ZERO:
                out = add(out, self.mul(a, b))
        return out

    def polynomials(self, rows: Sequence[Sequence[tuple[int, int]]], a: Model, rest: int) -> list[Model]:
        """`sum c_k a^k` for each row of c_k, given with bounds of their errors; `rest` bounds all that is left out."""
        power, found = self.constant(self.one), [widened(self.constant(*row[0]), rest) for row in rows]
        for k in range(1, len(rows[0])):
            power = self.mul(power, a)
            whole = norm(power)
            for n, row in enumerate(rows):
                c, error = row[k]
                found[n] = widened(add(found[n], self.scaled(power, c)), self.up(error * whole))
        return found

    def moved(self, a: Model, variable: int, start: int, by: int) -> Model:
        """t (variable -1) or a set variable `x` replaced by `start + by x`, numbers in units, in the same range."""
        step = key([*[0] * variable, 1]) if variable >= 0 else 0
        weights, parts, lost = [[(0, 1)]], dict[int, Terms](), 0
        for i, terms in a.parts.items():
            for k, c in terms.items():
                e = i if variable < 0 else k >> WIDTH * (variable + 1) & 63
                while len(weights) <= e:
                    n = len(weights)
                    made = [(j, comb(n, j) * start ** (n - j) * by**j) for j in range(n + 1)]
                    weights.append([(j, w) for j, w in made if w])
                for j, w in weights[e]:
                    mine = parts.setdefault(j if variable < 0 else i, {})
                    there = k - (e - j) * step
                    mine[there] = mine.get(there, 0) + (c * w >> self.bits * e)
                lost += len(weights[e]) if e else 0
        spend(3 + lost)
        return Model(parts, a.radius + lost)

    def replaced(self, a: Model, variable: int, by: Model) -> Model:
        """t (variable -1) or a set variable replaced by a model in the same range, in Horner's way."""
        powers: dict[int, dict[int, Terms]] = {}
        step = key([*[0] * variable, 1]) if variable >= 0 else 0
        for i, terms in a.parts.items():
            for k, c in terms.items():
                e = i if variable < 0 else k >> WIDTH * (variable + 1) & 63
                powers.setdefault(e, {}).setdefault(0 if variable < 0 else i, {})[k - e * step] = c
        top = max(powers, default=0)
        out = Model(powers.get(top, {}), 0)
        for e in range(top - 1, -1, -1):
            out = add(self.mul(out, by), Model(powers.get(e, {}), 0))
        return widened(out, a.radius)
