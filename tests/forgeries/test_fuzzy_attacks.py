"""Region trees and points that show nothing: damaged certificates of true claims, and true ones on changed cores."""

import copy
import json
from collections.abc import Callable, Iterator

import pytest
from tests.unit.analyses.fuzzy_texts import FORCE, core_of, decided, spec_of

from hacheck.core import Core
from hacheck.fuzzy import fuzzy_goal
from hacheck.holds import held
from hacheck.rational import Refused, Unreadable

CLAIMS = """
fuzzy G {
  input force: N over [0 N, 12 N] { near = trap(0 N, 0 N, 4 N, 6 N) }
  output p { stop }
  rule force is near => p is stop
}
fuzzy Next {
  input a from F.o
  output answer { stay, go }
  rule a is low => answer is stay
  rule a is high => answer is go
}
param u: 1 in [0, 1]
param v: 1 in [0, 1]
property covered_half on F { holds covered(force, 0.5) }
property strict on F { assume side > 0\n holds max_firing(o) > 0 }
property wider on F { holds strength(low) <= G.strength(stop) }
property chained on Next { holds strength(go) == F.strength(high) }
property triangle on F { assume u <= v and v <= side\n holds u <= side or strength(low) > 5 }
property chosen on F { assume side == 1\n holds F.o(force = force, side = side) is high or force <= 4.5 N }
property gap on F { holds covered(force, 0.51) }
"""
SPEC = spec_of(FORCE + CLAIMS)
CORE = core_of(SPEC)
NAMES = [c.name for c in SPEC.claims]
ENTRIES = {name: json.loads(json.dumps(decided(SPEC, k).entry)) for k, name in enumerate(NAMES)}
WRONG = (
    Refused,
    Unreadable,
    KeyError,
    IndexError,
    TypeError,
    ValueError,
    AttributeError,
    ArithmeticError,
    RecursionError,
)


def shown(core: dict, name: str, entry: object) -> str:
    """What the checker takes an entry to show, whatever its hash says; a core may be refused as a whole."""
    read = Core(core)
    claim = read.claims[name]
    return fuzzy_goal(read, claim, claim["goals"][0], copy.deepcopy(entry))


def refused(core: dict, name: str, entry: object) -> bool:
    try:
        return shown(core, name, entry) not in ("proved", "refuted")
    except WRONG:
        return True


def nodes(tree: object, at: tuple[int, ...] = ()) -> Iterator[tuple[tuple[int, ...], object]]:
    """All nodes of a tree with their places."""
    yield at, tree
    if isinstance(tree, list) and tree[0] in ("<=", "<"):
        yield from nodes(tree[3], (*at, 3))
        yield from nodes(tree[4], (*at, 4))


def put(tree: object, at: tuple[int, ...], value: object) -> object:
    if not at:
        return value
    out = list(tree)
    out[at[0]] = put(out[at[0]], at[1:], value)
    return out


def test_what_is_damaged_here_is_accepted_undamaged():
    verdicts = {name: shown(CORE, name, entry) for name, entry in ENTRIES.items()}
    assert verdicts == {**dict.fromkeys(NAMES, "proved"), "gap": "refuted"}


@pytest.mark.parametrize("name", [n for n in NAMES if n != "gap"])
def test_a_tree_cut_short_or_with_a_wrong_leaf_is_refused(name):
    tree = ENTRIES[name]["tree"]
    for at, node in nodes(tree):
        if node == "t":
            for leaf in (["f", []], ["f", [[0, "1"], [1, "1"]]], "b", None, [], ["t"], True):
                assert refused(CORE, name, {**ENTRIES[name], "tree": put(tree, at, leaf)}), (at, leaf)
        elif node[0] == "f":
            for leaf in farkas(node):
                assert refused(CORE, name, {**ENTRIES[name], "tree": put(tree, at, leaf)}), (at, leaf)
        else:
            assert refused(CORE, name, {**ENTRIES[name], "tree": put(tree, at, ["f", []])}), at
            assert refused(CORE, name, {**ENTRIES[name], "tree": put(tree, at, node[:4])}), at


def farkas(node: list) -> Iterator[object]:
    """Wrong multipliers."""
    for k, (i, q) in enumerate(node[1]):
        rest = node[1][:k] + node[1][k + 1 :]
        yield ["f", rest]
        yield ["f", [*rest, [i, "-" + q]]]
        yield ["f", [*rest, [i, "0"]]]
        yield ["f", [*rest, [i ^ 1, q]]]
        yield ["f", [*rest, [i + 1000, q]]]
        yield ["f", [*rest, [True, q]]]
        yield ["f", [*rest, [i, q + "1"]]]


