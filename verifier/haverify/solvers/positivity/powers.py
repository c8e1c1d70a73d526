"""High even powers that are bounded together: `sum a (x - m)^n <= r` bounds each of them, and so each square.

A literal of degree 20 is too tall for any search of identities; the bounds of the squares say almost as much, and why
they follow is an identity that can be written down.
"""

from __future__ import annotations

from fractions import Fraction

from haverify.maths.polynomial import Polynomial, constant, total, variable
from haverify.obligations.formula import Literal
from haverify.obligations.premises import whole
from haverify.solvers.positivity.identity import Identity, Squares
from haverify.text.record import record

LEAST = 4  # degree from which a literal is tall
CLOSE = 10**4


@record
class Power:
    """A summand `weight * (name - middle)^exponent`."""

    name: str
    weight: Fraction
    middle: Fraction
    exponent: int

    def root(self) -> Polynomial:
        """`name - middle`."""
        return variable(self.name) - constant(self.middle)

    def poly(self) -> Polynomial:
        """The summand."""
        return (self.root() ** self.exponent).scaled(self.weight)


def powers(p: Polynomial) -> tuple[list[Power], Fraction] | None:
    """p as a sum of even powers with positive weights less a number that is at least 0, if it is one."""
    if any(len(m) > 1 for m in p.whole):
        return None
    found = []
    for v in p.variables:
        n = p.degree(v)
        lead = p.terms[((v, n),)]
        if n % 2 or lead <= 0:
            return None
        found.append(Power(v, lead, -p.terms.get(((v, n - 1),), Fraction(0)) / (n * lead), n))
    radius = -p.value({q.name: q.middle for q in found})
    if radius < 0 or total(q.poly() for q in found) - constant(radius) != p:
        return None
    return found, radius


def is_tall(q: Literal) -> bool:
    """Whether the literal bounds powers higher than squares."""
    return q.op in ("<", "<=") and q.polynomial.total_degree() >= LEAST and powers(q.polynomial) is not None


def lowered(q: Literal) -> list[Literal]:
    """The bounds of the squares that follow from a tall literal; any other literal alone."""
    known = powers(q.polynomial) if q.op in ("<", "<=") and q.polynomial.total_degree() >= LEAST else None
    if known is None:
        return [q]
    return [Literal("<=", whole(s.root() ** 2 - constant(_most(s, known[1])))) for s in known[0]]


def _most(s: Power, radius: Fraction) -> Fraction:
    """A rational above the greatest square of the root that the radius allows."""
    square = Fraction((float(radius / s.weight)) ** (2 / s.exponent))
    bound = Fraction(int(square * CLOSE) + 1, CLOSE)
    while s.weight * bound ** (s.exponent // 2) < radius:
        bound += Fraction(1, CLOSE)
    return bound


def why(entries: tuple[object, ...], place: int, denied: int, k: int) -> Identity:
    """Why the tall literal at a place excludes the negation of its bound number k, which is the entry `denied`."""
    tall, wrong = entries[place], entries[denied]
    assert isinstance(tall, Literal) and isinstance(wrong, Literal)
    known = powers(tall.polynomial)
    assert known is not None
    summands, radius = known
    s, half = summands[k], summands[k].exponent // 2
    bound = _most(s, radius)
    size = (
        next(iter(wrong.polynomial.terms.values()))
        / (constant(bound) - s.root() ** 2).terms[next(iter(wrong.polynomial.terms))]
    )
    cones: list[tuple[Squares, tuple[int, ...]]] = [(((Fraction(1), constant(1)),), (place,))]
    others = [(q.weight, q.root() ** (q.exponent // 2)) for q in summands if q is not s]
    others += [(s.weight * bound**half - radius, constant(1))]
    cones.append((tuple(o for o in others if o[0]), ()))
    rest = [(s.weight * bound ** (half - 1 - j) / size, s.root() ** j) for j in range(1, half)]
    cones.append((tuple(rest), (denied,)))
    kept = tuple(c for c in cones if c[0])
    return Identity(kept, (), s.weight * bound ** (half - 1) / size, (denied,))
