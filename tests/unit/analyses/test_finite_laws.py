"""Random goals over random tables: the analysis and the second checker agree with an evaluation by the book."""

import json
from fractions import Fraction
from itertools import product

from hypothesis import given, settings
from hypothesis import strategies as st

from hacheck.core import Core
from hacheck.finite_goals import shown
from hacheck.rational import Meter, Refused
from haverify.analyses.finite import decide_finite
from haverify.evidence.verdict import Proved, Refuted, Unknown
from haverify.model.cellular import CellularAutomaton, Relation, Rule
from haverify.model.claim import Claim, Goal
from haverify.model.core import to_core
from haverify.model.expression import Expr, number
from haverify.model.spec import EnumType, Spec

LEG = EnumType("Leg", ("Left", "Right"), ("0b0", "0b1"))
SUB = EnumType("Sub", ("A", "B", "C"), (None, None, None))
COUNT = EnumType("Count", ("4", "5"), (None, None), Fraction(4), Fraction(5))
BITS = [a + b for a in "01" for b in ("00", "01", "10")]
FIELDS = {
    a + b[1:]: (leg, sub)
    for a, leg in zip("01", LEG.values, strict=True)
    for b, sub in zip(BITS[:3], SUB.values, strict=True)
}
NAMES = ("c", "d")

pairs = st.tuples(st.sampled_from(SUB.values), st.sampled_from(SUB.values))
rules = st.lists(st.tuples(st.sampled_from(BITS), st.sampled_from(BITS)), min_size=4, max_size=9)


def cells(bound: tuple[str, ...]) -> st.SearchStrategy[Expr]:
    """Terms whose values are cells."""
    leaves = [st.sampled_from([Expr("cell", ("Cell", b)) for b in BITS])]
    if bound:
        leaves.append(st.sampled_from([Expr("bound", (n,)) for n in bound]))
    leaf = st.one_of(*leaves[::-1])
    return st.one_of(
        leaf,
        leaf.map(lambda t: Expr("next", ("R", t))),
        leaf.map(lambda t: Expr("next", ("F", Expr("next", ("R", t))))),
    )


def subs(bound: tuple[str, ...]) -> st.SearchStrategy[Expr]:
    """Terms whose values are sub-phases."""
    field = cells(bound).map(lambda t: Expr("field", (t, "sub")))
    constant = st.sampled_from([Expr("sym", ("Sub", v)) for v in SUB.values])
    return st.one_of(field, field.map(lambda t: Expr("apply", ("S", t))), constant)


def atoms(bound: tuple[str, ...]) -> st.SearchStrategy[Expr]:
    """Truths without connectives."""
    equal = st.sampled_from(["==", "!="])
    return st.one_of(
        st.tuples(equal, cells(bound), cells(bound)).map(lambda x: Expr(x[0], x[1:])),
        st.tuples(equal, subs(bound), subs(bound)).map(lambda x: Expr(x[0], x[1:])),
        cells(bound).map(lambda t: Expr("defined", (t,))),
        subs(bound).map(lambda t: Expr("defined", (t,))),
        cells(bound).map(lambda t: Expr("unique_rule", ("R", t))),
        subs(bound).map(lambda t: Expr("related", ("S", t))),
        subs(bound).map(
            lambda t: Expr("<", (Expr("if", (Expr("related", ("S", t)), number(1), number(2))), number(2)))
        ),
    )


def formulas(bound: tuple[str, ...] = (), depth: int = 3) -> st.SearchStrategy[Expr]:
    """Truths; a quantifier may bind a name that is bound already."""
    if depth == 0:
        return atoms(bound)
    inner = formulas(bound, depth - 1)
    quantified = st.tuples(st.sampled_from(["forall", "exists", "unique"]), st.sampled_from(NAMES)).flatmap(
        lambda q: formulas(tuple({*bound, q[1]}), depth - 1).map(lambda e: Expr(q[0], (q[1], "Cell", e)))
    )
    joined = st.tuples(st.sampled_from(["and", "or", "implies"]), inner, inner).map(lambda x: Expr(x[0], x[1:]))
    chosen = st.tuples(inner, inner, inner).map(lambda x: Expr("if", x))
    return st.one_of(quantified, joined, inner.map(lambda e: Expr("not", (e,))), chosen, atoms(bound))


