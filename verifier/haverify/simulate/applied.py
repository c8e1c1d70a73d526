"""Fuzzy systems and interpolated tables as expressions of their arguments, for runs in floats.

Degrees, strengths and choices mean what they mean in claims (analyses/fuzzy_systems.py), built of expressions here: the
arguments of a flow are no linear functions of a box. Where no rule fires the choice is no value of its enumeration;
outside of its axes a table has no value.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import pairwise

from haverify.model.expression import Expr, number
from haverify.model.fuzzy import FuzzyController, Term
from haverify.model.spec import Spec
from haverify.model.tables import DataTable
from haverify.obligations.translate import OutsideFragmentError

Numbers = Mapping[tuple[str, str], Fraction]
Given = Mapping[str, Expr]

ZERO, ONE, NONE = number(0), number(1), number(-1)
NOTHING = Expr("/", (ZERO, ZERO))
DEPTH = 50  # systems in a chain


class Applied:
    """What `fuzzy` and `table` nodes stand for; `symbols` numbers the values of enumerations."""

    def __init__(self, spec: Spec, symbols: Numbers) -> None:
        self.systems = {f.name: f for f in spec.fuzzy}
        self.tables = {t.name: t for t in spec.tables}
        self.symbols = symbols

    def __call__(self, e: Expr) -> Expr:
        """The expression of numbers that an application stands for.

        Raises
        ------
        OutsideFragmentError    if the logic of a system or the tolerance of a table is not one number
        """
        if e.op == "table":
            return tabled(self.tables[str(e.args[0])], str(e.args[1]), e.children)
        name, output, given = str(e.args[0]), str(e.args[1]), e.args[2]
        assert isinstance(given, tuple)
        return self._chosen(name, output, dict(given))

    def _chosen(self, name: str, output: str, given: Given) -> Expr:
        """The strongest term, of equally strong ones the first declared."""
        terms = dict(self._system(name).outputs)[output]
        s = [self._strength(name, output, t, given, 0) for t in terms]
        best = s[0] if len(s) == 1 else Expr("max", tuple(s))
        found = NONE
        for term, strength in reversed(list(zip(terms, s, strict=True))):
            is_best = Expr("and", (Expr(">=", (strength, best)), Expr(">", (strength, ZERO))))
            found = Expr("if", (is_best, number(self._number(terms, term)), found))
        return found

    def _number(self, terms: Sequence[str], term: str) -> Fraction:
        """The number of a term in the enumeration that has all of them."""
        named = dict.fromkeys(enum for enum, _ in self.symbols)
        for enum in named:
            if all((enum, t) in self.symbols for t in terms):
                return self.symbols[enum, term]
        return Fraction(terms.index(term))

    def _system(self, name: str) -> FuzzyController:
        found = self.systems[name]
        if found.logic != ("min", "max"):
            raise OutsideFragmentError(f"`logic {' '.join(found.logic)}` of {name}: inference by min and max is run")
        return found

    def _strength(self, name: str, output: str, term: str, given: Given, depth: int) -> Expr:
        rules = [r for r in self._system(name).rules if (r.output, r.term) == (output, term)]
        if depth > DEPTH:
            raise OutsideFragmentError(f"more than {DEPTH} fuzzy systems in a chain")
        found = [self._premise(name, r.premise, given, depth) for r in rules]
        return ZERO if not found else found[0] if len(found) == 1 else Expr("max", tuple(found))

    def _premise(self, name: str, e: Expr, given: Given, depth: int) -> Expr:
        if e.op == "is":
            return self._degree(name, str(e.args[0]), str(e.args[1]), given, depth)
        parts = tuple(self._premise(name, c, given, depth) for c in e.children)
        return Expr("-", (ONE, *parts)) if e.op == "not" else Expr("min" if e.op == "and" else "max", parts)

    def _degree(self, name: str, word: str, term: str, given: Given, depth: int) -> Expr:
        asked = next(i for i in self._system(name).inputs if i.name == word)
        if asked.source is not None:
            return self._strength(asked.source[0], asked.source[1], term, given, depth + 1)
        return membership(next(t for t in asked.terms if t.name == term), given[word])


def membership(term: Term, x: Expr) -> Expr:
    """How far a number belongs to a term."""
    corners = list(term.corners)
    if term.shape == "ramp":
        return _slope(x, corners[0], corners[1])
    a, b, c, d = {1: corners * 4, 3: [*corners[:2], *corners[1:]], 4: corners}[len(corners)]
    falling = Expr("if", (Expr("<=", (x, number(c))), ONE, ZERO)) if c == d else _slope(x, d, c)
    return Expr("min", (_slope(x, a, b), falling))


def _slope(x: Expr, zero: Fraction, one: Fraction) -> Expr:
    """0 up to one corner and 1 from the other on; a step belongs to the 1."""
    if zero == one:
        return Expr("if", (Expr(">=", (x, number(zero))), ONE, ZERO))
    share = Expr("*", (number(1 / (one - zero)), Expr("-", (x, number(zero)))))
    return Expr("clamp", (share, ZERO, ONE))


def tabled(table: DataTable, column: str, at: Sequence[Expr]) -> Expr:
    """A column of a table at its axes' values: held, or linear between neighbours along each axis."""
    index = [c[0] for c in table.columns].index(column)
    if table.columns[index][2] is not None:
        raise OutsideFragmentError(f"the column `{column}` of table {table.name} has a tolerance")
    axes = len(table.axes)
    values = {r[:axes]: number(r[axes + index]) for r in table.rows}
    return _along(table, values, at)


def _along(table: DataTable, values: Mapping[tuple[Fraction, ...], Expr], at: Sequence[Expr]) -> Expr:
    """Values at the points of some axes, read along the first one of them after the others."""
    if not at:
        return values[()]
    points: dict[Fraction, dict[tuple[Fraction, ...], Expr]] = {}
    for place, value in values.items():
        points.setdefault(place[0], {})[place[1:]] = value
    knots = [(x, _along(table, rest, at[1:])) for x, rest in sorted(points.items())]
    found, x = knots[-1][1], at[0]
    for (t, y), (u, z) in reversed(list(pairwise(knots))):
        part = Expr("*", (number(1 / (u - t)), Expr("-", (x, number(t)))))
        here = Expr("+", (y, Expr("*", (part, Expr("-", (z, y)))))) if table.interpolate == "linear" else y
        found = Expr("if", (Expr("<", (x, number(u))), here, found))
    inside = Expr("and", (Expr(">=", (x, number(knots[0][0]))), Expr("<=", (x, number(knots[-1][0])))))
    return Expr("if", (inside, found, NOTHING))
