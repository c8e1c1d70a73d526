"""Polynomials in one variable with floats as coefficients, lowest first."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from haverify.report.figures.material import Undrawable

Coefficients = list[float]

_DEGREE = 300


def evaluated(name: str | None, coefficients: Coefficients) -> Callable[[Mapping[str, float]], float]:
    """The polynomial as a function, by Horner's rule."""
    if name is None or len(coefficients) == 1:
        only = coefficients[0]
        return lambda _: only
    highest_first = coefficients[::-1]

    def value(s: Mapping[str, float]) -> float:
        x, total = s[name], 0.0
        for c in highest_first:
            total = total * x + c
        return total

    return value


def _sum(terms: Sequence[Coefficients]) -> Coefficients:
    total = [0.0] * max(map(len, terms))
    for t in terms:
        for k, c in enumerate(t):
            total[k] += c
    return total


def product(factors: Sequence[Coefficients]) -> Coefficients:
    """The product.

    Raises
    ------
    Undrawable      for a degree that no drawing needs
    """
    whole = [1.0]
    for f in factors:
        if len(whole) + len(f) > _DEGREE:
            raise Undrawable
        longer = [0.0] * (len(whole) + len(f) - 1)
        for i, a in enumerate(whole):
            for k, b in enumerate(f):
                longer[i + k] += a * b
        whole = longer
    return whole


def _negated(terms: Sequence[Coefficients]) -> Coefficients:
    return [-c for c in terms[0]]


COMBINED: dict[str, Callable[[Sequence[Coefficients]], Coefficients]] = {
    "+": _sum,
    "-": lambda terms: _sum([terms[0], _negated(terms[1:])]),
    "neg": _negated,
    "*": product,
}
