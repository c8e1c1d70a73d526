"""Exact points that satisfy conditions: admissible starts, and states for counterexamples to induction."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from fractions import Fraction
from itertools import islice, product

from haverify.analyses.induction.boxes import bounded, enclosed
from haverify.analyses.synthesis.starts import exact_points
from haverify.maths.bernstein import bounds
from haverify.maths.polynomial import Polynomial, constant
from haverify.obligations.formula import HOLDS, Formula, Junction, Literal, by_bounds, truth
from haverify.obligations.functions import Functions
from haverify.obligations.induction import names_of
from haverify.obligations.premises import Premises
from haverify.text.record import record

Q = Fraction
Point = dict[str, Q]
FIRST_TRIES, TRIES = 200, 4000
MANY = 8  # names: more than a grid can search
HALVINGS, FAR = 40, Q(1000)  # for points at the border
FEW = (Q(0), Q(1), Q(-1), Q(2), Q(-2), Q(1, 2), Q(-1, 2), Q(10), Q(-10))


def satisfying(premises: Premises, names: Iterable[str], tries: int = TRIES) -> Point | None:
    """Values of the names for which all entries certainly hold; None where none was found."""
    wanted = sorted(names)
    for limit in sorted({min(FIRST_TRIES, tries), tries}):
        for solved in _cases(premises):
            found = _search(solved, premises, wanted, limit)
            if found is not None:
                return found
        found = next(exact_points(premises.entries, wanted), None) if not premises.functions.known else None
        if found is not None or len(wanted) > MANY:
            return found
    return None


@record
class _Solved:
    """Premises without the names that equations give, and these, in the order they were taken."""

    left: Premises
    given: tuple[tuple[str, Polynomial], ...]


def _cases(premises: Premises) -> Iterator[_Solved]:
    """The premises with equations used up, one for each choice among disjunctions (a few)."""
    from haverify.analyses.induction.refute import solvable

    given: list[tuple[str, Polynomial]] = []
    put = solvable(premises)
    while put is not None:
        _, name, value = put
        given.append((name, value))
        premises = premises.mapped({name: value})
        put = solvable(premises)
    if False in premises.entries:
        return
    split = next(
        (f for f in premises.entries if isinstance(f, Junction) and not f.is_and and _is_new(premises, f)), None
    )
    if split is None:
        yield _Solved(premises, tuple(given))
        return
    for m in split.members:
        for inner in _cases(premises.with_(m)):
            yield _Solved(inner.left, (*given, *inner.given))


def _is_new(premises: Premises, f: Junction) -> bool:
    known = set(premises.entries)
    return not any(set(premises.with_(m).entries) <= known for m in f.members)


def _search(solved: _Solved, premises: Premises, names: list[str], tries: int) -> Point | None:
    free = [n for n in names if n not in dict(solved.given)]
    alone = {n: [f for f in premises.entries if names_of(f) == {n}] for n in free}
    others = [f for f in premises.entries if not any(f in found for found in alone.values())]
    others.sort(key=lambda f: (not premises.functions.known.keys().isdisjoint(names_of(f)), len(names_of(f))))
    choices = [
        [(k, q, all(certainly(f, {n: q}, premises.functions) for f in alone[n])) for k, q in enumerate(values)]
        for n, values in ((n, _candidates(n, solved.left.entries)) for n in free)
    ]
    tried = [c for c in islice(product(*choices), tries) if all(fits for _, _, fits in c)]
    for choice in sorted(tried, key=lambda c: sum(k for k, _, _ in c)):
        point = dict(zip(free, (q for _, q, _ in choice), strict=True))
        for name, value in reversed(solved.given):
            q = value.fix(point).constant
            if q is None:
                break
            point[name] = q
        else:
            if all(certainly(f, point, premises.functions) for f in others):
                return {n: point[n] for n in names}
    return None


def _candidates(name: str, entries: Iterable[Formula]) -> list[Q]:
    """Values worth trying: inside the bounds, at the vertices of parabolas, simple numbers."""
    found = list(entries)
    box = bounded(found) or {}
    values = list[Q]()
    if name in box:
        low, high = box[name]
        values += [(low + high) / 2, *(low + (high - low) * Q(k, 8) for k in (1, 7, 3, 5)), low, high]
    for f in found:
        if isinstance(f, Literal):
            p = f.polynomial
            square, line = p.terms.get(((name, 2),), Q(0)), p.terms.get(((name, 1),), Q(0))
            if square:
                values += [-line / (2 * square), -line / (2 * square) + Q(1, 8), -line / (2 * square) - Q(1, 8)]
            elif line:
                end = -p.terms.get((), Q(0)) / line
                values += [end, end + Q(1, 4), end - Q(1, 4)]
    kept = dict.fromkeys([*values, *FEW])
    if name in box:
        kept = {q: None for q in kept if box[name][0] <= q <= box[name][1]}
    return list(kept)[:12]


def certainly(f: Formula, point: Mapping[str, Q], functions: Functions) -> bool:
    """Whether a formula holds at a point, functions enclosed there."""

    def known(leaf: Literal) -> bool | None:
        if all(v in point for v in leaf.polynomial.variables):
            return HOLDS[leaf.op](leaf.polynomial.value(point))
        box = {n: (q, q) for n, q in point.items()}
        found = by_bounds(leaf.op, *bounds(leaf.polynomial.fix(point), enclosed(functions, [leaf], box)))
        if found is not None:
            return found
        p = functions.substitute(leaf.polynomial, {n: constant(q) for n, q in point.items()})
        return by_bounds(leaf.op, *bounds(p, enclosed(functions, [Literal(leaf.op, p)], box)))

    return truth(f, known) is True


def farthest(premises: Premises, first: Point, names: Iterable[str]) -> Iterator[Point]:
    """A point that satisfies premises, and those farthest from it along each axis that still do."""
    yield first
    for v in names:
        read = [f for f in premises.entries if v in premises.functions.support(names_of(f))]
        for sign in (1, -1):
            inside, outside = Q(0), FAR
            for _ in range(HALVINGS):
                middle = (inside + outside) / 2
                there = {**first, v: first[v] + sign * middle}
                is_inside = all(certainly(f, there, premises.functions) for f in read)
                inside, outside = (middle, outside) if is_inside else (inside, middle)
            if inside:
                yield {**first, v: first[v] + sign * inside}


def exactly(premises: Premises, names: Iterable[str]) -> dict[str, Polynomial] | None:
    """Values of the names, polynomials in pi and functions of numbers, for which all entries certainly hold."""
    wanted = sorted(names)
    for solved in _cases(premises):
        free = [n for n in wanted if n not in dict(solved.given)]
        choices = [_candidates(n, solved.left.entries) for n in free]
        for choice in islice(product(*choices), FIRST_TRIES):
            point = {n: constant(q) for n, q in zip(free, choice, strict=True)}
            for name, value in reversed(solved.given):
                point[name] = premises.functions.substitute(value, point)
            if _are_numbers(point.values(), premises.functions) and _hold(premises, point):
                return {n: point[n] for n in wanted}
    return None


def _are_numbers(values: Iterable[Polynomial], functions: Functions) -> bool:
    read = {n for p in values for n in p.variables}
    return set(functions.support(read)) <= {"pi"} and not any(
        op != "sqrt" and a.constant is not None and a.constant <= 0 for p in values for op, a in functions.partial(p)
    )


def _hold(premises: Premises, point: Mapping[str, Polynomial]) -> bool:
    """Whether all entries certainly hold at a point that is known exactly."""

    def known(leaf: Literal) -> bool | None:
        p = premises.functions.substitute(leaf.polynomial, point)
        return by_bounds(leaf.op, *bounds(p, enclosed(premises.functions, [Literal(leaf.op, p)], {})))

    return all(truth(f, known) is True for f in premises.entries)
