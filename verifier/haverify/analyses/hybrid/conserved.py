"""What flows and jumps keep: quantities whose rate is identically 0, and the linear ones among them.

The rate of a quantity is computed exactly, as a polynomial; where it is the zero polynomial in every mode, and every
reset gives the quantity back, its value at any instant is that at the start. Of linear ones all are found: they are
the null space of the rates' coefficients. A claim about such a quantity is decided by the starts; where a linear one
has one value at all starts, the range of others is intersected with what that leaves: a bound holds where it holds of
the quantity written without one of its variables.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import copy
from fractions import Fraction
from functools import cached_property

from haverify.analyses.hybrid.conditions import Atom, Condition, Every, Some, condition
from haverify.analyses.hybrid.inputs import fields
from haverify.analyses.hybrid.model import HybridModel, Start, hybrid_model
from haverify.analyses.hybrid.normal import Normal, TooLargeError
from haverify.maths.bernstein import bounds
from haverify.maths.polynomial import Polynomial, constant, total, variable
from haverify.model.claim import Claim
from haverify.model.expression import Expr
from haverify.model.hybrid import HybridAutomaton, Range
from haverify.model.spec import Spec
from haverify.text.record import field, holder, record, replace

Q = Fraction
MOST = 24  # variables
GOALS = ("always", "can_reach", "reach")
ORDERED = ("<", "<=", ">", ">=")
MORE = 4  # ways to write a quantity
FEW = 6  # of a polynomial that is not linear

Sure = tuple[Callable[[Q, Q], bool], Callable[[Q, Q], bool]]

# When a comparison of a quantity with 0 certainly holds, and certainly fails, where it has values between two.
SURE: dict[str, Sure] = {
    "<": (lambda low, high: high < 0, lambda low, high: low >= 0),
    "<=": (lambda low, high: high <= 0, lambda low, high: low > 0),
    ">": (lambda low, high: low > 0, lambda low, high: high <= 0),
    ">=": (lambda low, high: low >= 0, lambda low, high: high < 0),
    "==": (lambda low, high: low == high == 0, lambda low, high: low > 0 or high < 0),
    "!=": (lambda low, high: low > 0 or high < 0, lambda low, high: low == high == 0),
}


@record
class Law:
    """A sum of multiples of variables that all runs keep, and its least and greatest value at the starts."""

    form: Polynomial
    low: Q
    high: Q


@holder
class Conserved:
    """What the flows and jumps of an automaton keep."""

    model: HybridModel
    normal: Normal = field(default_factory=Normal)

    @cached_property
    def rates(self) -> list[dict[str, Polynomial]]:
        """For each mode the rates of what moves; params keep their values.

        Raises
        ------
        TooLargeError           if one has very many terms
        """
        found = []
        for mode, known in zip(self.model.modes, self.model.definitions, strict=True):
            rates = {n: self.normal.of(e, known) for n, e in fields(self.model, mode)[0].items()}
            found.append({**{n: p for n, p in rates.items() if p.whole}, "time": constant(1)})
        return found

    @cached_property
    def resets(self) -> list[dict[str, Polynomial]]:
        """For each edge what variables become; what is chosen from a range is a name of its own."""
        model, found = self.model, []
        names = {m.name: known for m, known in zip(model.modes, model.definitions, strict=True)}
        for k, e in enumerate(model.automaton.edges):
            if e.source in names:
                known = names[e.source]
                found.append({
                    a.var: variable(f"@chosen {k} {a.var}") if isinstance(a.to, Range) else self.normal.of(a.to, known)
                    for a in e.resets
                })  # fmt: skip
        return found

    def keeps(self, p: Polynomial) -> bool:
        """Whether a polynomial in the state has the same value all along every run."""
        if not set(p.variables) <= set(self.model.names):
            return False
        for rates in self.rates:
            if total(p.derivative(v) * rates[v] for v in p.variables if v in rates).whole:
                return False
        return all(not (p.substitute(r) - p).whole for r in self.resets if set(r) & set(p.variables))

    def alone(self, start: Start) -> Conserved:
        """The same where runs have one start only."""
        found = copy(self)
        found.model = replace(self.model, starts=(start,))
        found.__dict__.pop("laws", None)
        return found

    def at_starts(self, p: Polynomial) -> tuple[Q, Q]:
        """The least and the greatest value on boxes around all starts."""
        sides = [dict(zip(self.model.names, s.box, strict=True)) for s in self.model.starts]
        ends = [_range(p, box) for box in sides]
        return min(low for low, _ in ends), max(high for _, high in ends)

    @cached_property
    def laws(self) -> list[Law]:
        """A basis of the linear forms in what moves that are kept."""
        moving = list(dict.fromkeys(v for rates in self.rates for v in rates))
        moving += [v for v in dict.fromkeys(v for r in self.resets for v in r) if v not in moving]
        columns = [list(self._change(v)) for v in moving]
        rows = sorted({(k, m) for column in columns for k, p in enumerate(column) for m in p.terms}, key=repr)
        matrix = [[column[k].terms.get(m, Q(0)) for column in columns] for k, m in rows]
        forms = (total(variable(v).scaled(c) for v, c in zip(moving, x, strict=True) if c) for x in kernel(matrix))
        return [Law(p, *self.at_starts(p)) for p in forms]

    def _change(self, v: str) -> Iterator[Polynomial]:
        """What a variable gains: its rate in each mode, its difference at each edge."""
        for rates in self.rates:
            yield rates.get(v, constant(0))
        for r in self.resets:
            yield r.get(v, variable(v)) - variable(v)

    def simpler(self, c: Condition, number: int) -> Condition:
        """A condition on states of runs in a mode that says the same of them, decided by the starts where it is."""
        if isinstance(c, Atom):
            return self._atom(c, number)
        if isinstance(c, bool):
            return c
        members = tuple(self.simpler(m, number) for m in c.members)
        return Every(members) if isinstance(c, Every) else Some(members)

    def _atom(self, a: Atom, number: int) -> Condition:
        try:
            p = self.normal.of(a.quantity, self.model.definitions[number])
            if not p.variables or not self._is_defined(a.quantity, number):
                return a
            if self.keeps(p):
                ends = self.at_starts(p)
                holds, fails = (sure(*ends) for sure in SURE[a.op])
                return True if holds else False if fails else a
            others = self._others(p) if p.total_degree() == 1 and a.op in ORDERED else []
        except TooLargeError:
            return a
        return Some((a, *(Atom(_expression(q), a.op) for q in others))) if others else a

    def _is_defined(self, e: Expr, number: int) -> bool:
        """Whether it is a polynomial as written: other terms may have no value, also where they cancel (S1)."""
        alone = Normal()
        return set(alone.of(e, self.model.definitions[number]).variables) <= set(self.model.names) and not alone.others

    def _others(self, p: Polynomial) -> list[Polynomial]:
        """The same at all states of runs, without one of the variables, by laws with one value at all starts."""
        found = []
        for law in (w for w in self.laws if w.low == w.high):
            for m, c in law.form.terms.items():
                if m in p.terms:
                    found.append(p - (law.form - constant(law.low)).scaled(p.terms[m] / c))
        return found[:MORE]


def conserved(model: HybridModel) -> Conserved | None:
    """What an automaton keeps; None where it is too large to be looked at."""
    found = Conserved(model)
    try:
        return found if len(model.names) <= MOST and found.rates and found.resets is not None else None
    except TooLargeError:
        return None


def decides(spec: Spec, automaton: HybridAutomaton, claim: Claim) -> bool:
    """Whether what is kept says anything of a claim.

    Raises
    ------
    OutsideFragmentError    if flowpipes do not follow the automaton
    """
    model = hybrid_model(spec, automaton, [g.condition for g in claim.goals], claim.assume)
    laws = conserved(model)
    if laws is None:
        return False
    told = [(condition(model.dwelling(g.condition, k), known), k) for g in claim.goals if g.kind in GOALS
            for k, known in enumerate(model.definitions)]  # fmt: skip
    return any(laws.simpler(c, k) != c for c, k in told)


def _range(p: Polynomial, box: Mapping[str, tuple[Q, Q]]) -> tuple[Q, Q]:
    """The range on a box; exact for linear polynomials.

    Raises
    ------
    TooLargeError           if it has very many variables, and is not linear
    """
    if p.total_degree() > 1:
        if len(p.variables) > FEW:
            raise TooLargeError
        return bounds(p, box)
    low = high = p.terms.get((), Q(0))
    for m, c in p.terms.items():
        if m:
            ends = [c * q for q in box[m[0][0]]]
            low, high = low + min(ends), high + max(ends)
    return low, high


def kernel(rows: Sequence[Sequence[Q]]) -> list[list[Q]]:
    """A basis of the vectors that all rows take to 0, by exact elimination."""
    width = len(rows[0]) if rows else 0
    left, pivots = [list(r) for r in rows], list[int]()
    for column in range(width):
        at = next((k for k in range(len(pivots), len(left)) if left[k][column]), None)
        if at is None:
            continue
        top = len(pivots)
        left[top], left[at] = left[at], left[top]
        left[top] = [x / left[top][column] for x in left[top]]
        for k, r in enumerate(left):
            if k != top and r[column]:
                left[k] = [x - r[column] * y for x, y in zip(r, left[top], strict=True)]
        pivots.append(column)
    free = [c for c in range(width) if c not in pivots]
    return [
        [Q(1) if c == f else -left[pivots.index(c)][f] if c in pivots else Q(0) for c in range(width)] for f in free
    ]


def _expression(p: Polynomial) -> Expr:
    """A linear polynomial as an expression."""
    found = Expr("num", (p.terms.get((), Q(0)),))
    for m, c in sorted(p.terms.items()):
        if m:
            ((name, _),) = m
            leaf = Expr("time") if name == "time" else Expr("var", (name,))
            found = Expr("+", (found, Expr("*", (Expr("num", (c,)), leaf))))
    return found
