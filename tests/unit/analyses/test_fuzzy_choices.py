"""What a fuzzy system chooses over a variable: the choice at every point, by intervals with their ends."""

import random
from fractions import Fraction
from pathlib import Path

import pytest

from haverify.analyses.fuzzy_systems import Systems
from haverify.analyses.hybrid.chosen import choices_of
from haverify.analyses.hybrid.model import hybrid_model
from haverify.analyses.portfolio import decide
from haverify.analyses.regions import linear, value_at
from haverify.evidence.verdict import Unknown
from haverify.model.expression import Expr, number
from haverify.model.hybrid import HybridAutomaton
from haverify.model.spec import Spec
from haverify.obligations.constants import values_of
from haverify.obligations.translate import OutsideFragmentError
from haverify.run.examine import read
from haverify.text.record import replace

Q = Fraction
SPEC = Path(__file__).parents[3] / "spec" / "push_recovery.ha"


@pytest.fixture(scope="module")
def push() -> tuple[Spec, HybridAutomaton]:
    spec, _, _ = read(str(SPEC))
    assert spec is not None
    return spec, next(a for a in spec.automata if a.name == "Push")


def applied(side: Q, ahead: Q) -> Expr:
    given = (("force", Expr("var", ("peak",))), ("side", number(side)), ("ahead", number(ahead)))
    return Expr("fuzzy", ("FIS2", "strategy", given))


def chosen(pieces: list[tuple[Expr, str]], x: Q) -> list[str]:
    def holds(e: Expr) -> bool:
        if e.op in ("true", "and"):
            return all(map(holds, e.children))
        end = Q(str(e.children[1].args[0]))
        return {"<": x < end, "<=": x <= end, ">": x > end, ">=": x >= end}[e.op]

    return [value for where, value in pieces if holds(where)]


def test_the_strategy_of_a_diagonal_push_by_its_force(push: tuple[Spec, HybridAutomaton]) -> None:
    pieces = list(choices_of(*push, values_of(*push), applied(Q(1), Q(1))))
    assert [value for _, value in pieces] == ["ankle", "hip", "fall"]
    ends = {Q(0): "ankle", Q(9, 2): "ankle", Q(451, 100): "hip", Q(17, 2): "hip", Q(851, 100): "fall", Q(12): "fall"}
    assert {x: chosen(pieces, x) for x in ends} == {x: [v] for x, v in ends.items()}


def test_at_every_point_there_is_one_choice_and_it_is_the_strongest_term(push: tuple[Spec, HybridAutomaton]) -> None:
    spec, automaton = push
    systems, chance = Systems(spec), random.Random(5)
    terms = systems.outputs("FIS2")["strategy"]
    for _ in range(12):
        side, ahead = (Q(chance.randint(-8, 8) or 1, 8) for _ in "ab")
        pieces = list(choices_of(spec, automaton, values_of(spec, automaton), applied(side, ahead)))
        for x in [Q(chance.randint(0, 480), 40) for _ in range(60)]:
            at = {"force": linear(x), "side": linear(side), "ahead": linear(ahead)}
            found = [value_at(systems.strength("FIS2", "strategy", t, at), {}) for t in terms]
            assert chosen(pieces, x) == [terms[found.index(max(found))]]


def test_where_no_rule_fires_nothing_is_said(push: tuple[Spec, HybridAutomaton]) -> None:
    spec, automaton = push
    with pytest.raises(OutsideFragmentError, match="no rule fires where peak is"):
        list(choices_of(spec, automaton, values_of(spec, automaton), applied(Q(0), Q(1))))
    claim = next(c for c in spec.claims if c.name == "never_falls")
    wide = tuple(replace(v, range=None) if v.name == "peak" else v for v in automaton.vars)
    other = replace(automaton, vars=wide)
    found = decide(replace(spec, automata=tuple(other if a is automaton else a for a in spec.automata)), claim).verdict
    assert isinstance(found, Unknown) and "declared range" in found.reason
    assert hybrid_model(spec, automaton, []).places
