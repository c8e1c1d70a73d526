"""Fuzzy systems as functions of their real inputs: degrees of terms and strengths of rules, exact.

Inference is by min and max, terms are piecewise linear; so every number is built of linear ones by min, max, choice.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction

from haverify.analyses.regions import Node, at_most, choice, combine, extreme, linear, minus
from haverify.model.expression import Expr
from haverify.model.fuzzy import FuzzyController, FuzzyInput, FuzzyRule, Term
from haverify.model.spec import Spec
from haverify.obligations.translate import OutsideFragmentError

ONE, ZERO = linear(Fraction(1)), linear(Fraction(0))
MAX_CHAIN = 50
Inputs = Mapping[str, Node]


def slope(x: Node, zero: Fraction, one: Fraction) -> Node:
    """0 up to one corner and 1 from the other on, linear between; a step belongs to the 1."""
    if zero == one:
        return choice(at_most(linear(zero), x), ONE, ZERO)
    q = 1 / (one - zero)
    return extreme("max", [ZERO, extreme("min", [ONE, combine([(q, x)], -zero * q)])])


def membership(term: Term, x: Node) -> Node:
    """How far x belongs to a term."""
    corners = list(term.corners)
    if term.shape == "ramp":
        if corners[0] == corners[1]:
            raise OutsideFragmentError(f"the ramp of `{term.name}` has no width")
        return slope(x, corners[0], corners[1])
    if corners != sorted(corners):
        raise OutsideFragmentError(f"the corners of `{term.name}` do not ascend")
    a, b, c, d = {1: corners * 4, 3: [*corners[:2], *corners[1:]], 4: corners}[len(corners)]
    falling = choice(at_most(x, linear(c)), ONE, ZERO) if c == d else slope(x, d, c)
    return extreme("min", [slope(x, a, b), falling])


class Systems:
    """The fuzzy systems of a spec; what was unfolded for the same inputs is kept, so that equal things are one."""

    def __init__(self, spec: Spec) -> None:
        self.by_name = {f.name: f for f in spec.fuzzy}
        self._memory: dict[tuple[object, ...], Node] = {}
        self._inputs: list[Inputs] = []
        self._roots: dict[str, dict[str, FuzzyInput]] = {}

    def system(self, name: str) -> FuzzyController:
        """The system, if its inference is understood."""
        found = self.by_name[name]
        if found.logic != ("min", "max"):
            words = " ".join(found.logic)
            raise OutsideFragmentError(f"`logic {words}` of {name}: inference by min and max is decided")
        return found

    def roots(self, name: str, depth: int = 0) -> dict[str, FuzzyInput]:
        """The real inputs that a system reads, those of systems it is chained to included."""
        if depth > MAX_CHAIN:
            raise OutsideFragmentError(f"more than {MAX_CHAIN} fuzzy systems in a chain")
        if name in self._roots:
            return self._roots[name]
        out: dict[str, FuzzyInput] = {}
        for i in self.system(name).inputs:
            found = self.roots(i.source[0], depth + 1) if i.source else {i.name: i}
            for n, root in found.items():
                if n in out and _border(out[n]) != _border(root):
                    raise OutsideFragmentError(f"{name} reads two inputs `{n}` with different units or ranges")
                out[n] = root
        return self._roots.setdefault(name, out)

    def terms(self, name: str, word: str) -> tuple[str, ...]:
        """The terms of an input."""
        i = self._input(name, word)
        return self.outputs(i.source[0])[i.source[1]] if i.source else tuple(t.name for t in i.terms)

    def outputs(self, name: str) -> dict[str, tuple[str, ...]]:
        """The terms of each output."""
        return dict(self.system(name).outputs)

    def _input(self, name: str, word: str) -> FuzzyInput:
        return next(i for i in self.system(name).inputs if i.name == word)

    def degree(self, name: str, word: str, term: str, at: Inputs) -> Node:
        """How far an input belongs to a term."""
        i = self._input(name, word)
        if i.source:
            return self.strength(i.source[0], i.source[1], term, at)
        found = next(t for t in i.terms if t.name == term)
        return self._remembered(("degree", name, word, term), at, lambda: membership(found, at[word]))

    def rules(self, name: str, output: str, term: str | None) -> list[FuzzyRule]:
        """The rules that conclude a term of an output (any term: None)."""
        return [r for r in self.system(name).rules if r.output == output and term in (None, r.term)]

    def strength(self, name: str, output: str, term: str | None, at: Inputs) -> Node:
        """The greatest strength of the rules that conclude a term of an output (any term: None)."""
        rules = self.rules(name, output, term)
        return self._remembered(
            ("strength", name, output, term),
            at,
            lambda: extreme("max", [self.premise(name, r.premise, at) for r in rules] or [ZERO]),
        )

    def premise(self, name: str, e: Expr, at: Inputs) -> Node:
        """The strength of a premise."""
        if e.op == "is":
            return self.degree(name, str(e.args[0]), str(e.args[1]), at)
        return self._remembered(("premise", name, e), at, lambda: self._joined(name, e, at))

    def _joined(self, name: str, e: Expr, at: Inputs) -> Node:
        parts = [self.premise(name, c, at) for c in e.children]
        return minus(ONE, parts[0]) if e.op == "not" else extreme("min" if e.op == "and" else "max", parts)

    def _remembered(self, key: tuple[object, ...], at: Inputs, make: Callable[[], Node]) -> Node:
        whole = (*key, *((v, id(n)) for v, n in sorted(at.items())))
        if whole not in self._memory:
            self._memory[whole] = make()
            self._inputs.append(at)  # kept, so that an id is of one node only
        return self._memory[whole]


def _border(i: FuzzyInput) -> tuple[object, ...]:
    return i.unit.text if i.unit else None, i.low, i.high
