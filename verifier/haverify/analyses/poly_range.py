"""Proofs that a formula holds on a box: trees of Bernstein signs, splits, eliminations and exact one-variable leaves.

`prove` never lies: what it returns is a certificate that a second program replays, and None means only that
no proof was found within the budget, which is counted in units of work and not in seconds.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from itertools import product
from math import gcd

from haverify.analyses.placement import Tree
from haverify.maths import sturm
from haverify.maths.bernstein import bounds, coefficients
from haverify.maths.polynomial import Monomial, Polynomial
from haverify.maths.univariate import Integers, primitive
from haverify.obligations.formula import (
    HOLDS,
    Formula,
    Junction,
    Literal,
    by_bounds,
    conjunction,
    disjunction,
    holds,
    literal,
    literals,
    truth,
    variables,
)
from haverify.text.record import field, holder

Q = Fraction
Box = Mapping[str, tuple[Q, Q]]
ENOUGH = 4_000
MANY = 3  # variables beyond which linear ones are eliminated before signs are read off
WIDE = 5  # variables beyond which boxes are not split
DEEPEST = 30  # splits and eliminations on one path of a tree


@holder
class Work:
    """A budget of elementary steps; spending more than is left says so."""

    left: int = ENOUGH

    def spend(self, units: int) -> bool:
        """Whether there was that much left."""
        self.left -= units
        return self.left >= 0


@holder
class Profile:
    """The range of a polynomial without constant term on an interval: Bernstein bounds at once, extremes when asked."""

    coefficients: Integers
    ends: tuple[Q, Q]
    low: Q
    high: Q
    found: tuple[sturm.Extreme, sturm.Extreme] | None = None

    def extremes(self) -> tuple[sturm.Extreme, sturm.Extreme]:
        """Least and greatest value."""
        if self.found is None:
            self.found = sturm.extremes(self.coefficients, *self.ends)
        return self.found


@holder
class Ranges:
    """Profiles that were computed before: bounds of one output share theirs, whatever the numbers they compare with."""

    known: dict[tuple[Integers, Q, Q], Profile] = field(default_factory=dict)

    def profile(self, p: Polynomial, ends: tuple[Q, Q]) -> tuple[Profile, Q, Q]:
        """`(profile, a, b)` with `p = a * profiled + b`; `p` has exactly one variable."""
        dense = p.dense()
        offset, dense[0] = Q(dense[0], p.divisor), 0
        common = gcd(*dense) if dense[-1] > 0 else -gcd(*dense)
        whole, scale = tuple(c // common for c in dense), Q(common, p.divisor)
        key = (whole, *ends)
        if key not in self.known:
            b, d = coefficients(whole, *ends)
            self.known[key] = Profile(whole, ends, Q(min(b), d), Q(max(b), d))
        return self.known[key], scale, offset

    def bounds(self, p: Polynomial, box: Box) -> tuple[Q, Q]:
        """The range of `p` on the box, by Bernstein coefficients."""
        names = p.variables
        if len(names) != 1:
            return bounds(p, box)
        profile, a, b = self.profile(p, box[names[0]])
        return (a * profile.low + b, a * profile.high + b) if a > 0 else (a * profile.high + b, a * profile.low + b)

    def extremes(self, p: Polynomial, box: Box) -> tuple[sturm.Extreme, sturm.Extreme]:
        """Least and greatest value of a polynomial in one variable on the box."""
        profile, a, b = self.profile(p, box[p.variables[0]])
        low, high = (_scaled(e, a, b) for e in profile.extremes())
        return (low, high) if a > 0 else (high, low)

    def sign(self, p: Polynomial, box: Box) -> int | None:
        """A sign that `p` has on the whole box (zero counts as either): exact in one variable, else by bounds."""
        low, high = self.bounds(p, box)
        if low < 0 < high and len(p.variables) == 1:
            least, greatest = self.extremes(p, box)
            low, high = least.low, greatest.high
        return 1 if low >= 0 else -1 if high <= 0 else None


def _scaled(e: sturm.Extreme, a: Q, b: Q) -> sturm.Extreme:
    if e.exact:
        value = a * e.low + b
        return sturm.Extreme(value, value, e.at, True)
    ends = (a * e.low + b, a * e.high + b)
    return sturm.Extreme(min(ends), max(ends), e.at, e.exact)


def prove(f: Formula, box: Box, ranges: Ranges, work: Work, depth: int = DEEPEST) -> Tree | None:
    """A tree that shows `f` on the whole box, or None."""
    if depth == 0 or not work.spend(1 + sum(len(leaf.polynomial.whole) for leaf in literals(f)) // 8):
        return None
    names = sorted(variables(f))
    known = (
        truth(f, lambda leaf: by_bounds(leaf.op, *ranges.bounds(leaf.polynomial, box))) if len(names) <= MANY else None
    )
    if known is not None:
        return "b" if known else None
    if len(names) == 1:
        return "u" if always(f, names[0], box[names[0]], ranges) else None
    if _fails_somewhere(f, names, box):
        return None
    gone, rest = eliminated(f, names, box, ranges)
    if gone:
        inner = prove(rest, box, ranges, work, depth - 1)
        if inner is not None or not _entangled(f, set(gone)):
            return None if inner is None else ["e", gone, inner]
    return _split(f, names, box, ranges, work, depth) if len(names) <= WIDE else None


def surely(f: Formula, box: Box, ranges: Ranges) -> bool:
    """Whether `f` holds on the box by worst ends and signs alone; a literal without a worst end counts as false."""
    for v in sorted(variables(f)):
        f = _worst_or_false(f, v, box, ranges)
    return truth(f, lambda leaf: by_bounds(leaf.op, *ranges.bounds(leaf.polynomial, box))) is True


def _worst_or_false(f: Formula, v: str, box: Box, ranges: Ranges) -> Formula:
    if isinstance(f, Junction):
        return (conjunction if f.is_and else disjunction)([_worst_or_false(m, v, box, ranges) for m in f.members])
    worst = at_worst(f, v, box, ranges)
    return False if worst is None else worst


def _entangled(f: Formula, gone: set[str]) -> bool:
    """Whether some alternatives share an eliminated variable: then their worst ends need not occur together."""
    if not isinstance(f, Junction):
        return False
    if f.is_and:
        return any(_entangled(m, gone) for m in f.members)
    return sum(bool(variables(m) & gone) for m in f.members) > 1 or any(_entangled(m, gone) for m in f.members)


def _split(f: Formula, names: list[str], box: Box, ranges: Ranges, work: Work, depth: int) -> Tree | None:
    v = _widest(f, names, box, ranges)
    low, high = box[v]
    middle = simple_between(low, high)
    left = prove(f, {**box, v: (low, middle)}, ranges, work, depth - 1)
    if left is None:
        return None
    right = prove(f, {**box, v: (middle, high)}, ranges, work, depth - 1)
    return None if right is None else ["s", v, middle, left, right]


def simple_between(low: Q, high: Q) -> Q:
    """A rational near the middle, with a short denominator."""
    width = high - low
    power = 1
    while power * width < 8:
        power *= 2
    middle = Q(round((low + high) / 2 * power), power)
    return middle if low < middle < high else (low + high) / 2


def _fails_somewhere(f: Formula, names: list[str], box: Box) -> bool:
    """Whether `f` is false at the middle or in a corner of the box."""
    middle = {v: (box[v][0] + box[v][1]) / 2 for v in names}
    if not holds(f, middle):
        return True
    corners = product(*(box[v] for v in names)) if len(names) <= 4 else ()
    return any(not holds(f, dict(zip(names, corner, strict=True))) for corner in corners)


def _widest(f: Formula, names: list[str], box: Box, ranges: Ranges) -> str:
    """The variable along which the undecided literals vary most."""
    weight = dict.fromkeys(names, Q(0))
    for leaf in literals(f):
        if by_bounds(leaf.op, *ranges.bounds(leaf.polynomial, box)) is None:
            for v in leaf.polynomial.variables:
                low, high = ranges.bounds(leaf.polynomial.derivative(v), box)
                weight[v] += max(abs(low), abs(high)) * (box[v][1] - box[v][0])
    return max(names, key=lambda v: (weight[v], v))


def eliminated(f: Formula, names: list[str], box: Box, ranges: Ranges) -> tuple[list[str], Formula]:
    """The variables in which every literal is linear with a coefficient of one sign, and `f` at the worst
    ends of them."""
    ends = {leaf: worst_ends(leaf, box, ranges) for leaf in literals(f)}
    gone = [v for v in names if all(v in ends[leaf] or v not in leaf.polynomial.variables for leaf in ends)]
    if gone:
        kept = set(gone)
        f = replaced(f, lambda leaf: leaf.polynomial.fix({v: x for v, x in ends[leaf].items() if v in kept}))
    for v in names:
        if v not in gone:
            worst = at_worst(f, v, box, ranges)
            if worst is not None:
                gone.append(v)
                f = worst
    return gone, f


def worst_ends(leaf: Literal, box: Box, ranges: Ranges) -> dict[str, Q]:
    """The ends that are worst for an inequality, of variables that no term has two of and whose cofactor has one sign.

    All of them at once: the cofactor of one does not depend on the others.
    """
    if leaf.op not in ("<", "<="):
        return {}
    ends: dict[str, Q] = {}
    for v, cofactor in _shares(leaf.polynomial).items():
        sign = _sign(cofactor, box, ranges)
        if sign is not None:
            ends[v] = box[v][1] if sign >= 0 else box[v][0]
    return ends


def _sign(cofactor: Mapping[Monomial, int], box: Box, ranges: Ranges) -> int | None:
    """A sign that the polynomial has on the whole box (zero counts as either), None where none is certain."""
    if len(cofactor) == 1:
        ((m, c),) = cofactor.items()
        if all(box[v][0] >= 0 for v, _ in m):
            return 1 if c > 0 else -1
    return ranges.sign(Polynomial(cofactor), box)


def _shares(p: Polynomial) -> dict[str, dict[Monomial, int]]:
    """The cofactors, times the divisor, of variables that occur linearly: of each term at most one variable."""
    found: dict[str, dict[Monomial, int]] = {}
    for m, c in p.whole.items():
        for v, _ in m:
            found.setdefault(v, {})[m] = c
    taken: dict[str, dict[Monomial, int]] = {}
    for v in sorted(found, key=lambda name: (len(found[name]), name)):
        if not any((x[0] == v and x[1] > 1) or x[0] in taken for m in found[v] for x in m):
            taken[v] = {tuple(x for x in m if x[0] != v): c for m, c in found[v].items()}
    return taken


def replaced(f: Formula, change: Callable[[Literal], Polynomial]) -> Formula:
    """The formula with each literal's polynomial changed, constants folded."""
    if isinstance(f, Literal):
        return literal(f.op, change(f))
    if isinstance(f, Junction):
        return (conjunction if f.is_and else disjunction)([replaced(m, change) for m in f.members])
    return f


