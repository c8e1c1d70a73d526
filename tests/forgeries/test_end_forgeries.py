"""Damages to certificates of an end of all runs, and of goals that are never met: every number in them matters."""

from __future__ import annotations

import copy
from collections.abc import Iterator
from fractions import Fraction as Q
from typing import Any

import pytest
from tests.forgeries.test_invariant_forgeries import FAULTS, Case

Json = Any
Place = tuple[str | int, ...]
BOTH = (Q(1), Q(-1, 7))
TEXT = """
spec "Ends" version "1.0" unitless
param c in [0.4, 0.5]
automaton A {
  var h
  var v
  init Fly where h == 5 and v == 0
  mode Fly { domain h >= 0; flow { h' = v; v' = -10 }; urgent edge hit: -> Fly when h <= 0 and v < 0 do v := -c * v }
}
automaton B {
  var x
  var y
  init First where x == 2 and y == 2
  mode First { domain y >= 1; flow { x' = 1; y' = -2 } }
  mode Second { domain x >= 1; flow { x' = -2; y' = 1 } }
  urgent edge over: First -> Second when y <= 1
  urgent edge back: Second -> First when x <= 1
}
property ends on A { always time <= 3 }
property missed on A { reach h >= 6 within 9 }
property drained on B { always time <= 2 }
"""


@pytest.fixture(scope="module")
def case() -> Case:
    return Case(TEXT)


def numbers(value: Json, place: Place = ()) -> Iterator[Place]:
    """The places of numbers that are strings."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from numbers(inner, (*place, key)) if key not in ("hash", "kind", "where") else ()
    elif isinstance(value, list):
        for k, inner in enumerate(value):
            yield from numbers(inner, (*place, k))
    elif isinstance(value, str) and value.lstrip("-").replace("/", "").isdigit():
        yield place


def changed(certificate: Json, place: Place, by: Q) -> Json:
    damaged = copy.deepcopy(certificate)
    inner = damaged
    for key in place[:-1]:
        inner = inner[key]
    inner[place[-1]] = str(Q(inner[place[-1]]) + by)
    return damaged


def is_refused(case: Case, name: str, certificate: Json) -> bool:
    try:
        return case.outcome(name, certificate) != case.whole[name]["verdict"]
    except FAULTS:
        return True


@pytest.mark.parametrize("name", ["ends", "missed", "drained"])
def test_the_certificates_are_accepted(case: Case, name: str) -> None:
    assert case.outcome(name) == case.whole[name]["verdict"] == ("refuted" if name == "missed" else "proved")


@pytest.mark.parametrize("name", ["ends", "missed", "drained"])
def test_no_number_in_an_invariant_may_be_another(case: Case, name: str) -> None:
    places = [p for p in numbers(case.whole[name]) if "modes" in p or (p[2:3] == ("start",) and name == "missed")]
    assert len(places) > 8
    assert [p for p in places if not all(is_refused(case, name, changed(case.whole[name], p, by)) for by in BOTH)] == []


@pytest.mark.parametrize("name", ["ends", "drained"])
def test_hardly_a_number_in_a_proof_may_be_another(case: Case, name: str) -> None:
    """What is cut in may be weaker and still enough; an identity holds with its numbers only."""
    places = [p for p in numbers(case.whole[name]) if "proof" in p][::4]
    accepted = [p for p in places if not is_refused(case, name, changed(case.whole[name], p, Q(1)))]
    assert len(places) > 4 and len(accepted) <= len(places) // 10


def test_a_goal_that_is_met_from_the_start_is_not_excluded(case: Case) -> None:
    damaged = copy.deepcopy(case.whole["missed"])
    damaged["goals"][0]["start"]["values"]["h"] = "7"
    assert is_refused(case, "missed", damaged)
    other = copy.deepcopy(case.whole["missed"])
    other["goals"][0]["invariant"] = copy.deepcopy(case.whole["ends"]["goals"][0])
    assert is_refused(case, "missed", other)
    for key, value in (("jumps", []), ("params", {})):
        told = copy.deepcopy(case.whole["missed"])
        told["goals"][0]["start"][key] = value
        assert is_refused(case, "missed", told)
