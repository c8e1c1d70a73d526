"""Identities that a glance finds (proof `psatz`): two premises whose multiples add up to what is plainly not below 0.

Plainly: products of linear premises and of even powers of other names, times polynomials in bounded names whose
Bernstein coefficients are not below 0. Each Bernstein polynomial is a product of bounds, so that the identity is one
of premises.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import product
from math import comb, lcm, prod
from typing import Any

from haverify.maths.bernstein import tensor_coefficients
from haverify.maths.digits import rational_text
from haverify.maths.polynomial import Monomial, Polynomial, variable
from haverify.obligations.formula import Formula, Literal, negation
from haverify.obligations.functions import factors
from haverify.obligations.premises import Premises, whole
from haverify.text.record import field, record

Q = Fraction
Json = Any
MOST_PRODUCTS = 400


@record
class Bound:
    """Entry `place` says `scale * (v - end) >= 0` of a name v; below 0 the scale is that of an upper bound."""

    place: int
    end: Q
    scale: Q


Bounds = dict[str, tuple[Bound, Bound]]
Part = tuple[int, Literal, Q]
Terms = dict[Monomial, Q | int]


@record
class Frame:
    """Coordinates: names with two bounds, and linear premises in place of names, as `name = linear in coordinates`."""

    strict: frozenset[int]  # the places of strict inequalities
    ends: Bounds
    forms: dict[str, int]  # a coordinate and the place of the premise that it is
    values: dict[str, Polynomial]  # what replaced names are in coordinates
    images: dict[Polynomial, Polynomial] = field(default_factory=dict, compare=False)

    def image(self, p: Polynomial) -> Polynomial:
        """A polynomial in coordinates."""
        if p not in self.images:
            self.images[p] = p.substitute(self.values)
        return self.images[p]


def glance(entries: Sequence[Formula]) -> Json | None:
    """A proof from one premise or two and from linear ones, None where there is none of this kind."""
    leaves = [(i, f) for i, f in enumerate(entries) if isinstance(f, Literal) and f.op in ("<", "<=", "==")]
    strict = frozenset(i for i, f in leaves if f.op == "<")
    frames = [Frame(strict, bounds_of(leaves), {}, {})]
    frames += [f for f in (_frame(leaves, frames[0]),) if f.forms]
    for parts in _combinations(leaves):
        for frame in frames:
            found = _proof(parts, frame)
            if found is not None:
                return found
    return None


def _frame(leaves: list[tuple[int, Literal]], plain: Frame) -> Frame:
    """Linear premises in place of names without two bounds, the last premises first."""
    values: dict[str, Polynomial] = {}
    forms: dict[str, int] = {}
    for i, f in reversed(leaves):
        g = -f.polynomial.substitute(values)
        free = [v for v in g.variables if v not in plain.ends and v not in forms]
        if f.op == "==" or f.polynomial.total_degree() != 1 or not free:
            continue
        v, name = free[0], f"@{i}"
        slope = g.terms[((v, 1),)]
        value = (variable(name) - (g - variable(v).scaled(slope))).scaled(1 / slope)
        values = {n: p.substitute({v: value}) for n, p in values.items()} | {v: value}
        forms[name] = i
    return Frame(plain.strict, plain.ends, forms, values)


def _combinations(leaves: list[tuple[int, Literal]]) -> Iterator[list[Part]]:
    for i, f in leaves:
        for sign in (-1, 1) if f.op == "==" else (-1,):
            yield [(i, f, Q(sign))]
    for i, f in leaves:
        for j, g in leaves:
            if i != j and g.op != "==":
                for a in _ratios(f.polynomial, g.polynomial):
                    if f.op == "==" or a > 0:
                        yield [(i, f, -a), (j, g, Q(-1))]


def _ratios(p: Polynomial, q: Polynomial) -> Iterator[Q]:
    """Numbers a for which `a p + q` lacks one of the monomials of both."""
    seen = set[Q]()
    for m, c in q.terms.items():
        if m and m in p.terms:
            a = -c / p.terms[m]
            if a not in seen:
                seen.add(a)
                yield a
        if len(seen) > 3:
            return


def bounds_of(leaves: list[tuple[int, Literal]]) -> Bounds:
    """The tightest bounds that single inequalities give to names, of names with a lower and an upper one."""
    low: dict[str, Bound] = {}
    high: dict[str, Bound] = {}
    for i, f in leaves:
        p = f.polynomial
        if f.op != "==" and len(p.variables) == 1 and p.total_degree() == 1:
            (v,) = p.variables
            slope = p.terms[((v, 1),)]
            b = Bound(i, -p.terms.get((), Q(0)) / slope, -slope)
            if slope > 0 and (v not in high or b.end < high[v].end):
                high[v] = b
            elif slope < 0 and (v not in low or b.end > low[v].end):
                low[v] = b
    return {v: (low[v], high[v]) for v in low.keys() & high.keys() if low[v].end < high[v].end}


def _proof(parts: list[Part], frame: Frame) -> Json | None:
    """Premises times numbers (at most 0 for inequalities) and what is plainly not below 0 that add up to 0."""
    found = _groups(parts, frame)
    if found is None:
        return None
    groups, unit = found
    strict = next(((i, -q) for i, f, q in parts if f.op == "<" and q < 0), None)
    last: Json = None if strict is None else [rational_text(strict[1]), [strict[0]]]
    squares = [[rational_text(-q), [i]] for i, f, q in parts if f.op != "==" and (strict is None or i != strict[0])]
    for outer, inner in groups.items():
        products = _products(inner, unit, frame.ends)
        if products is None:
            return None
        root = factors(tuple((v, e // 2) for v, e in outer if v not in frame.forms))
        linear = [frame.forms[v] for v, e in outer if v in frame.forms for _ in range(e)]
        least = min((c for c, _, _ in products), default=Q(0))
        if last is None and not root and frame.strict.issuperset(linear) and least > 0:
            last = [rational_text(least), linear]
            inner[()] = inner.get((), 0) - least * unit
            products = _products(inner, unit, frame.ends) or []
        squares += [[[[rational_text(w), [["1", *root]]]], [*places, *linear]] for _, w, places in products if w]
    equal = [[i, [[rational_text(q)]]] for i, f, q in parts if f.op == "=="]
    return None if last is None else ["psatz", squares, equal, last]


def _groups(parts: list[Part], frame: Frame) -> tuple[dict[Monomial, Terms], int] | None:
    """Minus the sum of the parts in coordinates, by what has no two bounds; None where that is no square.

    The coefficients are over the integer that is returned beside them.
    """
    members = [(q, frame.image(f.polynomial)) for _, f, q in parts]
    unit = lcm(*(q.denominator * p.divisor for q, p in members))
    rest: dict[Monomial, int] = {}
    for q, p in members:
        factor = q.numerator * (unit // (q.denominator * p.divisor))
        for m, c in p.whole.items():
            rest[m] = rest.get(m, 0) - factor * c
    groups: dict[Monomial, Terms] = {}
    for m, c in rest.items():
        if c:
            outer = tuple([x for x in m if x[0] not in frame.ends])
            if any(e % 2 for v, e in outer if v not in frame.forms):
                return None
            groups.setdefault(outer, {})[tuple([x for x in m if x[0] in frame.ends])] = c
    groups.setdefault((), {})
    return groups, unit


def _products(inner: Terms, unit: int, ends: Bounds) -> list[tuple[Q, Q, list[int]]] | None:
    """A polynomial in bounded names as Bernstein coefficients, each with a weight and the bounds to multiply by it."""
    p = _polynomial(inner, unit)
    names = p.variables
    if not names:
        value = p.constant or Q(0)
        return None if value < 0 else [(value, value, [])]
    degrees = [p.degree(v) for v in names]
    if prod(d + 1 for d in degrees) > MOST_PRODUCTS:
        return None
    box = {v: (ends[v][0].end, ends[v][1].end) for v in names}
    flat, divisor = tensor_coefficients(p, names, box)
    found = []
    for c, powers in zip(flat, product(*(range(d + 1) for d in degrees)), strict=True):
        if c < 0:
            return None
        weight, places = Q(c, divisor), list[int]()
        for v, j, d in zip(names, powers, degrees, strict=True):
            low, high = ends[v]
            weight *= comb(d, j) / ((high.end - low.end) ** d * low.scale**j * (-high.scale) ** (d - j))
            places += [low.place] * j + [high.place] * (d - j)
        found.append((Q(c, divisor), weight, places))
    return found


def _polynomial(terms: Terms, unit: int) -> Polynomial:
    common = lcm(*(c.denominator for c in terms.values()))
    return Polynomial({m: int(c * common) for m, c in terms.items() if c}, unit * common)


def cancelled(premises: Premises) -> tuple[Formula, Json] | None:
    """An inequality without a factor that is a name above 0, if it is new, and a proof that it cannot fail."""
    leaves = [(i, f) for i, f in enumerate(premises.entries) if isinstance(f, Literal) and f.op in ("<", "<=")]
    lows = {v: low for v, (low, _) in bounds_of(leaves).items() if low.end > 0}
    for i, f in leaves:
        for v, low in lows.items():
            rest = _without(f.polynomial, v)
            if rest is None or rest.constant is not None or Literal(f.op, whole(rest)) in premises.entries:
                continue
            formula = Literal(f.op, whole(rest))
            if negation(formula) in premises.entries:
                continue
            place = len(premises.entries)  # that of the denied formula
            size = whole(rest).terms[min(rest.terms)] / rest.terms[min(rest.terms)]
            steep, flat = rational_text(1 / low.scale / size), rational_text(low.end / size)
            if f.op == "<":
                return formula, ["psatz", [[steep, [low.place, place]], [flat, [place]]], [], ["1", [i]]]
            return formula, ["psatz", [["1", [i]], [steep, [low.place, place]]], [], [flat, [place]]]
    return None


def _without(p: Polynomial, v: str) -> Polynomial | None:
    """`p / v`, where that is a polynomial."""
    if any(v not in dict(m) for m in p.whole):
        return None
    lower = {tuple((n, e - (n == v)) for n, e in m if e - (n == v)): c for m, c in p.whole.items()}
    return Polynomial(lower, p.divisor)
