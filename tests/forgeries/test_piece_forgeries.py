"""Damages to what is shown piece by piece (`for which`) and to starts with a jump: nothing false is accepted."""

from __future__ import annotations

import contextlib
import copy
import json
from fractions import Fraction as Q
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.forgeries.test_invariant_forgeries import FAULTS, Case, changed, places

from hacheck.core import Core
from hacheck.obligations import Setting, established
from hacheck.rational import Meter
from haverify.analyses.which import simplest

Json = Any
BOUNCE = """
spec "Bounce" version "1.0" unitless
param r in [0, 3]
automaton A {
  var x
  var y
  init Fly where x^2 + y^2 <= 1
  init Rest where x == 0 and y == 0
  mode Fly { flow { x' = y; y' = -x }; edge hit: -> Rest when y >= 0 do { x := r * x; y in [0, 1/2] } }
  mode Rest { flow { x' = -x; y' = -y } }
}
property range on A {
  for which r in [0, 2]
  always (at(Fly) implies x^2 + y^2 <= 1 and -1 <= x <= 1) and (at(Rest) implies -1 <= x <= 1)
}
invariant lemma on A: (at(Fly) implies x^2 + y^2 <= 1 and -1 <= x <= 1) and (at(Rest) implies -3 <= x <= 3) inductive
property twice on A { for which r in [0, 1]; always -4 <= x <= 4; using lemma }
"""


@pytest.fixture(scope="module")
def case() -> Case:
    return Case(BOUNCE)


def pieces(case: Case, certificate: Json, name: str = "range") -> list[tuple[Q, Q, str]]:
    """What the checker accepts of each piece."""
    Meter.left = 20_000_000
    core = Core(case.core)

    def setting(automaton: Json, rounding: bool) -> Setting:
        return Setting(core, automaton, rounding, lambda _: None, lambda used: core.claims[used])

    _, _, found = established(core, core.claims[name], certificate, setting)
    ends = [where.split("[")[1].rstrip("]").split(", ") for where, _, _ in found]
    return [(Q(low), Q(high), word) for (low, high), (_, _, word) in zip(ends, found, strict=True)]


def is_true(found: list[tuple[Q, Q, str]]) -> bool:
    """The claim holds for r <= 1 and fails for r > 1."""
    return all(high <= 1 if word == "proved" else low > 1 if word == "refuted" else True for low, high, word in found)


def test_the_bound_is_found(case: Case) -> None:
    found = pieces(case, case.certificates["range"])
    assert (0, 1, "proved") in found and is_true(found)
    low, high, word = found[-1]
    assert (high, word) == (2, "refuted") and low - 1 < Q(1, 10**5)


def test_what_is_proved_may_rest_on_other_invariants(case: Case) -> None:
    assert [w for _, _, w in pieces(case, case.certificates["twice"], "twice")] == ["proved"]


def scalars(value: Json) -> list[tuple[str | int, ...]]:
    return [at for at, v in places(value) if at and not isinstance(v, (dict, list))]


SMALL = st.sampled_from(["0", "1", "-1", "2", "1/2", "3/2", "proved", "refuted", "split", "r", "x", "<", "t", "b"])


@settings(max_examples=150, deadline=None, derandomize=True)
@given(data=st.data())
def test_a_changed_word_or_number_makes_nothing_false_accepted(case: Case, data: st.DataObject) -> None:
    whole = case.certificates["range"]
    at = data.draw(st.sampled_from(scalars(whole)))
    damaged = changed(whole, at, data.draw(SMALL | st.integers(-1, 3) | st.none()))
    with contextlib.suppress(*FAULTS):
        assert is_true(pieces(case, damaged))


@settings(max_examples=80, deadline=None, derandomize=True)
@given(data=st.data())
def test_a_part_put_elsewhere_makes_nothing_false_accepted(case: Case, data: st.DataObject) -> None:
    whole = case.certificates["range"]
    found = [at for at, v in places(whole) if at and isinstance(v, (dict, list))]
    here, there = data.draw(st.sampled_from(found)), data.draw(st.sampled_from(found))
    value = whole
    for k in there:
        value = value[k]
    with contextlib.suppress(*FAULTS):
        assert is_true(pieces(case, changed(whole, here, copy.deepcopy(value))))


def leaf(tree: Json, word: str) -> Json:
    """The first leaf with a verdict."""
    if isinstance(tree, list):
        return leaf(tree[3], word) or leaf(tree[4], word)
    return tree if tree is not None and tree["verdict"] == word else None


def refused(case: Case, tree: Json, name: str = "range", verdict: str = "refuted") -> bool:
    certificate = {**case.certificates["range"], "claim": name, "boxes": tree, "verdict": verdict}
    try:
        pieces(case, certificate, name)
    except FAULTS:
        return True
    return False


def test_pieces_that_are_none_are_refused(case: Case) -> None:
    whole = case.certificates["range"]["boxes"]
    wrong, right = leaf(whole, "refuted"), leaf(whole, "proved")
    assert not refused(case, whole)
    tried: list[Json] = [wrong, right, None, ["split", "r", "1", right, None], ["split", "r", "1", right, wrong]]
    tried += [["split", "r", "0", None, whole], ["split", "r", "2", whole, None], ["split", "q", "1", right, wrong]]
    tried += [["split", "r", "1", right], [], "proved", ["cut", "r", "1", right, None]]
    for tree in tried:
        assert refused(case, tree) and refused(case, tree, verdict="proved")


def test_a_start_is_for_all_values_of_the_piece(case: Case) -> None:
    wrong = leaf(case.certificates["range"]["boxes"], "refuted")
    one = copy.deepcopy(wrong)
    one["goals"][0]["start"]["params"]["r"] = "2"
    text = json.dumps(case.certificates["range"]["boxes"])
    tree = json.loads(text.replace(json.dumps(wrong), json.dumps(one)))
    assert tree != case.certificates["range"]["boxes"] and refused(case, tree)


@given(a=st.fractions(-5, 5, max_denominator=50), b=st.fractions(-5, 5, max_denominator=50))
@settings(max_examples=100, deadline=None, derandomize=True)
def test_the_simplest_number_is_strictly_between(a: Q, b: Q) -> None:
    if a < b:
        c = simplest(a, b)
        assert a < c < b and all(not a < Q(n, d) < b for d in range(1, c.denominator) for n in range(-5 * d, 5 * d + 1))
