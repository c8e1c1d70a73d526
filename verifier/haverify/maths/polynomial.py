"""Sparse polynomials in several variables over the rationals: integer coefficients over one common denominator."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from fractions import Fraction
from math import gcd, lcm

from haverify.maths.univariate import scaled_value

Monomial = tuple[tuple[str, int], ...]
ZERO = Fraction(0)
ONE = Fraction(1)


class Polynomial:
    """`sum whole[m] m / divisor`; a monomial is sorted (variable, exponent) pairs.

    Immutable by convention. In lowest terms and without zeros, so that equality is equality of polynomials.
    """

    __slots__ = ("_hash", "_terms", "_variables", "divisor", "whole")

    def __init__(self, whole: Mapping[Monomial, int], divisor: int = 1) -> None:
        common = gcd(divisor, *whole.values()) if divisor != 1 else 1
        if common != 1:
            whole, divisor = {m: c // common for m, c in whole.items()}, divisor // common
        self.whole, self.divisor = whole, divisor
        self._hash: int | None = None
        self._variables: tuple[str, ...] | None = None
        self._terms: Mapping[Monomial, Fraction] | None = None

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Polynomial) and self.divisor == other.divisor and self.whole == other.whole

    def __hash__(self) -> int:
        if self._hash is None:
            self._hash = hash((self.divisor, frozenset(self.whole.items())))
        return self._hash

    def __repr__(self) -> str:
        return f"Polynomial({self})"

    def __str__(self) -> str:
        return " + ".join(_term_text(m, c) for m, c in sorted(self.terms.items())) or "0"

    @property
    def terms(self) -> Mapping[Monomial, Fraction]:
        """The coefficients by monomial, none of them zero."""
        if self._terms is None:
            self._terms = {m: Fraction(c, self.divisor) for m, c in self.whole.items()}
        return self._terms

    def __add__(self, other: Polynomial) -> Polynomial:
        return total((self, other))

    def __neg__(self) -> Polynomial:
        return Polynomial({m: -c for m, c in self.whole.items()}, self.divisor)

    def __sub__(self, other: Polynomial) -> Polynomial:
        return total((self, -other))

    def __mul__(self, other: Polynomial) -> Polynomial:
        whole: dict[Monomial, int] = {}
        for m, c in self.whole.items():
            for n, d in other.whole.items():
                product = _times(m, n)
                whole[product] = whole.get(product, 0) + c * d
        return Polynomial(_without_zeros(whole), self.divisor * other.divisor)

    def __pow__(self, exponent: int) -> Polynomial:
        if len(self.whole) == 1 and exponent:
            ((m, c),) = self.whole.items()
            return Polynomial({tuple((v, e * exponent) for v, e in m): c**exponent}, self.divisor**exponent)
        result, base = constant(ONE), self
        while exponent:
            if exponent & 1:
                result = result * base
            exponent >>= 1
            if exponent:
                base = base * base
        return result

    def scaled(self, factor: Fraction) -> Polynomial:
        """`factor` times the polynomial."""
        if not factor:
            return NOUGHT
        n = factor.numerator
        return self if factor == 1 else Polynomial(
            {m: c * n for m, c in self.whole.items()}, self.divisor * factor.denominator
        )  # fmt: skip

    @property
    def constant(self) -> Fraction | None:
        """The value of a constant polynomial, None for others."""
        if not self.whole:
            return ZERO
        return Fraction(self.whole[()], self.divisor) if len(self.whole) == 1 and () in self.whole else None

    @property
    def variables(self) -> tuple[str, ...]:
        """The variables that occur, sorted."""
        if self._variables is None:
            self._variables = tuple(sorted({v for m in self.whole for v, _ in m}))
        return self._variables

    def degree(self, variable: str) -> int:
        """The highest exponent of `variable`."""
        return max((e for m in self.whole for v, e in m if v == variable), default=0)

    def total_degree(self) -> int:
        """The highest sum of exponents of one term."""
        return max((sum(e for _, e in m) for m in self.whole), default=0)

    def derivative(self, variable: str) -> Polynomial:
        """The partial derivative."""
        whole: dict[Monomial, int] = {}
        for m, c in self.whole.items():
            for i, (v, e) in enumerate(m):
                if v == variable:
                    lower = ((v, e - 1),) if e > 1 else ()
                    whole[m[:i] + lower + m[i + 1 :]] = c * e
        return Polynomial(whole, self.divisor)

    def substitute(self, values: Mapping[str, Polynomial]) -> Polynomial:
        """The polynomial with each variable of `values` replaced by its polynomial, all at once."""
        if not any(v in values for v in self.variables):
            return self
        powers: dict[tuple[str, int], Polynomial] = {}
        products = []
        for m, c in self.whole.items():
            product = Polynomial({tuple(x for x in m if x[0] not in values): c})
            for v, e in m:
                if v in values:
                    if (v, e) not in powers:
                        powers[v, e] = values[v] ** e
                    product = product * powers[v, e]
            products.append(product)
        whole = total(products)
        return Polynomial(whole.whole, whole.divisor * self.divisor)

    def fix(self, values: Mapping[str, Fraction]) -> Polynomial:
        """The polynomial with each variable of `values` replaced by its number."""
        if not any(v in values for v in self.variables):
            return self
        known = {v: (values[v].numerator, values[v].denominator) for v in self.variables if v in values}
        found: list[tuple[Monomial, int, int]] = []
        for m, c in self.whole.items():
            divisor = 1
            kept = []
            for x in m:
                if x[0] in known:
                    n, d = known[x[0]]
                    c, divisor = c * n ** x[1], divisor * d ** x[1]
                else:
                    kept.append(x)
            found.append((tuple(kept), c, divisor))
        return _sum_of(found, self.divisor)

    def value(self, values: Mapping[str, Fraction]) -> Fraction:
        """The value at a point that gives every variable; KeyError where one is missing."""
        if len(self.variables) == 1:
            x, dense = values[self.variables[0]], tuple(self.dense())
            return Fraction(scaled_value(dense, x), self.divisor * x.denominator ** (len(dense) - 1))
        fixed = self.fix({v: values[v] for v in self.variables})
        return Fraction(fixed.whole[()], fixed.divisor) if fixed.whole else ZERO

    def coefficients(self, variable: str) -> list[Polynomial]:
        """The coefficients as a polynomial in `variable` alone, lowest power first; at least one."""
        parts: list[dict[Monomial, int]] = [{} for _ in range(self.degree(variable) + 1)]
        for m, c in self.whole.items():
            exponent = next((e for v, e in m if v == variable), 0)
            parts[exponent][tuple(x for x in m if x[0] != variable)] = c
        return [Polynomial(p, self.divisor) for p in parts]

    def univariate(self) -> list[Fraction]:
        """The coefficients of a polynomial in at most one variable, lowest power first; at least one."""
        return [Fraction(c, self.divisor) for c in self.dense()]

    def dense(self) -> list[int]:
        """The same, times the divisor."""
        dense = [0] * (max((m[0][1] if m else 0 for m in self.whole), default=0) + 1)
        for m, c in self.whole.items():
            dense[m[0][1] if m else 0] = c
        return dense


NOUGHT = Polynomial({})


def constant(value: Fraction | int) -> Polynomial:
    """The constant polynomial."""
    return Polynomial({(): value.numerator}, value.denominator) if value else NOUGHT


def variable(name: str) -> Polynomial:
    """The polynomial that is one variable."""
    return Polynomial({((name, 1),): 1})


def total(polynomials: Iterable[Polynomial]) -> Polynomial:
    """The sum."""
    members = list(polynomials)
    divisor = lcm(*(p.divisor for p in members))
    whole: dict[Monomial, int] = {}
    for p in members:
        factor = divisor // p.divisor
        for m, c in p.whole.items():
            whole[m] = whole.get(m, 0) + c * factor
    return Polynomial(_without_zeros(whole), divisor)


def _sum_of(terms: list[tuple[Monomial, int, int]], divisor: int) -> Polynomial:
    """The sum of terms `c m / d`, divided by `divisor`."""
    common = lcm(*(d for _, _, d in terms))
    whole: dict[Monomial, int] = {}
    for m, c, d in terms:
        whole[m] = whole.get(m, 0) + c * (common // d)
    return Polynomial(_without_zeros(whole), divisor * common)


def _without_zeros(whole: dict[Monomial, int]) -> dict[Monomial, int]:
    return whole if all(whole.values()) else {m: c for m, c in whole.items() if c}


def _times(m: Monomial, n: Monomial) -> Monomial:
    if not m or not n:
        return m or n
    if len(m) == 1 and len(n) == 1 and m[0][0] == n[0][0]:
        return ((m[0][0], m[0][1] + n[0][1]),)
    exponents = dict(m)
    for v, e in n:
        exponents[v] = exponents.get(v, 0) + e
    return tuple(sorted(exponents.items()))


def _term_text(m: Monomial, c: Fraction) -> str:
    powers = [v if e == 1 else f"{v}^{e}" for v, e in m]
    return "*".join([str(c), *powers]) if c != 1 or not m else "*".join(powers)
