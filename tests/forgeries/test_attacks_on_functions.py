"""Roots and logarithms where they are not defined or have no slope, and starts of params that have no value at all."""

from __future__ import annotations

import json
from typing import Any

import pytest
from tests.forgeries.test_attacks_on_invariants import FAULTS, World

from hacheck.obligations import Question, canonical_hash
from haverify.analyses.portfolio import decide_all
from haverify.model.core import canonical

Json = Any
DRAINED = """
spec "s" version "1.0" unitless
automaton A {
  var x
  init Full where x == 4
  init Empty where x == 0
  mode Full { domain x >= 1; flow { x' = 1 } }
  mode Empty { domain x >= 0; flow { x' = RATE } }
}
property p on A { always at(Empty) implies x <= 0 }
"""
ROOT = "sqrt(1*x)"
INVERSE = f"inv(1*{ROOT})"
NOUGHT = ["<=", [["1", "x"]]]
START = {"mode": "Empty", "values": {"x": "0"}, "params": {}}


def cuts(formula: Json, start: Json, keep: Json) -> Json:
    return {"cuts": [{"formula": formula, "start": start, "keep": keep}], "end": "t"}


def stays(rule: str, rate: str) -> str:
    """Whether x = 0 is thought to be kept; the slope of the root is met in the other mode, so it has a name."""
    told = ["fact", "meaning", ROOT, ["or", 2, ["b", "b"]]]
    named = cuts(["<=", [["-1", ROOT]]], told, {"rule": "barrier", "proofs": ["b"]})
    full = named if rate == "sqrt(x)" else {"cuts": [], "end": "t"}
    of_root = ["psatz", [], [[7, [["1", ROOT]]], [4, [["-1", INVERSE]]]], ["1", [2]]]
    at_nought = ["psatz", [], [[7, [["-1", ROOT]]], [4, [["1"]]]], ["1", [1]]]
    of_inverse = ["fact", "meaning", INVERSE, ["or", 6, [at_nought, of_root]]]
    proof = ["fact", "meaning", ROOT, ["or", 3, ["b", of_inverse]]] if rate == "sqrt(x)" else "b"
    factor = [["1", INVERSE]] if rate == "sqrt(x)" else [["1"]]
    growth = {"rule": "growth", "cofactor": factor, "band": None, "proof": proof}
    linear = {"rule": "darboux", "matrix": [[factor]], "ideal": [[]]}
    empty = cuts(NOUGHT, "t", growth if rule == "growth" else linear)
    proofs = {"init": "t", "flow Full": full, "flow Empty": empty, "use": "t"}
    return World(DRAINED.replace("RATE", rate)).forge("p", {"Full": True, "Empty": NOUGHT}, proofs, START)


def test_growth_is_by_a_bounded_factor() -> None:
    """Of x' = sqrt(x) from 0, t^2/4 is a solution: 1/sqrt(x) times x is no bounded factor of it."""
    assert stays("darboux", "x") == "proved"
    with pytest.raises(FAULTS, match="not defined everywhere"):
        stays("growth", "sqrt(x)")
    with pytest.raises(FAULTS, match="not defined everywhere"):
        stays("darboux", "sqrt(x)")


UNDEFINED = """
spec "s" version "1.0" unitless
automaton A {
  var x
  var y
  init M where x == 1 and y == 0
  mode M { domain x >= LOW; flow { x' = -1; y' = RATE } }
}
property p on A { always CLAIM }
invariant q on A: CLAIM inductive
"""


def words(claim: str, low: str, rate: str = "y^2") -> list[str]:
    found = decide_all(World(UNDEFINED.replace("CLAIM", claim).replace("LOW", low).replace("RATE", rate)).spec)
    return [type(found[n].verdict).__name__ for n in "pq"]


@pytest.mark.parametrize(
    "claim",
    [
        "sqrt(x) - sqrt(x) <= 1",
        "min(sqrt(x), 5) <= 5",
        "0 * log(x) <= 1",
        "log(x)^2 >= 0",
        "sqrt(x) <= 1 or sqrt(x) > 1",
        "not (sqrt(x) < 1 and sqrt(x) >= 1)",
    ],
)
def test_nothing_is_claimed_of_what_is_not_defined(claim: str) -> None:
    """`proved` includes that all that is evaluated is defined (S1), also where its value is of no account."""
    assert words(claim, "-2") == ["Unknown", "Unknown"]
    assert words(claim, "1/4")[0] == "Proved"
    world, still = World(UNDEFINED.replace("CLAIM", claim).replace("LOW", "-2").replace("RATE", "y^2")), []
    start = {"mode": "M", "values": {"x": "1", "y": "0"}, "params": {}}
    for proof in ("t", "b"):
        with pytest.raises(FAULTS):
            world.forge("p", {"M": True}, {"flow": {"cuts": still, "end": "t"}, "use": proof}, start)


