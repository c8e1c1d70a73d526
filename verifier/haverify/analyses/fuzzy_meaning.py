"""What a `holds` goal about fuzzy systems says of real inputs and params, and which values those have.

A number that is not defined (a choice where no rule fires, a table outside its axis) makes no comparison true; so
every truth comes in two: where it certainly holds, and where it certainly does not.
"""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from itertools import pairwise

from haverify.analyses.fuzzy_systems import ZERO, Inputs, Systems
from haverify.analyses.regions import (
    Node,
    Truth,
    at_most,
    both,
    choice,
    combine,
    denied,
    either,
    extreme,
    linear,
    minus,
    named,
)
from haverify.model.expression import Expr
from haverify.model.fuzzy import FuzzyInput
from haverify.model.hybrid import Input, Param
from haverify.model.spec import Spec
from haverify.model.unit import Unit
from haverify.obligations.translate import OutsideFragmentError

Value = tuple[Node, Truth]  # a number, and where it is defined
Words = tuple[dict[str, Truth], Truth]  # for each value of an enumeration where it is meant, and where one is
_OPPOSITE = {"<": ">=", "<=": ">", ">": "<=", ">=": "<", "==": "!=", "!=": "=="}
_LEAVES = frozenset({"const", "param", "input", "fuzzyinput", "strength", "max_firing"})
_WANT = "a claim on fuzzy systems"