def test_a_root_that_is_a_leaf_is_refused_where_a_split_is_needed():
    for name in ("covered_half", "strict", "chosen"):
        assert refused(CORE, name, {**ENTRIES[name], "tree": "t"})


SPLITS: list[tuple[str, Callable[[list], list]]] = [
    ("another number", lambda t: [t[0], t[1], "17/4", *t[3:]]),
    ("a number outside", lambda t: [t[0], t[1], "99", *t[3:]]),
    ("no name", lambda t: [t[0], [], *t[2:]]),
    ("an unknown name", lambda t: [t[0], [["nothing", "1"]], *t[2:]]),
    ("a direction that is not normal", lambda t: [t[0], [[t[1][0][0], "2"]], *t[2:]]),
    ("a direction backwards", lambda t: [t[0], [[t[1][0][0], "-1"]], *t[2:]]),
    ("a name twice", lambda t: [t[0], t[1] * 2, *t[2:]]),
    ("a zero", lambda t: [t[0], [*t[1], ["side", "0"]], *t[2:]]),
    ("another relation", lambda t: [">=", *t[1:]]),
    ("a number that is none", lambda t: [t[0], t[1], "4.5", *t[3:]]),
    ("a branch lost", lambda t: t[:4]),
    ("a branch too many", lambda t: [*t, "t"]),
]


@pytest.mark.parametrize(("what", "change"), SPLITS)
def test_a_wrong_split_is_refused(what, change):
    tree = ENTRIES["covered_half"]["tree"]
    assert tree[:3] == ["<=", [["force", "1"]], "9/2"]
    assert refused(CORE, "covered_half", {**ENTRIES["covered_half"], "tree": change(tree)}), what


def test_a_tree_of_another_claim_is_refused():
    assert refused(CORE, "triangle", {**ENTRIES["triangle"], "tree": ENTRIES["covered_half"]["tree"]})


POINTS = [
    ("gap", {"force": "4", "side": "1"}),
    ("gap", {"force": "9/2"}),
    ("gap", {"force": "9/2", "side": "2"}),
    ("gap", {"force": "13", "side": "1"}),
    ("gap", {"force": "9/2", "side": "1", "u": "0"}),
    ("gap", {"force": "4.5", "side": "1"}),
    ("gap", {"force": None, "side": "1"}),
    ("gap", {}),
    ("gap", None),
    ("strict", {"force": "0", "side": "0"}),
    ("strict", {"force": "0", "side": "1"}),
    ("covered_half", {"force": "9/2", "side": "1"}),
    ("chosen", {"force": "0", "side": "1/2"}),
    ("triangle", {"force": "0", "side": "0", "u": "1", "v": "1"}),
]


@pytest.mark.parametrize(("name", "point"), POINTS)
def test_a_point_that_refutes_nothing_is_refused(name, point):
    assert refused(CORE, name, {"kind": "point", "hash": ENTRIES[name]["hash"], "point": point})


@pytest.mark.parametrize(
    ("name", "point"),
    [("strict", {"force": "0", "side": "0"}), ("chosen", {"force": "0", "side": "1/2"}), ("strict", {}),
     ("covered_half", {"force": "-1", "side": "0"}), ("triangle", {"force": "0", "side": "0", "u": "1", "v": "1"})],
)  # fmt: skip
def test_nothing_is_proved_of_nothing(name, point):
    assert refused(CORE, name, {**ENTRIES[name], "point": point})


def system(core: dict, name: str) -> dict:
    return next(f for f in core["fuzzy"] if f["name"] == name)


def claim(core: dict, name: str) -> dict:
    return next(c for c in core["claims"] if c["name"] == name)


def condition(core: dict, name: str) -> list:
    return claim(core, name)["goals"][0]["condition"]


def set_in(value: list | dict, key: object, new: object) -> None:
    value[key] = new


