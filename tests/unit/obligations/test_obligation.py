"""The hash of an obligation: the same for the same question, another for every other."""

import pytest
from tests.unit.obligations.texts import PLAIN, hash_of, spec_of

from haverify.obligations.obligation import hashes

CLAIM = "always y <= 5"


def changed(old, new):
    assert PLAIN.count(old) == 1, "a change that changes one thing"
    return PLAIN.replace(old, new)


@pytest.mark.parametrize(
    "model",
    [
        "// words\n\n" + PLAIN,
        PLAIN.replace("  flow", "\n\n      flow"),
        PLAIN.replace("x <= 1", "(x   <= 1)"),
        PLAIN.replace("const c = 3", "const c = 3.0"),
        PLAIN + "automaton B {\n  var u\n  init O with { u := 0 }\n  mode O { flow { u' = 1 } }\n}\n",
        PLAIN + "const unread = 4\n",
    ],
    ids=["comment", "lines", "brackets", "spelling", "another automaton", "unread constant"],
)
def test_what_is_written_otherwise_is_the_same(model):
    assert hash_of(CLAIM, model) == hash_of(CLAIM)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("domain x <= 1", "domain x < 1"),
        ("domain x <= 2", "domain x <= 3"),
        ("when x >= 1", "when x > 1"),
        ("urgent edge up", "edge up"),
        ("-> N when", "-> M when"),
        ("x := 0 }\n  mode M", "x in [0, 1] }\n  mode M"),
        ("do { x := 0 }", "do { x := 1 }"),
        ("let y = c * x + p", "let y = c * x"),
        ("let z = p", "let z = 2 * p"),
        ("var x in [0, 9]", "var x in [0, 8]"),
        ("const c = 3", "const c = 4"),
        ("param p in [0, 1]", "param p in [0, 2]"),
        ("param p in [0, 1]", "param p in [0, 1]\nparam q in [0, 1]"),
        ("automaton A {", "assume p <= 1/2\nautomaton A {"),
    ],
)
def test_every_change_of_the_model_is_another_question(old, new):
    assert hash_of(CLAIM, changed(old, new)) != hash_of(CLAIM)


@pytest.mark.parametrize(
    "claim",
    [
        "always y < 5",
        "always y <= 6",
        "always y >= 5",
        "can reach y <= 5",
        "reach y <= 5 within 3",
        "always during [0, 3] y <= 5",
        "within 3; always y <= 5",
        "within 3 jumps; always y <= 5",
        "assume p <= 1/2; always y <= 5",
    ],
)
def test_every_change_of_the_claim_is_another_question(claim):
    assert hash_of(claim) != hash_of(CLAIM)


def test_horizons_and_assumptions_are_told_apart():
    claims = [f"{head}; {CLAIM}" for head in ("within 3", "within 4", "within 3 jumps", "within 4 jumps")]
    claims += [f"assume {bound}; {CLAIM}" for bound in ("p <= 1/2", "p < 1/2", "p >= 1/2")]
    assert len({hash_of(c) for c in claims}) == len(claims)


def test_the_name_of_a_claim_is_no_part_of_it_and_every_place_is():
    spec = spec_of("always x <= 1", CLAIM)
    found = hashes(spec, spec.automata[0])
    goal = found.goal(spec.claims[1], spec.claims[1].goals[0])
    assert found.part(goal, "dwell", "M", "y") == hash_of(CLAIM)
    places = [("dwell", "M", "y"), ("dwell", "N", "y"), ("jump", "M", "y"), ("dwell", "M", "x"), ("dwell", "M", "")]
    assert len({found.part(goal, *p) for p in places}) == len(places)
