"""Sparse polynomials in several variables over the rationals."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from fractions import Fraction

Monomial = tuple[tuple[str, int], ...]
ZERO = Fraction(0)
ONE = Fraction(1)


class Polynomial:
    """A polynomial, as its nonzero coefficients by monomial; a monomial is sorted (variable, exponent) pairs.

    Immutable by convention. Equality is equality of polynomials.
    """

    __slots__ = ("_hash", "_variables", "terms")

    def __init__(self, terms: Mapping[Monomial, Fraction]) -> None:
        self.terms: Mapping[Monomial, Fraction] = terms
        self._hash: int | None = None
        self._variables: tuple[str, ...] | None = None

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Polynomial) and self.terms == other.terms

    def __hash__(self) -> int:
        if self._hash is None:
            self._hash = hash(frozenset(self.terms.items()))
        return self._hash

    def __repr__(self) -> str:
        return f"Polynomial({self})"

    def __str__(self) -> str:
        return " + ".join(_term_text(m, c) for m, c in sorted(self.terms.items())) or "0"

    def __add__(self, other: Polynomial) -> Polynomial:
        if len(self.terms) < len(other.terms):
            self, other = other, self
        terms = dict(self.terms)
        for m, c in other.terms.items():
            total = terms.get(m, ZERO) + c
            if total:
                terms[m] = total
            else:
                terms.pop(m, None)
        return Polynomial(terms)

    def __neg__(self) -> Polynomial:
        return Polynomial({m: -c for m, c in self.terms.items()})

    def __sub__(self, other: Polynomial) -> Polynomial:
        return self + (-other)

    def __mul__(self, other: Polynomial) -> Polynomial:
        left, right = self.constant, other.constant
        if left is not None:
            return other.scaled(left)
        if right is not None:
            return self.scaled(right)
        terms: dict[Monomial, Fraction] = {}
        for m, c in self.terms.items():
            for n, d in other.terms.items():
                product = _times(m, n)
                terms[product] = terms.get(product, ZERO) + c * d
        return Polynomial({m: c for m, c in terms.items() if c})

    def __pow__(self, exponent: int) -> Polynomial:
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
        return self if factor == 1 else Polynomial({m: c * factor for m, c in self.terms.items()})

    @property
    def constant(self) -> Fraction | None:
        """The value of a constant polynomial, None for others."""
        if not self.terms:
            return ZERO
        return self.terms.get(()) if len(self.terms) == 1 else None

    @property
    def variables(self) -> tuple[str, ...]:
        """The variables that occur, sorted."""
        if self._variables is None:
            self._variables = tuple(sorted({v for m in self.terms for v, _ in m}))
        return self._variables

    def degree(self, variable: str) -> int:
        """The highest exponent of `variable`."""
        return max((e for m in self.terms for v, e in m if v == variable), default=0)

    def total_degree(self) -> int:
        """The highest sum of exponents of one term."""
        return max((sum(e for _, e in m) for m in self.terms), default=0)

    def derivative(self, variable: str) -> Polynomial:
        """The partial derivative."""
        terms: dict[Monomial, Fraction] = {}
        for m, c in self.terms.items():
            for i, (v, e) in enumerate(m):
                if v == variable:
                    lower = ((v, e - 1),) if e > 1 else ()
                    terms[m[:i] + lower + m[i + 1 :]] = c * e
        return Polynomial(terms)

    def substitute(self, values: Mapping[str, Polynomial]) -> Polynomial:
        """The polynomial with each variable of `values` replaced by its polynomial, all at once."""
        if not any(v in values for v in self.variables):
            return self
        powers: dict[tuple[str, int], Polynomial] = {}
        sums: dict[Monomial, Fraction] = {}
        for m, c in self.terms.items():
            kept = tuple((v, e) for v, e in m if v not in values)
            product = Polynomial({kept: c})
            for v, e in m:
                if v in values:
                    if (v, e) not in powers:
                        powers[v, e] = values[v] ** e
                    product = product * powers[v, e]
            for n, d in product.terms.items():
                sums[n] = sums.get(n, ZERO) + d
        return Polynomial({m: c for m, c in sums.items() if c})

    def fix(self, values: Mapping[str, Fraction]) -> Polynomial:
        """The polynomial with each variable of `values` replaced by its number."""
        if not any(v in values for v in self.variables):
            return self
        sums: dict[Monomial, Fraction] = {}
        for m, c in self.terms.items():
            kept: list[tuple[str, int]] = []
            for v, e in m:
                if v in values:
                    c = c * values[v] ** e
                else:
                    kept.append((v, e))
            key = tuple(kept)
            sums[key] = sums.get(key, ZERO) + c
        return Polynomial({m: c for m, c in sums.items() if c})

    def value(self, values: Mapping[str, Fraction]) -> Fraction:
        """The value at a point that gives every variable; KeyError where one is missing."""
        total = ZERO
        for m, c in self.terms.items():
            for v, e in m:
                c = c * values[v] ** e
            total += c
        return total

    def coefficients(self, variable: str) -> list[Polynomial]:
        """The coefficients as a polynomial in `variable` alone, lowest power first; at least one."""
        parts: list[dict[Monomial, Fraction]] = [{} for _ in range(self.degree(variable) + 1)]
        for m, c in self.terms.items():
            exponent = next((e for v, e in m if v == variable), 0)
            parts[exponent][tuple((v, e) for v, e in m if v != variable)] = c
        return [Polynomial(p) for p in parts]

    def univariate(self) -> list[Fraction]:
        """The coefficients of a polynomial in at most one variable, lowest power first; at least one."""
        dense = [ZERO] * (max((m[0][1] if m else 0 for m in self.terms), default=0) + 1)
        for m, c in self.terms.items():
            dense[m[0][1] if m else 0] = c
        return dense


NOUGHT = Polynomial({})


def constant(value: Fraction | int) -> Polynomial:
    """The constant polynomial."""
    return Polynomial({(): Fraction(value)}) if value else NOUGHT


def variable(name: str) -> Polynomial:
    """The polynomial that is one variable."""
    return Polynomial({((name, 1),): ONE})


def total(polynomials: Iterable[Polynomial]) -> Polynomial:
    """The sum."""
    terms: dict[Monomial, Fraction] = {}
    for p in polynomials:
        for m, c in p.terms.items():
            terms[m] = terms.get(m, ZERO) + c
    return Polynomial({m: c for m, c in terms.items() if c})


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
