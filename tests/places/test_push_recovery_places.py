"""Every place of `spec/push_recovery.ha`: each rule dropped or swapped, each corner shifted by a quarter of its term.

A claim or a finding notices, or the change is proved to be without effect: the changed system has the same strengths
as the system as it was, for all inputs.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from hacheck.core import Core
from hacheck.fuzzy import fuzzy_goal
from haverify.analyses.fuzzy import decide_fuzzy
from haverify.elaborate.elaborate import elaborate
from haverify.evidence.verdict import Proved, Refuted
from haverify.model.claim import Claim, Goal
from haverify.model.core import to_core
from haverify.model.expression import Expr
from haverify.model.fuzzy import FuzzyController, FuzzyInput
from haverify.model.spec import Spec
from haverify.run.load import load
from haverify.text.record import replace

SPEC = Path(__file__).parents[2] / "spec" / "push_recovery.ha"


def original() -> Spec:
    """The spec as it is."""
    loaded, _ = load(SPEC)
    assert loaded is not None
    spec, _ = elaborate(loaded.tree, loaded.files)
    assert spec is not None
    return spec


ORIGINAL = original()
SYSTEMS = [f.name for f in ORIGINAL.fuzzy]


def changes(system: FuzzyController) -> Iterator[tuple[str, FuzzyController]]:
    """The system with one rule fewer, with two conclusions exchanged, with one corner elsewhere."""
    rules = system.rules
    for k, r in enumerate(rules):
        yield f"without {r.name}", replace(system, rules=rules[:k] + rules[k + 1 :])
        other = rules[(k + 1) % len(rules)]
        if other.term != r.term:
            swapped = {id(r): replace(r, term=other.term), id(other): replace(other, term=r.term)}
            yield (
                f"{r.name} and {other.name} swapped",
                replace(system, rules=tuple(swapped.get(id(x), x) for x in rules)),
            )
    for k, i in enumerate(system.inputs):
        for name, shifted in shifts(i):
            yield name, replace(system, inputs=(*system.inputs[:k], shifted, *system.inputs[k + 1 :]))


def shifts(i: FuzzyInput) -> Iterator[tuple[str, FuzzyInput]]:
    """The input with one corner of a term shifted by a quarter of the term's width, up and down."""
    for k, term in enumerate(i.terms):
        quarter = (max(term.corners) - min(term.corners)) / 4
        for c, q in enumerate(term.corners):
            for step in (quarter, -quarter):
                corners = (*term.corners[:c], q + step, *term.corners[c + 1 :])
                changed = replace(term, corners=corners)
                yield (
                    f"{i.name}.{term.name} corner {c + 1} {step}",
                    replace(i, terms=(*i.terms[:k], changed, *i.terms[k + 1 :])),
                )


def is_ordered(system: FuzzyController) -> bool:
    """Do the corners of each term ascend? (Otherwise HA201.)"""
    terms = [t for i in system.inputs for t in i.terms]
    return all(t.shape == "ramp" or list(t.corners) == sorted(t.corners) for t in terms)


def is_noticed(changed: Spec, name: str) -> bool:
    """Does a claim that reads the system get another verdict than it expects?"""
    if not all(map(is_ordered, changed.fuzzy)):
        return True
    core = to_core(changed)
    claims = [c for c in changed.claims if c.expect and reads(c, name)]
    claims.sort(key=lambda c: str(c.goals).count("'fuzzy'"))  # the quick ones first
    return any(verdict(changed, c, core) != c.expect.verdict for c in claims)


def verdict(spec: Spec, claim: Claim, core: dict) -> str:
    """Refuted if a goal is, proved if all are."""
    found = [decide_fuzzy(spec, claim, g, core, 100).verdict for g in claim.goals]
    if any(isinstance(v, Refuted) for v in found):
        return "refuted"
    return "proved" if all(isinstance(v, Proved) for v in found) else "unknown"


CHAINED = {"FIS1": {"FIS1", "FIS2", "Printed2"}}


def reads(claim: Claim, name: str) -> bool:
    """Is the claim about the system, or about one that reads it?"""
    if any(g.kind != "holds" for g in claim.goals):
        return False
    names = CHAINED.get(name, {name})
    text = json.dumps([str(g.condition) for g in claim.goals])
    return claim.on in names or any(f"'{n}'" in text for n in names)


def is_without_effect(system: FuzzyController) -> bool:
    """Proved and checked: for all inputs each term is as strong as in the system as it was."""
    spec = replace(ORIGINAL, fuzzy=(*ORIGINAL.fuzzy, replace(system, name="Changed")), claims=())
    terms = [t for _, terms in system.outputs for t in terms]
    equal = [Expr("==", tuple(Expr("strength", (f, t)) for f in (system.name, "Changed"))) for t in terms]
    goals = tuple(Goal("holds", e, None, None, False) for e in equal)
    claim = replace(ORIGINAL.claims[0], name="same", on=system.name, goals=goals, assume=())
    spec = replace(spec, claims=(claim,))
    core = to_core(spec)
    read = Core(json.loads(json.dumps(core)))
    for k, goal in enumerate(goals):
        held = decide_fuzzy(spec, claim, goal, core, 100)
        if not isinstance(held.verdict, Proved):
            return False
        listed = read.claims["same"]
        assert fuzzy_goal(read, listed, listed["goals"][k], json.loads(json.dumps(held.entry))) == "proved"
    return True


PLACES = 186
DIRECTIONS = ("side.left", "side.right", "ahead.backward", "ahead.forward")
SAME = {
    "FIS1": {"force.small corner 1 -5/4", "force.large corner 4 1"},
    "FIS2": {"without R12", "without R13", "without R21", "without R31", "R12 and R13 swapped", "R13 and R21 swapped"},
    "Components": {f"{i}.{c}" for i in ("roll", "pitch") for c in ("small corner 1 -5/4", "large corner 4 1")},
    "Printed1": {
        *("E33 and E34 swapped", "E35 and E36 swapped", "force.small corner 1 -5/4", "force.large corner 4 1"),
        *("side.left corner 1 -1/4", "side.right corner 1 1/4", "ahead.backward corner 1 -1/4"),
        *("ahead.forward corner 1 1/4",),
        *(f"{t} corner 2 {q}" for t in DIRECTIONS for q in ("1/4", "-1/4")),
    },
    "Printed2": {"E38 and E39 swapped", "E41 and E37 swapped"},
}


@pytest.mark.parametrize("name", SYSTEMS)
def test_every_place_matters_or_provably_does_not(name):
    system = next(f for f in ORIGINAL.fuzzy if f.name == name)
    same = set()
    for what, changed in changes(system):
        spec = replace(ORIGINAL, fuzzy=tuple(changed if f.name == name else f for f in ORIGINAL.fuzzy))
        if not is_noticed(spec, name):
            assert is_without_effect(changed), what
            same.add(what)
    assert sorted(same) == sorted(SAME[name])


def test_the_spec_as_it_is_is_not_noticed():
    assert not is_noticed(ORIGINAL, "Printed1")


def test_there_are_many_places():
    assert sum(len(list(changes(f))) for f in ORIGINAL.fuzzy) == PLACES
