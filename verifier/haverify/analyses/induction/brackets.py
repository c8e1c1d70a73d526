"""Starts that equations leave no rational values: zeros between two numbers (docs/core.md section 9)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction

from haverify.analyses.synthesis.starts import pivots
from haverify.maths.bernstein import bounds
from haverify.maths.polynomial import Polynomial
from haverify.obligations.formula import Formula, Literal, by_bounds, truth
from haverify.obligations.premises import Premises
from haverify.text.record import record

Q = Fraction
Ends = tuple[Q, Q]
STEPS, DIGITS = 6, 10**40  # of Newton's method, and of the numbers that it is made with
WIDTH, WIDER = Q(1, 2**60), 2**8  # of a bracket, relative; how much wider than those it depends on
MOST = 4
DENOMINATORS = (1000, 10**6)


@record
class Bracketed:
    """An admissible start: numbers, and brackets in which there are values that make it one."""

    mode: str
    point: dict[str, Q]
    roots: dict[str, Ends]

    def ends(self, name: str) -> Ends:
        """Bounds of the value of a name."""
        return self.roots[name] if name in self.roots else (self.point[name], self.point[name])


def bracketed(told: Premises, names: Sequence[str], near: Mapping[str, float], mode: str) -> Iterator[Bracketed]:
    """Admissible starts near floats, the equations solved for names of their own."""
    leaves = [e for e in told.entries if isinstance(e, Literal)]
    left = pivots([q.polynomial for q in leaves if q.op == "=="])
    for denominator in DENOMINATORS:
        point = {v: Q(round(near[v] * denominator), denominator) for v in names if v not in left}
        found = _solved(left, point, near)
        if found is None or not 0 < len(found.roots) <= MOST:
            continue
        box = {v: found.ends(v) for v in names}
        rooted = [left[v] for v in found.roots]
        rest = [e for e in told.entries if not (isinstance(e, Literal) and e.op == "==" and e.polynomial in rooted)]
        if all(_holds(e, box) for e in rest):
            yield Bracketed(mode, found.point, found.roots)


def _holds(e: Formula, box: Mapping[str, Ends]) -> bool:
    return truth(e, lambda q: by_bounds(q.op, *bounds(q.polynomial, dict(box)))) is True


def _solved(equations: Mapping[str, Polynomial], point: dict[str, Q], near: Mapping[str, float]) -> Bracketed | None:
    """Every equation solved for its name: exactly, where its number is rational, else in a bracket."""
    left, roots = dict(equations), dict[str, Ends]()
    while left:
        v = next((n for n, e in left.items() if all(w == n or w in point or w in roots for w in e.variables)), None)
        if v is None:
            return None
        p = left.pop(v).fix(point)
        width = WIDTH * WIDER ** sum(w in roots for w in p.variables)
        middle = _zero(p.fix({w: (a + b) / 2 for w, (a, b) in roots.items()}), v, Q(near[v]))
        if middle is None:
            return None
        if p.variables == (v,) and p.value({v: middle}) == 0:
            point[v] = middle
            continue
        roots[v] = (middle - width * abs(middle), middle + width * abs(middle))
        signs = [bounds(p, {**roots, v: (end, end)}) for end in roots[v]]
        if not any(signs[i][1] < 0 < signs[1 - i][0] for i in (0, 1)):
            return None
    return Bracketed("", point, roots)


def _zero(p: Polynomial, v: str, near: Q) -> Q | None:
    """A number next to a zero, by Newton's method, one that is short if there is one."""
    slope, x = p.derivative(v), near
    for _ in range(STEPS):
        steep = slope.value({v: x})
        if not steep:
            return None
        x = (x - p.value({v: x}) / steep).limit_denominator(DIGITS)
    short = x.limit_denominator(10**6)
    return short if p.value({v: short}) == 0 else x
