"""Subdivision trees: signs on a box read off Bernstein coefficients, which enclose the range of a polynomial."""

from __future__ import annotations

from fractions import Fraction
from functools import lru_cache
from math import comb, lcm, prod
from typing import Any

from hacheck import sturm
from hacheck.formula import Formula, literal, replace, sign_fits, true, variables
from hacheck.polynomial import ZERO, Poly, add, by_power, names, scale
from hacheck.rational import Beyond, Interval, Refused, number, spend

Box = dict[str, Interval]
MAX_COEFFICIENTS = 50_000


@lru_cache(maxsize=2048)
def _matrix(a: int, p: int, b: int, q: int, d: int) -> tuple[list[list[int]], int]:
    """Monomial to Bernstein coefficients on [a/p, b/q], and the positive number to divide by.

    Coefficient j is the polar form of x^k at d-j copies of low and j of high: an elementary symmetric
    polynomial, sum over i of C(j,i) C(d-j,k-i) high^i low^(k-i), divided by C(d,k).
    """
    unit, whole = lcm(p, q), lcm(*(comb(d, k) for k in range(d + 1)))
    a, b = a * (unit // p), b * (unit // q)
    spend((d + 1) ** 3 * (1 + (d * (unit.bit_length() + a.bit_length() + b.bit_length()) >> 8)))

    def entry(j: int, k: int) -> int:
        terms = (comb(j, i) * comb(d - j, k - i) * b**i * a ** (k - i) for i in range(min(j, k) + 1))
        return int(sum(terms) * unit ** (d - k) * (whole // comb(d, k)))

    return [[entry(j, k) for k in range(d + 1)] for j in range(d + 1)], unit**d * whole


def _along(flat: list[int], stride: int, rows: list[list[int]]) -> list[int]:
    """The matrix applied along one axis of a tensor stored flat."""
    out, step = [0] * len(flat), stride * len(rows)
    for block in range(0, len(flat), step):
        for base in range(block, block + stride):
            line = flat[base : block + step : stride]
            out[base : block + step : stride] = [sum(map(int.__mul__, row, line)) for row in rows]
    return out


def coefficients(p: Poly, box: Box) -> tuple[list[int], int] | None:
    """Bernstein coefficients as integers over one positive denominator; None where the box is unbounded."""
    degree = {v: max(m.count(v) for m in p.terms) for v in sorted(names(p))}
    size = prod(d + 1 for d in degree.values())
    if size > MAX_COEFFICIENTS:
        raise Beyond("a polynomial has too many Bernstein coefficients")
    spend(size * (sum(degree.values()) + 1) * (1 + (p.bits >> 8)))
    flat, divisor, left = [0] * size, p.unit, size
    stride = {v: (left := left // (d + 1)) for v, d in degree.items()}
    for m, c in p.terms.items():
        flat[sum(map(stride.__getitem__, m))] = c
    for v, d in degree.items():
        low, high = box.get(v, (None, None))
        if low is None or high is None:
            return None
        rows, factor = _matrix(low.numerator, low.denominator, high.numerator, high.denominator, d)
        flat, divisor = _along(flat, stride[v], rows), divisor * factor
    return flat, divisor


def bounds(p: Poly, box: Box) -> Interval:
    """An enclosure of the range of p on the box, the least and greatest Bernstein coefficient."""
    found = coefficients(p, box)
    return (None, None) if found is None else (Fraction(min(found[0]), found[1]), Fraction(max(found[0]), found[1]))


def certain(op: str, p: Poly, box: Box) -> bool:
    """Is `p op 0` everywhere on the box, by its Bernstein coefficients?"""
    found = coefficients(p, box)
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
        if parts.keys() <= {0}:
            return (op, p)
        if parts.keys() <= {0, 1} and op in ("<", "<="):
            for sign, end in ((">=", box[v][1]), ("<=", box[v][0])):
                if end is not None and _signed(sign, parts[1], box):
                    return literal(op, add(scale(parts[1], end), parts.get(0, ZERO)))
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