def at_worst(f: Formula, v: str, box: Box, ranges: Ranges) -> Formula | None:
    """The formula with each literal at the end of `v` that is worst for it, None where one has no such end."""
    if isinstance(f, bool):
        return f
    if isinstance(f, Junction):
        members: list[Formula] = []
        for m in f.members:
            changed = at_worst(m, v, box, ranges)
            if changed is None:
                return None
            members.append(changed)
        return (conjunction if f.is_and else disjunction)(members)
    end = worst_end(f, v, box, ranges)
    return f if end is None else None if end is NOWHERE else literal(f.op, f.polynomial.fix({v: end}))


NOWHERE = Q(0, 1)  # compared by identity: no end is the worst


def worst_end(leaf: Literal, v: str, box: Box, ranges: Ranges) -> Q | None:
    """The end of `v` at which the literal is hardest to satisfy; None where it does not mention `v`,
    NOWHERE if unclear."""
    parts = leaf.polynomial.coefficients(v)
    if len(parts) == 1:
        return None
    if len(parts) > 2 or leaf.op not in ("<", "<="):
        return NOWHERE
    sign = ranges.sign(parts[1], box)
    return NOWHERE if sign is None else box[v][1] if sign > 0 else box[v][0]


def always(f: Formula, v: str, ends: tuple[Q, Q], ranges: Ranges) -> bool:
    """Whether a formula in one variable holds on the whole interval: exact."""
    if isinstance(f, Junction) and f.is_and:
        return all(always(m, v, ends, ranges) for m in f.members)
    if isinstance(f, Literal):
        quick = _by_extremes(f, v, ends, ranges)
        if quick is not None:
            return quick
    return first_failure(f, ends) is None


def _by_extremes(f: Literal, v: str, ends: tuple[Q, Q], ranges: Ranges) -> bool | None:
    low, high = ranges.extremes(f.polynomial, {v: ends})
    if f.op in ("<", "<="):
        worst = by_bounds(f.op, high.low, high.high)
        return None if worst is None else worst
    return by_bounds(f.op, low.low, high.high)


def first_failure(f: Formula, ends: tuple[Q, Q]) -> sturm.Piece | None:
    """The first place in the interval where a formula in one variable is false, None where it holds throughout."""
    return next((x for x, good in pieces(f, ends) if not good), None)


def pieces(f: Formula, ends: tuple[Q, Q]) -> list[tuple[sturm.Piece, bool]]:
    """The points and open pieces on which the formula does not change, in order, each with its truth:
    exact, complete."""
    leaves = list(dict.fromkeys(literals(f)))
    dense = [primitive(leaf.polynomial.dense()) for leaf in leaves]
    result = []
    for piece in sturm.sign_vectors(dense, *ends):
        known = {leaf: HOLDS[leaf.op](Q(sign)) for leaf, sign in zip(leaves, piece.signs, strict=True)}
        result.append((piece, truth(f, known.__getitem__) is True))
    return result
