"""Params in claims without time: values under which all that is assumed holds, values that refute, proofs on boxes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import islice, product

from haverify.analyses.bounds import Interval, narrow
from haverify.analyses.clock_model import PI
from haverify.analyses.placement import Tree
from haverify.analyses.poly_range import Ranges, Work, prove
from haverify.maths.polynomial import Polynomial, constant, variable
from haverify.model.expression import Expr
from haverify.model.hybrid import Param
from haverify.model.spec import Spec
from haverify.obligations.constants import Values, values_of
from haverify.obligations.denial import denial
from haverify.obligations.formula import Formula, conjunction, disjunction
from haverify.obligations.formula import variables as variables_of
from haverify.obligations.translate import Scope
from haverify.solvers.finite_truth import Finite
from haverify.solvers.finite_world import NotFiniteError, World

Q = Fraction
Point = dict[str, Q]
MOST_POINTS = 4_000


def ranges_of(spec: Spec, on: str | None) -> dict[str, tuple[Q, Q]]:
    """The range of each param that a claim can read; ends that other params decide are outside the fragment."""
    values = _values(spec, on)
    return {p.name: values.interval(p.range) for p in _params(spec, on)}


def admissible(spec: Spec, on: str | None, assumed: Sequence[Expr], always: bool = False) -> Point | None:
    """Values of all params under which everything assumed holds; {} where nothing is assumed, unless `always`."""
    if not assumed and not always:
        return {}
    return next((p for p in points(spec, on) if _holds(spec, on, p, assumed)), None)


def tried(spec: Spec, on: str | None, assumed: Sequence[Expr], e: Expr) -> tuple[bool | None, Point]:
    """False, or None, with values of all params for which `e` is false, or undefined; True where none was found."""
    lacking: Point = {}
    try:
        for point in points(spec, on):
            if _holds(spec, on, point, assumed):
                truth = Finite(World(spec, on, point)).truth(e, {})
                if truth is False:
                    return False, point
                lacking = lacking or (point if truth is None else {})
    except NotFiniteError:
        return True, {}
    return (None if lacking else True), lacking


def points(spec: Spec, on: str | None) -> Iterator[Point]:
    """Points of the box to try: the defaults or middle first, then a grid that gets finer with fewer params."""
    ranges = ranges_of(spec, on)
    values = _values(spec, on)
    usual = {}
    for p in _params(spec, on):
        low, high = ranges[p.name]
        given = values.number(p.default) if p.default is not None else None
        usual[p.name] = given if given is not None and low <= given <= high else (low + high) / 2
    yield usual
    steps = next((k for k in (101, 41, 21, 11, 6, 5, 3) if k ** len(ranges) <= MOST_POINTS), 2)
    axes = [[low + (high - low) * k / (steps - 1) for k in range(steps)] for low, high in ranges.values()]
    yield from islice((dict(zip(ranges, c, strict=True)) for c in product(*axes)), MOST_POINTS)


def shown_on_boxes(spec: Spec, on: str | None, assumed: Sequence[Expr], e: Expr, units: int) -> Tree | None:
    """A tree that shows `e`, or that something assumed fails, on the whole box of the params."""
    ranges = ranges_of(spec, on)
    scope = _scope(spec, on, {p: variable(p) for p in ranges}, ranges)
    f = disjunction([scope.formula(e), *(scope.formula(denial(a)) for a in assumed)])
    return _tree(f, _narrowed(conjunction(scope.formula(a) for a in assumed), ranges), units)


def _narrowed(assumed: Formula, ranges: dict[str, tuple[Q, Q]]) -> dict[str, tuple[Q, Q]]:
    """The ranges, cut to what is assumed of each param alone; the checker cuts them likewise."""
    found = dict(ranges)
    for p, x in (narrow(assumed, {p: Interval(*ends) for p, ends in ranges.items()}, {}) or {}).items():
        if x.low is not None and x.high is not None:
            found[p] = (x.low, x.high)
    return found


def denied_at(spec: Spec, on: str | None, point: Point, e: Expr, units: int) -> Tree | None:
    """A tree that shows `e` false for the params given, whatever pi is within its enclosure."""
    scope = _scope(spec, on, {p: constant(q) for p, q in point.items()}, ranges_of(spec, on))
    return _tree(scope.formula(denial(e)), {}, units)


def _tree(f: Formula, ranges: Mapping[str, tuple[Q, Q]], units: int) -> Tree | None:
    box = {n: ends for n, ends in {**ranges, "pi": PI}.items() if n in variables_of(f)}
    return prove(f, box, Ranges(), Work(units))


def _params(spec: Spec, on: str | None) -> tuple[Param, ...]:
    own = [a.params for a in spec.automata if a.name == on]
    return (*spec.params, *(p for group in own for p in group))


def _values(spec: Spec, on: str | None) -> Values:
    automaton = next((a for a in spec.automata if a.name == on), None)
    return values_of(spec, automaton)


def _scope(spec: Spec, on: str | None, named: dict[str, Polynomial], ranges: dict[str, tuple[Q, Q]]) -> Scope:
    values = _values(spec, on)
    return Scope("the claim", named, {}, values.constant, values.symbol, frozenset(), {}, box={**ranges, "pi": PI})


def _holds(spec: Spec, on: str | None, point: Point, assumed: Sequence[Expr]) -> bool:
    return all(Finite(World(spec, on, point)).truth(a, {}) is True for a in assumed)
