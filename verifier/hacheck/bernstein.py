"""Subdivision trees: signs on a box read off Bernstein coefficients, which enclose the range of a polynomial."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from functools import lru_cache
from math import comb, lcm, prod
from typing import Any

from hacheck import sturm
from hacheck.formula import Formula, literal, replace, sign_fits, true, variables
from hacheck.polynomial import Poly, by_power, names, substitute
from hacheck.rational import Beyond, Interval, Refused, number, spend

Box = dict[str, Interval]
MAX_COEFFICIENTS = 50_000


@lru_cache(maxsize=512)
def _matrix(low: Fraction, high: Fraction, d: int) -> tuple[list[list[int]], int]:
    """Monomial to Bernstein coefficients on [low, high], and the positive number to divide by.

    Coefficient j is the polar form of x^k at d-j copies of low and j of high: an elementary symmetric
    polynomial, sum over i of C(j,i) C(d-j,k-i) high^i low^(k-i), divided by C(d,k).
    """
    q = lcm(low.denominator, high.denominator)
    a, b, unit = int(low * q), int(high * q), lcm(*(comb(d, k) for k in range(d + 1)))
    spend((d + 1) ** 3 * (1 + (d * (q.bit_length() + a.bit_length() + b.bit_length()) >> 8)))

    def entry(j: int, k: int) -> int:
        terms: Iterator[int] = (comb(j, i) * comb(d - j, k - i) * b**i * a ** (k - i) for i in range(min(j, k) + 1))
        return int(sum(terms) * q ** (d - k) * (unit // comb(d, k)))

    return [[entry(j, k) for k in range(d + 1)] for j in range(d + 1)], q**d * unit


def _along(flat: list[int], stride: int, rows: list[list[int]]) -> list[int]:
    """The matrix applied along one axis of a tensor stored flat."""
    n, out = len(rows), [0] * len(flat)
    for block in range(0, len(flat), stride * n):
        for base in range(block, block + stride):
            line = flat[base : base + stride * n : stride]
            for j, row in enumerate(rows):
                out[base + j * stride] = sum(r * x for r, x in zip(row, line, strict=True))
    return out


def coefficients(p: Poly, box: Box) -> tuple[list[int], int] | None:
    """Bernstein coefficients as integers over one positive denominator; None where the box is unbounded."""
    order = sorted(names(p))
    degree = [max(dict(m).get(v, 0) for m in p) for v in order]
    size = prod(d + 1 for d in degree)
    if size > MAX_COEFFICIENTS:
        raise Beyond("a polynomial has too many Bernstein coefficients")
    divisor = lcm(*(c.denominator for c in p.values()))
    spend(size * (sum(degree) + 1) * (1 + (divisor.bit_length() >> 8)))
    stride = [prod(d + 1 for d in degree[i + 1 :]) for i in range(len(order))]
    steps, flat = dict(zip(order, stride, strict=True)), [0] * size
    for m, c in p.items():
        flat[sum(steps[v] * k for v, k in m)] = c.numerator * (divisor // c.denominator)
    for v, d in zip(order, degree, strict=True):
        low, high = box.get(v, (None, None))
        if low is None or high is None:
            return None
        rows, factor = _matrix(low, high, d)
        flat, divisor = _along(flat, steps[v], rows), divisor * factor
    return flat, divisor


def bounds(p: Poly, box: Box) -> Interval:
    """An enclosure of the range of p on the box, the least and greatest Bernstein coefficient."""
    if not p:
        return Fraction(0), Fraction(0)
    found = coefficients(p, box)
    return (None, None) if found is None else (Fraction(min(found[0]), found[1]), Fraction(max(found[0]), found[1]))


def certain(op: str, p: Poly, box: Box) -> bool:
    """Is `p op 0` everywhere on the box, by its Bernstein coefficients?"""
    found = coefficients(p, box) if p else ([0], 1)
    if found is None:
        return False
    low, high = min(found[0]), max(found[0])
    if op == "!=":
        return low > 0 or high < 0
    return sign_fits(op, low) and sign_fits(op, high)


def holds(f: Formula, box: Box) -> bool:
    """Is the formula true everywhere on the box, by the signs of its literals?"""
    return true(f, lambda op, p: certain(op, p, box))


def _one_variable(f: Formula, box: Box) -> bool:
    """Exact decision in one variable; literals that mention others count only where their sign is certain."""
    if holds(f, box):
        return True
    for v in sorted(variables(f)):
        left = replace(f, lambda op, p, v=v: (op, p) if names(p) == {v} else certain(op, p, box))  # type: ignore[misc]
        if sturm.always(left, v, *box.get(v, (None, None))):
            return True
    return False


def eliminate(f: Formula, v: str, box: Box) -> Formula:
    """The formula without v, literals at their worst end; where that is unknown the literal counts as false."""

    def worst(op: str, p: Poly) -> Formula:
        parts = by_power(p, v)
        if set(parts) <= {0}:
            return (op, p)
        if set(parts) <= {0, 1} and op in ("<", "<="):
            for sign, end in ((">=", box[v][1]), ("<=", box[v][0])):
                if end is not None and _signed(sign, parts[1], box):
                    return literal(op, substitute(p, {v: {(): end} if end else {}}, {}))
        return False

    return replace(f, worst)


def _signed(op: str, p: Poly, box: Box) -> bool:
    """Is `p op 0` everywhere on the box: by its coefficients, or exactly where there is one variable?"""
    if certain(op, p, box):
        return True
    only = names(p)
    return len(only) == 1 and all(sturm.always(literal(op, p), v, *box.get(v, (None, None))) for v in only)


def replay(tree: Any, f: Formula, box: Box) -> None:
    """Follow a TREE of docs/core.md section 5: it must show f on the box."""
    spend(10)
    if tree == "b" or tree == "u":
        if not (holds if tree == "b" else _one_variable)(f, box):
            raise Refused(f"a leaf {tree!r} of a subdivision tree does not show its formula")
    elif isinstance(tree, list) and len(tree) == 5 and tree[0] == "s":
        v, q = _known(tree[1], box), number(tree[2])
        low, high = box[v]
        if (low is not None and q <= low) or (high is not None and q >= high):
            raise Refused(f"a tree splits {tree[1]} outside its box")
        replay(tree[3], f, {**box, v: (low, q)})
        replay(tree[4], f, {**box, v: (q, high)})
    elif isinstance(tree, list) and len(tree) == 3 and tree[0] == "e" and isinstance(tree[1], list):
        for name in tree[1]:
            v = _known(name, box)
            f, box = eliminate(f, v, box), {k: i for k, i in box.items() if k != v}
        replay(tree[2], f, box)
    else:
        raise Refused("a subdivision tree is malformed")


def _known(name: object, box: Box) -> str:
    if not isinstance(name, str) or name not in box:
        raise Refused("a tree names a variable that its box does not have")
    return name