class Meaning:
    """Truths and numbers of expressions; `ranges`, `units`, `kinds` are of names met, `applied` the choices met."""

    def __init__(self, spec: Spec, on: str | None) -> None:
        self.spec, self.on = spec, on
        self.systems = Systems(spec)
        self.ranges: dict[str, tuple[Fraction, Fraction]] = {}
        self.kinds: dict[str, str] = {}
        self.units: dict[str, Unit | None] = {}
        self.applied: list[tuple[str, str, Inputs]] = []
        self._names: dict[str, Node] = {}
        self._constants = {c.name: c.value for c in spec.constants}
        self._numbers: dict[str, Fraction] = {}
        self._truths: dict[tuple[Expr, bool], Truth] = {}  # so that equal parts are one node
        self._words: dict[Expr, Words] = {}

    # ---- truths

    def truth(self, e: Expr, wanted: bool = True) -> Truth:
        """Where an expression is certainly true (certainly false, if that is wanted)."""
        if e.op in ("true", "false"):
            return (e.op == "true") is wanted
        if e.op in ("and", "or"):
            join = both if (e.op == "and") is wanted else either
            return join([self.truth(c, wanted) for c in e.children])
        if e.op == "not":
            return self.truth(e.children[0], not wanted)
        if e.op == "implies":
            join = either if wanted else both
            return join([self.truth(e.children[0], not wanted), self.truth(e.children[1], wanted)])
        if e.op == "if":
            c, a, b = e.children
            return either([both([self.truth(c), self.truth(a, wanted)]), both([self.denial(c), self.truth(b, wanted)])])
        if (e, wanted) not in self._truths:
            self._truths[e, wanted] = self._comparison(e, wanted)
        return self._truths[e, wanted]

    def denial(self, e: Expr) -> Truth:
        """Where an expression is certainly false."""
        return self.truth(e, False)

    def _comparison(self, e: Expr, wanted: bool) -> Truth:
        if e.op == "covered":
            system, word = str(e.args[0]), str(e.args[1])
            degrees = [self.systems.degree(system, word, t, self.at(system)) for t in self.systems.terms(system, word)]
            return _compared("<=", self.number(e.children[0]), (extreme("max", [ZERO, *degrees]), True), wanted)
        if e.op not in _OPPOSITE:
            raise OutsideFragmentError(f"`{e.op}` in {_WANT}")
        a, b = e.children
        if e.op in ("==", "!=") and (_is_word(a) or _is_word(b)):
            return self._same(a, b, (e.op == "==") is wanted)
        return _compared(e.op, self.number(a), self.number(b), wanted)

    def _same(self, a: Expr, b: Expr, wanted: bool) -> Truth:
        (left, known), (right, also) = self.word(a), self.word(b)
        equal = either([both([left[w], right[w]]) for w in left if w in right])
        return both([known, also, equal if wanted else denied(equal)])

    def word(self, e: Expr) -> Words:
        """The value of an enumeration that an expression stands for."""
        if e.op == "sym":
            return {str(e.args[1]): True}, True
        if e.op == "if":
            c, a, b = e.children
            yes, no = self.truth(c), self.denial(c)
            (left, known), (right, also) = self.word(a), self.word(b)
            cases = {
                w: either([both([yes, left.get(w, False)]), both([no, right.get(w, False)])]) for w in {**left, **right}
            }
            return cases, self._branched(c, known, also)
        if e.op == "fuzzy":
            if e not in self._words:
                self._words[e] = self._chosen(e)
            return self._words[e]
        raise OutsideFragmentError(f"`{e.op}` where a value of an enumeration is meant")

    def _branched(self, c: Expr, a: Truth, b: Truth) -> Truth:
        """Where a choice is defined whose numbers are defined at `a` and at `b`."""
        known = self._settled(c)
        if all(x is True or x is known for x in (a, b)):
            return known
        return either([both([self.truth(c), a]), both([self.denial(c), b])])

    def _settled(self, e: Expr) -> Truth:
        """Where an expression is certainly true or certainly false."""
        if e.op == "not":
            return self._settled(e.children[0])
        if e.op in ("==", "!=") and any(map(_is_word, e.children)):
            parts = [p for p in (self.word(c)[1] for c in e.children) if p is not True]
            return parts[0] if len(parts) == 1 else both(parts)
        if e.op in _OPPOSITE:
            return both([self.number(c)[1] for c in e.children])
        return either([self.truth(e), self.denial(e)])

    def _chosen(self, e: Expr) -> Words:
        """The strongest term, of equally strong ones the first declared; none where no rule fires."""
        name, output, given = str(e.args[0]), str(e.args[1]), e.args[2]
        assert isinstance(given, tuple)
        values = {v: self.number(x) for v, x in given}
        at = {v: x[0] for v, x in values.items()}
        if (name, output, at) not in self.applied:
            self.applied.append((name, output, at))
        terms = self.systems.outputs(name)[output]
        s = [self.systems.strength(name, output, t, at) for t in terms]
        best = self.systems.strength(name, output, None, at)
        known = both([at_most(ZERO, best, True), *(x[1] for x in values.values())])
        cases = {t: both([at_most(best, s[k]), *(at_most(u, s[k], True) for u in s[:k])]) for k, t in enumerate(terms)}
        return cases, known

    # ---- numbers

    def number(self, e: Expr) -> Value:
        """A number, and where it is defined."""
        if e.op == "num":
            return linear(Fraction(str(e.args[0]))), True
        if e.op in _LEAVES:
            return self._leaf(e), True
        if e.op == "table":
            return self._tabled(e)
        if e.op == "if":
            c, *branches = e.children
            a, b = (self.number(x) for x in branches)
            return choice(self.truth(c), a[0], b[0]), self._branched(c, a[1], b[1])
        values = [self.number(c) for c in e.children]
        return _applied(e, [v[0] for v in values]), both([v[1] for v in values])

    def _leaf(self, e: Expr) -> Node:
        if e.op in ("strength", "max_firing"):
            return self._firing(e.op, str(e.args[0]), str(e.args[1]))
        if e.op == "const":
            return linear(self._constant(e.name))
        if e.op == "fuzzyinput":
            name = str(e.args[1])
            return self._root(name, self.systems.roots(str(e.args[0]))[name])
        items: tuple[Param | Input, ...] = self.spec.params if e.op == "param" else self.spec.inputs
        item = next(i for i in items if i.name == e.name)
        if isinstance(item, Input) and item.type != "real":
            raise OutsideFragmentError(f"the input `{e.name}` is no real number")
        what = f"the range of `{e.name}`"
        ends = (item.range.low, item.range.high) if item.range else (None, None)
        return self._variable(e.op, e.name, (self._exact(ends[0], what), self._exact(ends[1], what)), item.unit)

    def _firing(self, op: str, system: str, word: str) -> Node:
        at = self.at(system)
        if op == "max_firing":
            return self.systems.strength(system, word, None, at)
        outputs = [o for o, terms in self.systems.outputs(system).items() if word in terms]
        if len(outputs) != 1:
            raise OutsideFragmentError(f"`{word}` is a term of {len(outputs)} outputs of {system}")
        return self.systems.strength(system, outputs[0], word, at)

    def _constant(self, name: str) -> Fraction:
        if name not in self._numbers:
            value = self._constants.get(name)
            self._numbers[name] = self._exact(value if isinstance(value, Expr) else None, f"the constant `{name}`")
        return self._numbers[name]

    def _exact(self, e: Expr | None, what: str) -> Fraction:
        n = self.number(e)[0] if e is not None else None
        if n is None or n.names or n.op != "lin":
            raise OutsideFragmentError(f"{what} is no exact number")
        q: Fraction = n.parts[0]
        return q

    def at(self, system: str) -> Inputs:
        """The inputs of a system as names; the claim's own system gives the ranges of those it shares."""
        return {v: self._root(v, i) for v, i in self.systems.roots(system).items()}

    def _root(self, name: str, item: FuzzyInput) -> Node:
        own = self.systems.roots(self.on).get(name, item) if self.on in self.systems.by_name and self.on else item
        if _text(own.unit) != _text(item.unit):
            raise OutsideFragmentError(f"two inputs `{name}` with different units")
        assert own.low is not None and own.high is not None, "a real input has a range"
        return self._variable("fuzzyinput", name, (own.low, own.high), own.unit)

    def _variable(self, kind: str, name: str, ends: tuple[Fraction, Fraction], unit: Unit | None) -> Node:
        if (self.kinds.setdefault(name, kind), self.ranges.setdefault(name, ends)) != (kind, ends):
            raise OutsideFragmentError(f"two things are called `{name}`")
        self.units[name] = unit
        return self._names.setdefault(name, named(name))

    def _tabled(self, e: Expr) -> Value:
        """A table's column, held or linear between the points of one axis."""
        table = next(t for t in self.spec.tables if t.name == e.args[0])
        columns = [c[0] for c in table.columns]
        column = columns.index(str(e.args[1]))
        if len(table.axes) != 1 or table.columns[column][2] is not None:
            raise OutsideFragmentError(f"table {table.name} has two axes, or tolerances")
        x, known = self.number(e.children[0])
        rows = [(r[0], r[1 + column]) for r in table.rows]
        found = linear(rows[-1][1])
        for (t, y), (u, z) in reversed(list(pairwise(rows))):
            q = (z - y) / (u - t) if table.interpolate == "linear" else Fraction(0)
            found = choice(at_most(x, linear(u), True), combine([(q, x)], y - q * t), found)
        return found, both([at_most(linear(rows[0][0]), x), at_most(x, linear(rows[-1][0])), known])