class Book:
    """Evaluation by the definitions in docs/core.md, one value of each name at a time."""

    def __init__(self, steps: list[tuple[str, str]], images: list[tuple[str, str]]) -> None:
        self.steps, self.images = steps, images

    def results(self, automaton: str, cell: str) -> list[str]:
        if automaton == "F":  # the formula: `if c.leg is Left then R.next(c) else c`
            return [t for t in (self.next("R", cell),) if t] if cell[0] == "0" else [cell]
        return [b for a, b in self.steps if a == cell]

    def next(self, automaton: str, cell: str) -> str | None:
        found = set(self.results(automaton, cell))
        return found.pop() if len(found) == 1 else None

    def value(self, e: Expr, env: dict) -> object:
        if e.op in ("num", "bound", "cell", "sym"):
            return {"num": lambda: e.args[0], "bound": lambda: env[e.args[0]]}.get(e.op, lambda: e.args[1])()
        if e.op == "if":
            c = self.truth(e.args[0], env)
            return None if c is None else self.value(e.args[1 if c else 2], env)
        inner = self.value(e.children[0], env)
        if inner is None:
            return None
        if e.op == "field":
            return FIELDS[inner][("leg", "sub").index(e.args[1])]
        if e.op == "next":
            return self.next(e.args[0], inner)
        found = {b for a, b in self.images if a == inner}
        return found.pop() if len(found) == 1 else None

    def truth(self, e: Expr, env: dict) -> bool | None:
        if e.op in ("forall", "exists", "unique"):
            found = [self.truth(e.args[2], {**env, e.args[0]: b}) for b in BITS]
            return self.quantified(e.op, found)
        if e.op in ("and", "or", "implies", "not"):
            found = [self.truth(c, env) for c in e.args]
            if e.op == "not":
                return None if found[0] is None else not found[0]
            if e.op == "implies":
                found[0] = None if found[0] is None else not found[0]
            return self.quantified("forall" if e.op == "and" else "exists", found)
        if e.op == "if":
            c = self.truth(e.args[0], env)
            return None if c is None else self.truth(e.args[1 if c else 2], env)
        values = [self.value(c, env) for c in e.children]
        if e.op == "defined":
            return values[0] is not None
        if None in values:
            return None
        if e.op == "unique_rule":
            return len(self.results(e.args[0], values[0])) == 1
        if e.op == "related":
            return values[0] in {a for a, _ in self.images}
        return {"==": values[0] == values[-1], "!=": values[0] != values[-1]}.get(
            e.op, values[0] is not values[-1] and e.op == "<" and values[0] < values[-1]
        )

    @staticmethod
    def quantified(kind: str, found: list) -> bool | None:
        if kind == "unique":
            worlds = {w.count(True) == 1 for w in product(*[(t,) if t is not None else (True, False) for t in found])}
            return worlds.pop() if len(worlds) == 1 else None
        decisive = kind == "exists"
        return decisive if decisive in found else None if None in found else not decisive


def spec_of(steps: list, images: list, goal: Expr, assume: tuple[Expr, ...] = ()) -> Spec:
    c = Expr("bound", ("x",))
    left = Expr("==", (Expr("field", (c, "leg")), Expr("sym", ("Leg", "Left"))))
    automata = (
        CellularAutomaton("R", "Cell", "Leg", "Sub", tuple(Rule(a, b) for a, b in steps)),
        CellularAutomaton("F", "Cell", "Leg", "Sub", (), "x", Expr("if", (left, Expr("next", ("R", c)), c))),
    )
    claim = Claim("p", None, "property", (Goal("holds", goal),), None, None, assume, (), (), None, None, False)
    return Spec(
        "t", "1.0", False, (), (LEG, SUB, COUNT), (), (), (), (), (), (), (), (), automata,
        (Relation("S", tuple(images), True),), (), (claim,), (),
    )  # fmt: skip


def check(spec: Spec, truth: bool | None) -> None:
    """The analysis proposes `truth`, or nothing where it would be vacuous; the checker follows, and no other way."""
    core = to_core(spec)
    claim, (goal,) = spec.claims[0], spec.claims[0].goals
    held = decide_finite(spec, claim, goal, core, 4000)
    if isinstance(held.verdict, Unknown) and held.verdict.kind == "vacuous":
        assert truth is True
        return
    assert type(held.verdict) is {True: Proved, False: Refuted, None: Unknown}[truth]
    read = Core(json.loads(json.dumps(core)))
    listed = read.data["claims"][0]
    Meter.left = 60_000_000
    if truth is not None:
        assert shown(read, listed, listed["goals"][0], held.entry) == ("proved" if truth else "refuted")
    for bits in BITS[:3]:
        for name in NAMES:
            entry = {"kind": "witness", "hash": "", "params": {}, "values": [[name, bits]]}
            try:
                found = shown(read, listed, listed["goals"][0], entry)
            except Refused:
                continue
            assert found == ("proved" if truth else "refuted") and truth is not None


@settings(max_examples=200, derandomize=True, deadline=None)
@given(rules, st.lists(pairs, min_size=1, max_size=5), formulas())
def test_random_goals(steps: list, images: list, goal: Expr) -> None:
    check(spec_of(steps, images, goal), Book(steps, images).truth(goal, {}))


@settings(max_examples=40, derandomize=True, deadline=None)
@given(rules, formulas(("c", "d"), 2))
def test_goals_under_three_quantifiers(steps: list, body: Expr) -> None:
    goal = Expr(
        "forall", ("c", "Cell", Expr("exists", ("d", "Cell", Expr("or", (body, Expr("exists", ("c", "Cell", body)))))))
    )
    check(spec_of(steps, [("A", "B")], goal), Book(steps, [("A", "B")]).truth(goal, {}))
