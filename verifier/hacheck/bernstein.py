"""Is a formula true on a box? By signs of Bernstein coefficients, by cutting the box, exactly in one variable."""

from __future__ import annotations

from fractions import Fraction
from functools import lru_cache
from math import ceil, comb, floor, lcm, prod
from typing import Any

from hacheck import sturm
from hacheck.formula import Formula, disj, literal, placed, replace, sign_fits, true, variables
from hacheck.polynomial import ZERO, Env, Poly, by_power, const, names, total
from hacheck.rational import Beyond, Interval, Refused, number, spend

Box = dict[str, Interval]
FREE: Interval = (None, None)
FINITE: Interval = (Fraction(1), Fraction(1))
MAX_COEFFICIENTS = 50_000


def meet(a: Interval, b: Interval) -> Interval:
    """The intersection; empty ones have low > high."""
    low = a[0] if b[0] is None else b[0] if a[0] is None else max(a[0], b[0])
    return low, a[1] if b[1] is None else b[1] if a[1] is None else min(a[1], b[1])


def point(i: Interval) -> Fraction | None:
    """The only number in an interval."""
    return i[0] if i[0] == i[1] else None


def _is_bounded(i: Interval) -> bool:
    return i[0] is not None and i[1] is not None


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


def _matrix_on(i: Interval, d: int) -> tuple[list[list[int]], int]:
    low, high = i
    assert low is not None and high is not None
    return _matrix(low.numerator, low.denominator, high.numerator, high.denominator, d)


def _along(flat: list[int], stride: int, rows: list[list[int]]) -> list[int]:
    """The matrix applied along one axis of a tensor stored flat."""
    out, step = [0] * len(flat), stride * len(rows)
    for block in range(0, len(flat), step):
        for base in range(block, block + stride):
            line = flat[base : block + step : stride]
            out[base : block + step : stride] = [sum(map(int.__mul__, row, line)) for row in rows]
    return out