def _text(unit: Unit | None) -> str | None:
    return None if unit is None else unit.text


def _is_word(e: Expr) -> bool:
    return e.op in ("sym", "fuzzy") or (e.op == "if" and _is_word(e.children[1]))


def _compared(op: str, a: Value, b: Value, wanted: bool) -> Truth:
    op = op if wanted else _OPPOSITE[op]
    if op in (">", ">="):
        return _compared("<" + op[1:], b, a, True)
    if op in ("<", "<="):
        found = at_most(a[0], b[0], op == "<")
    else:
        sides = at_most(a[0], b[0]), at_most(b[0], a[0])
        found = both(sides) if op == "==" else either(map(denied, sides))
    return both([a[1], b[1], found])


def _applied(e: Expr, v: list[Node]) -> Node:
    """Piecewise linear functions of numbers."""
    if e.op in ("min", "max"):
        return extreme(e.op, v)
    if e.op == "+":
        return combine([(Fraction(1), n) for n in v])
    if e.op == "-":
        return minus(v[0], v[1])
    if e.op == "neg":
        return minus(ZERO, v[0])
    if e.op == "abs":
        return extreme("max", [v[0], minus(ZERO, v[0])])
    if e.op == "clamp" and at_most(v[1], v[2]) is True:
        return extreme("min", [extreme("max", v[:2]), v[2]])
    if e.op == "scale" and not e.args[1]:
        return combine([(Fraction(str(e.args[0])), v[0])])
    if e.op in ("*", "/"):
        return _multiple(e.op, v)
    raise OutsideFragmentError(f"`{e.op}` in {_WANT}")


def _multiple(op: str, v: list[Node]) -> Node:
    """A product with at most one factor that is no number, a quotient by a number."""
    q, rest = Fraction(1), []
    for k, n in enumerate(v):
        if n.op != "lin" or n.names:
            rest.append(n)
        elif op == "/" and k:
            if not n.parts[0]:
                raise OutsideFragmentError("a division by 0")
            q /= n.parts[0]
        else:
            q *= n.parts[0]
    if len(rest) > 1 or (op == "/" and rest and rest[0] is not v[0]):
        raise OutsideFragmentError(f"a product or quotient of two inputs in {_WANT}")
    return combine([(q, rest[0])]) if rest else linear(q)


def one_sided(assumed: Iterable[Truth]) -> dict[tuple[str, bool], Fraction]:
    """Bounds that assumptions set to single names: (name, is it an upper bound) to the tightest."""
    out: dict[tuple[str, bool], Fraction] = {}
    for t in assumed:
        for part in () if isinstance(t, bool) else t.parts if t.op == "and" else (t,):
            found = _bound(part)
            if found is not None:
                name, upper, q = found
                old = out.get((name, upper), q)
                out[name, upper] = min(old, q) if upper else max(old, q)
    return out


def _bound(t: Node) -> tuple[str, bool, Fraction] | None:
    if t.op != "le" or any(n.op != "lin" for n in t.parts[:2]):
        return None
    constant, terms = minus(t.parts[0], t.parts[1]).parts
    return (terms[0][0], terms[0][1] > 0, -constant / terms[0][1]) if len(terms) == 1 else None