def test_what_is_guarded_is_defined() -> None:
    assert words("x >= 0 implies sqrt(x) >= 0", "-2")[0] == "Proved"


def test_rates_are_defined_whatever_is_shown_of_them() -> None:
    assert words("x >= -3", "-2", "sqrt(x)") == ["Unknown", "Unknown"]
    start = {"mode": "M", "values": {"x": "1", "y": "0"}, "params": {}}
    text = UNDEFINED.replace("CLAIM", "x >= -3").replace("LOW", "-2")
    proofs = {"flow": {"cuts": [], "end": "t"}, "use": "b"}
    assert World(text.replace("RATE", "y")).forge("p", {"M": True}, proofs, start) == "proved"
    with pytest.raises(FAULTS):
        World(text.replace("RATE", "sqrt(x)")).forge("p", {"M": True}, proofs, start)


def test_lets_in_lets_are_looked_at_once() -> None:
    lets = "".join(f"let l{k} = l{k - 1} + l{k - 1}\n" for k in range(1, 40))
    text = UNDEFINED.replace("CLAIM", "l39 >= 0").replace("LOW", "1/4").replace("RATE", "y^2")
    world = World(text.replace("  var y\n", f"  var y\nlet l0 = sqrt(x)\n{lets}"))
    start = {"mode": "M", "values": {"x": "1", "y": "0"}, "params": {}}
    assert type(decide_all(world.spec)["p"].verdict).__name__ == "Proved"
    assert world.forge("p", {"M": True}, {"flow": {"cuts": [], "end": "t"}, "use": "b"}, start) == "proved"


VOID = """
spec "s" version "1.0" unitless
param c in [0, 1]
param b in [c + 1/10, TOP]
automaton A { var x; init M where x == 0; mode M { flow { x' = x^2 } } }
property p on A { always x < 0 }
"""


def from_start(text: str, start: Json) -> str:
    world = World(text)
    claim = world.core.claims["p"]
    setting = world.setting(world.core.automata["A"])
    told = Question(setting, claim, claim["goals"][0]).hash
    digest = canonical_hash(["haverify.obligation/1", setting.hash, told, "start", start["mode"], ""])
    entry = {"kind": "start", "start": start, "hash": digest}
    head = {"schema": "haverify.certificate/1", "claim": "p", "rounding": None, "verdict": "refuted"}
    return world.verdict("p", json.loads(canonical({**head, "goals": [entry]})))


def test_params_that_are_left_out_have_values() -> None:
    """No b is above c + 1/10 and at most c: there is no run, so none violates the claim."""
    start: Json = {"mode": "M", "values": {"x": "0"}, "params": {}}
    for params in ({}, {"c": "0"}, {"b": "1/2"}):
        with pytest.raises(FAULTS):
            from_start(VOID.replace("TOP", "c"), {**start, "params": params})
    assert from_start(VOID.replace("TOP", "c + 2"), {**start, "params": {"b": "3/2"}}) == "refuted"


NESTED = """
spec "s" version "1.0" unitless
automaton A {
  var a
  var b
  var c
  var d
  init M where a == 0 and b == 0 and c == 0 and d == 0
  mode M { flow { a' = 1; b' = 0; c' = 0; d' = 1 } }
}
property p on A { always sin(sin(a) * b) <= sin(sin(c * d)) }
"""


def test_brackets_in_names_do_not_read_as_those_of_functions() -> None:
    """In a core written by hand: `sin(1*a)` times `t)` is not the sine of `a)` times `t`."""

    def renamed(data: Json) -> None:
        text = json.dumps(data).replace('"b"', '"t)"').replace('"c"', '"a)"').replace('"d"', '"t"')
        data.update(json.loads(text))

    start = {"mode": "M", "values": {"a": "0", "t)": "0", "a)": "0", "t": "0"}, "params": {}}
    with pytest.raises(FAULTS, match="a part of one"):
        World(NESTED, renamed).forge("p", {"M": True}, {"flow": {"cuts": [], "end": "t"}}, start)


EMPTYING = """
spec "s" version "1.0" unitless
automaton A {
  var x
  var y
  init M where x == 1 and 0 <= y <= 1
  mode M { domain x >= 0; flow { x' = -1; y' = -sqrt(x) * y } }
}
property p on A { always sqrt(x) <= 1 }
"""


def test_a_root_that_a_rate_reads_too_needs_a_slope() -> None:
    """At x = 0 it has none, which is no matter for the rate; a proof beside that would be refused."""
    assert type(decide_all(World(EMPTYING).spec)["p"].verdict).__name__ == "Unknown"