DENIED = ["not", ["is", "side", "yes"]]
CORES: list[tuple[str, str, Callable[[dict], object]]] = [
    ("a higher level", "covered_half", lambda c: set_in(condition(c, "covered_half"), 3, "51/100")),
    ("a corner moved", "covered_half", lambda c: set_in(system(c, "F")["inputs"][0]["terms"][0]["corners"], 2, "3")),
    ("a term lost", "covered_half", lambda c: system(c, "F")["inputs"][0]["terms"].pop()),
    ("a wider range", "covered_half", lambda c: set_in(system(c, "F")["inputs"][0], "high", "13")),
    ("an emptied range", "covered_half", lambda c: set_in(system(c, "F")["inputs"][0], "high", "-1")),
    ("corners out of order", "covered_half", lambda c: system(c, "F")["inputs"][0]["terms"][0]["corners"].reverse()),
    ("a corner lost", "covered_half", lambda c: system(c, "F")["inputs"][0]["terms"][0]["corners"].pop()),
    ("another shape", "covered_half", lambda c: set_in(system(c, "F")["inputs"][0]["terms"][0], "shape", "bell")),
    ("another inference", "covered_half", lambda c: set_in(system(c, "F"), "logic", ["prod", "max"])),
    ("two systems of a name", "covered_half", lambda c: set_in(system(c, "G"), "name", "F")),
    ("a rule lost", "strict", lambda c: system(c, "F")["rules"].pop()),
    ("a fact denied", "strict", lambda c: set_in(system(c, "F")["rules"][0]["premise"], 2, DENIED)),
    ("a rule of an unknown input", "strict", lambda c: set_in(system(c, "F")["rules"][0]["premise"][1], 1, "speed")),
    ("a rule of an unknown term", "strict", lambda c: set_in(system(c, "F")["rules"][0]["premise"][1], 2, "huge")),
    ("the assumption lost", "strict", lambda c: claim(c, "strict")["assume"].clear()),
    ("the assumption weakened", "strict", lambda c: set_in(claim(c, "strict")["assume"][0], 0, ">=")),
    ("a smaller cover", "wider", lambda c: set_in(system(c, "G")["inputs"][0]["terms"][0]["corners"], 3, "9/2")),
    ("another unit of one name", "wider", lambda c: set_in(system(c, "G")["inputs"][0], "unit", "kg.m/s^2*1000")),
    ("the comparison made strict", "wider", lambda c: set_in(condition(c, "wider"), 0, "<")),
    ("the comparison turned", "wider", lambda c: condition(c, "wider").append(condition(c, "wider").pop(1))),
    ("chained to another output", "chained", lambda c: set_in(system(c, "Next")["inputs"][0], "source", ["G", "p"])),
    ("chained to itself", "chained", lambda c: set_in(system(c, "Next")["inputs"][0], "source", ["Next", "answer"])),
    ("a chained rule of another term", "chained", lambda c: set_in(system(c, "Next")["rules"][1]["premise"], 2, "low")),
    ("a conclusion exchanged", "chained", lambda c: set_in(system(c, "Next")["rules"][1], "term", "stay")),
    ("one assumption less", "triangle", lambda c: set_in(claim(c, "triangle")["assume"][0], slice(1, 2), [])),
    ("another order", "triangle", lambda c: set_in(claim(c, "triangle")["assume"][0][1], 0, ">=")),
    ("a wider param", "triangle", lambda c: set_in(c["params"][0], "low", "2")),
    ("the tie at the other side", "chosen", lambda c: set_in(condition(c, "chosen")[2], 0, "<")),
    ("an output applied to half its inputs", "chosen", lambda c: condition(c, "chosen")[1][1][3].pop()),
    ("an input applied twice", "chosen", lambda c: condition(c, "chosen")[1][1][3].append(["side", "1"])),
    ("another value", "chosen", lambda c: set_in(condition(c, "chosen")[1][2], 2, "low")),
    ("a product", "triangle", lambda c: set_in(condition(c, "triangle")[2], 1, ["*", ["param", "u"], ["param", "v"]])),
    ("an unknown operator", "triangle", lambda c: set_in(condition(c, "triangle"), 0, "xor")),
]  # fmt: skip


@pytest.mark.parametrize(("what", "name", "change"), CORES)
def test_a_true_tree_on_a_changed_core_is_refused(what, name, change):
    core = copy.deepcopy(CORE)
    change(core)
    assert refused(core, name, ENTRIES[name]), what


def test_an_input_in_other_units_is_scaled():
    core = copy.deepcopy(CORE)
    condition(core, "chosen")[1][1][3][0][1] = ["scale", "1/1000", 0, ["fuzzyinput", "F", "force"]]
    assert refused(core, "chosen", ENTRIES["chosen"])


def test_another_hash_another_number_of_goals_another_verdict_are_refused():
    read = Core(CORE)
    listed, entry = read.claims["covered_half"], ENTRIES["covered_half"]
    whole = {"schema": "", "claim": "covered_half", "verdict": "proved", "goals": [entry], "rounding": None}
    assert held(read, listed, whole)[0] == "proved"
    for change in (
        {"goals": [{**entry, "hash": ENTRIES["gap"]["hash"]}]},
        {"goals": []},
        {"goals": [entry, entry]},
        {"goals": [{}]},
        {"verdict": "refuted"},
        {"rounding": {}},
    ):
        with pytest.raises(Refused):
            held(read, listed, {**whole, **change})


def test_a_tree_as_deep_as_can_be_is_no_trouble():
    tree: object = "t"
    for _ in range(5000):
        tree = ["<=", [["force", "1"]], "1", tree, "t"]
    assert refused(CORE, "covered_half", {**ENTRIES["covered_half"], "tree": tree})