def _range(p: Poly, box: Box) -> tuple[Fraction | int | None, Fraction | int | None, int]:
    """Numbers below and above p on the box, None where there are none, and the positive number to divide them by.

    They are the least and greatest Bernstein coefficient, and exact for sums of single variables; of unbounded boxes
    only such sums are understood.
    """
    found = names(p)
    if not all(_is_bounded(box.get(v, FREE)) for v in found) or (len(found) > 1 and max(map(len, p.terms)) == 1):
        ends = [(c, (FINITE if not m else box.get(m[0], FREE) if len(m) == 1 else FREE)) for m, c in p.terms.items()]
        lows, highs = [(c, i[c < 0]) for c, i in ends], [(c, i[c > 0]) for c, i in ends]
        return _sum(lows), _sum(highs), p.unit
    if len(found) == 1:
        return _range_on_line(p, box[min(found)])
    degree = {v: max([m.count(v) for m in p.terms]) for v in sorted(found)}
    size = prod([d + 1 for d in degree.values()])
    if size > MAX_COEFFICIENTS:
        raise Beyond("a polynomial has too many Bernstein coefficients")
    spend(size * (sum(degree.values()) + 1) * (1 + (p.bits >> 8)))
    flat, divisor, left = [0] * size, p.unit, size
    stride = {v: (left := left // (d + 1)) for v, d in degree.items()}
    for m, c in p.terms.items():
        flat[sum(map(stride.__getitem__, m))] = c
    for v, d in degree.items():
        rows, factor = _matrix_on(box[v], d)
        flat, divisor = _along(flat, stride[v], rows), divisor * factor
    return min(flat), max(flat), divisor


def _range_on_line(p: Poly, i: Interval) -> tuple[int, int, int]:
    """The same for a polynomial in one variable."""
    line = [0] * (1 + max(map(len, p.terms)))
    spend(len(line) ** 2 * (1 + (p.bits >> 8)))
    for m, c in p.terms.items():
        line[len(m)] = c
    rows, factor = _matrix_on(i, len(line) - 1)
    flat = [sum(map(int.__mul__, row, line)) for row in rows]
    return min(flat), max(flat), p.unit * factor


def _sum(products: list[tuple[int, Fraction | None]]) -> Fraction | None:
    known = [c * x for c, x in products if x is not None]
    return sum(known, Fraction(0)) if len(known) == len(products) else None


def bounds(p: Poly, box: Box) -> Interval:
    """An enclosure of the range of p on the box."""
    low, high, divisor = _range(p, box)
    return None if low is None else Fraction(low, divisor), None if high is None else Fraction(high, divisor)


def certain(op: str, p: Poly, box: Box) -> bool:
    """Is `p op 0` everywhere on the box, as far as the enclosure of its range tells?"""
    if len(p.terms) == 1:
        ((m, c),) = p.terms.items()
        if all((least := box.get(v, FREE)[0]) is not None and least.numerator > 0 for v in m):
            return sign_fits(op, c)  # no variable is 0 or below
    low, high, _ = _range(p, box)
    above, below = low is not None and low > 0, high is not None and high < 0
    if op in ("==", "!="):
        return (above or below) if op == "!=" else low == high == 0
    end = high if op[0] == "<" else low
    return end is not None and sign_fits(op, end)


def cut(f: Formula, box: Box) -> Box | None:
    """A box around the points of the box where f may be false; None where there are none.

    Outside a disjunction all members are false, outside a conjunction one is: the hull of what they leave.
    """
    spend(20)
    if isinstance(f, bool):
        return None if f else box
    if f[0] == "or":
        for g in f[1:]:
            smaller = cut(g, box)
            if smaller is None:
                return None
            box = smaller
        return box
    if f[0] != "and":
        return _cut_literal(f[0], f[1], box)
    left = [b for b in (cut(g, box) for g in f[1:]) if b is not None]
    return {v: _hull([b.get(v, FREE) for b in left]) for v in box} if len(left) > 1 else left[0] if left else None


def _hull(intervals: list[Interval]) -> Interval:
    lows, highs = [i[0] for i in intervals], [i[1] for i in intervals]
    return (None if None in lows else min(lows)), (None if None in highs else max(highs))  # type: ignore[type-var]


def _cut_literal(op: str, p: Poly, box: Box) -> Box | None:
    """The same for `p op 0`, which bounds the variables that p can be solved for."""
    found = names(p)
    line = len(found) == 1 and max(map(len, p.terms)) == 1 and op != "=="
    if not line and certain(op, p, box):
        return None
    for v in found if op != "==" else ():
        a, least, most = _solved(p, v, box)
        if a:
            ends = least if a > 0 or op == "!=" else None, most if a < 0 or op == "!=" else None
            low, high = meet(box.get(v, FREE), ends)
            if low is not None and high is not None and (low > high or (op == "<=" and least == most == low == high)):
                return None
            box = {**box, v: (low, high)}
    return box


def _solved(p: Poly, v: str, box: Box) -> tuple[int, Fraction | None, Fraction | None]:
    """a, and bounds of `-r / a`, if p is a positive multiple of `a v + r` with a number a and r without v; else 0."""
    if [m for m in p.terms if v in m] != [(v,)]:
        return 0, None, None
    a = p.terms[v,]
    if len(p.terms) - (() in p.terms) == 1:
        end = Fraction(-p.terms.get((), 0), a)
        return a, end, end
    rest = Poly({m: c for m, c in p.terms.items() if m != (v,)}, 1, p.bits)
    least, most = (None if x is None else x / -a for x in bounds(rest, box))
    return (a, most, least) if a > 0 else (a, least, most)


def narrowed(f: Formula, box: Box) -> Box | None:
    """The box cut until nothing changes, or often enough."""
    for _ in range(4):
        new = cut(f, box)
        if new is None or new == box:
            return new
        box = new
    return box


def shown(f: Formula, box: Box, whole: frozenset[str] = frozenset()) -> bool:
    """Is f true on the box, for integer values of the variables in `whole`?

    The box is cut to where f may be false; what is left there is decided exactly in one variable.
    """
    left = variables(f)
    small = narrowed(f, {v: box.get(v, FREE) for v in left})
    if small is None:
        return True
    for v in sorted(left & whole):
        low, high = small[v]
        if low is not None and high is not None and (low != high or low.denominator != 1):
            if high - low > 1000:
                raise Beyond("a discrete variable has too many values")
            values = [Fraction(n) for n in range(ceil(low), floor(high) + 1)]
            return all(shown(f, {**small, v: (n, n)}, whole) for n in values)
    g = placed(f, Env({v: const(q) for v in left for q in [point(small[v])] if q is not None}))
    g = replace(g, lambda op, p: certain(op, p, small) or (op, p))
    return true(g, lambda op, p: False) or any(
        sturm.always(replace(g, lambda op, p, v=v: names(p) == {v} and (op, p)), *small[v])  # type: ignore[misc]
        for v in sorted(variables(g)))  # fmt: skip


def eliminate(f: Formula, v: str, box: Box) -> Formula:
    """The formula without v, literals at their worst end; where that is unknown the literal counts as false."""

    def worst(op: str, p: Poly) -> Formula:
        if not any(v in m for m in p.terms):
            return (op, p)
        parts = by_power(p, v)
        if parts.keys() <= {0, 1} and op in ("<", "<="):
            ends = [(sign, x) for sign, x in ((">=", box[v][1]), ("<=", box[v][0])) if x is not None]
            for sure in (certain, lambda sign, q, box: shown(literal(sign, q), box)):
                for end in (x for sign, x in ends if sure(sign, parts[1], box)):  # a positive multiple will do
                    return literal(op, total(((end.numerator, parts[1]), (end.denominator, parts.get(0, ZERO)))))
        return False

    return replace(f, worst)


def replay(tree: Any, f: Formula, box: Box, excuse: Formula = False) -> None:
    """Follow a TREE of docs/core.md section 5: it must show f on the box, where the excuse does not hold."""
    spend(10)
    if tree == "b" or tree == "u":
        if not shown(disj([excuse, f]), box):
            raise Refused(f"a leaf {tree!r} of a subdivision tree does not show its formula")
    elif isinstance(tree, list) and len(tree) == 5 and tree[0] == "s":
        v, q = _known(tree[1], box), number(tree[2])
        low, high = box[v]
        if (low is not None and q <= low) or (high is not None and q >= high):
            raise Refused(f"a tree splits {tree[1]} outside its box")
        replay(tree[3], f, {**box, v: (low, q)}, excuse)
        replay(tree[4], f, {**box, v: (q, high)}, excuse)
    elif isinstance(tree, list) and len(tree) == 3 and tree[0] == "e" and isinstance(tree[1], list):
        small = narrowed(excuse, box)
        if small is not None:
            small = dict(small)
            for name in tree[1]:
                f = eliminate(f, _known(name, small), small)
                del small[name]
            replay(tree[2], f, small, excuse)
    else:
        raise Refused("a subdivision tree is malformed")


def _known(name: object, box: Box) -> str:
    if not isinstance(name, str) or name not in box:
        raise Refused("a tree names a variable that its box does not have")
    return name
