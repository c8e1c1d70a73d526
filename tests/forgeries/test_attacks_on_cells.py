"""Cells, parts and trees that would hold if a step of the checker's one procedure were taken too far."""

import importlib.util
from pathlib import Path

import pytest

_spec = importlib.util.spec_from_file_location("hacheck_attacks", Path(__file__).parent / "test_attacks.py")
T = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(T)
outcomes = T.outcomes
X, Y, P, ACCEPTED = T.X, ["var", "y"], T.P, T.ACCEPTED


def decided(outcomes, model, owner, *parts, cells=None, **changes):
    """Whether a claim shown on cells is accepted."""
    files = {"c": T.table(*cells)} if cells else None
    return T.forged(outcomes, model, owner, *parts, files=files, **changes) == ACCEPTED


def test_a_start_bounded_through_a_param_is_not_cut_to_the_declared_range(outcomes):
    line = T.init(where=["and", ["<=", "0", X], ["<=", ["*", P, X], "4"]])
    model = T.automaton(T.mode("A", x="0"), vars=[T.variable("x", low="0", high="1")], init=[line])
    owner, cells = T.claim("always", T.UP_TO_1), [T.cell("A", None, x=["0", "1"])]
    begin, params = T.start({"p": "1"}), [T.param("p", "1", "2")]
    parts = [("dwell", "A", "x", ["b"])]
    assert not decided(outcomes, model, owner, *parts, begin=begin, params=params, cells=cells)


@pytest.mark.parametrize(
    ("bound", "tree", "good"), [("5", "b", True), ("5", None, True), ("6", "b", False), ("6", None, False)]
)
def test_an_edge_is_not_said_not_to_be_taken(outcomes, bound, tree, good):
    owner = T.claim("always", ["implies", T.JUMPED, [">=", X, bound]])
    parts = [("jump", "A -> B", "x", [tree]), ("jump", "B -> C", "x", [tree])]
    assert (T.forged(outcomes, T.CHAIN, owner, *parts, files=T.CHAIN_CELLS) == ACCEPTED) is good


@pytest.mark.parametrize(
    ("target", "guard", "dwell", "good"),
    [
        (True, ["==", X, "1"], "1", True),
        (True, ["==", X, "1"], "3/4", False),  # from 0 the run stays longer
        (["<=", X, "1/2"], ["==", X, "1"], "1", False),  # no outcome is possible, so the edge never fires
        (True, ["and", ["==", X, "1"], [">=", Y, "1"]], "1", False),  # y may be too small when x is 1
        (True, ["and", ["==", X, "1"], [">=", Y, "0"]], "1", True),
    ],
)
def test_an_equation_ends_a_stay_only_where_its_edge_is_enabled(outcomes, target, guard, dwell, good):
    modes = [T.mode("A", True, x="1", y="0"), T.mode("B", target, x="0", y="0")]
    line = T.init(where=["and", *(["<=", "0", v] for v in (X, Y)), ["<=", X, "1/2"], ["<=", Y, "2"]])
    model = T.automaton(*modes, edges=[T.edge("A", "B", guard)], vars=[T.variable(v) for v in "xy"], init=[line])
    cells = [T.cell("A", dwell, x=["0", "1/2"], y=["0", "2"]), T.cell("B", None, x=["1", "1"], y=["0", "2"])]
    owner = T.claim("always", ["implies", ["at", "A"], T.UP_TO_1])
    parts = [("dwell", "A", "x", ["b"])]
    assert decided(outcomes, model, owner, *parts, begin=T.start(x="0", y="0"), cells=cells) is good


def test_a_stay_that_only_a_horizon_ends_is_not_ended_elsewhere(outcomes):
    horizon = {"time": "1", "jumps": None}
    timed, free = T.claim("always", T.UP_TO_1, "timed", horizon=horizon), T.claim("always", T.UP_TO_1, "free")
    data = T.core(T.automaton(T.mode("A")), timed, free)
    files = {"t": T.table(T.cell("A", "1", ["0", "0"], x=["0", "0"]), time="1"), "u": T.LINE}
    parts = [("dwell", "A", "x", ["b"])]
    entries = {c["name"]: T.shown(data, c, T.start(), *parts, cells=f) for c, f in ((timed, "t"), (free, "u"))}
    assert outcomes(data, files, entries) == {"timed": "accepted", "free": "refused"}


def test_what_a_tree_eliminates_is_there_again_for_the_next(outcomes):
    first, second = (T.claim("always", ["<=", ["+", P, X], q], n) for q, n in (("2", "a"), ("3/2", "b")))
    data = T.core(T.automaton(T.mode("A", T.UP_TO_1)), first, second, params=[T.param("p", "0", "1")])
    begin = T.start({"p": "0"})
    entries = {c["name"]: T.shown(data, c, begin, ("dwell", "A", "x", [["e", ["p"], "b"]])) for c in (first, second)}
    assert outcomes(data, {"c": T.LINE}, entries) == {"a": "accepted", "b": "refused"}


def test_a_constant_of_the_top_level_does_not_read_what_hides_another(outcomes):
    constants = [T.rounded("k", "1", None), T.rounded("c", ["const", "k"], None)]
    model = T.automaton(T.mode("A", x="0"), constants=[T.rounded("k", "5", None)], init=[T.init(("x", "3"))])
    owner, cells = T.claim("always", ["<=", X, ["const", "c"]]), [T.cell("A", None, x=["3", "3"])]
    parts = [("dwell", "A", "x", ["b"])]
    assert not decided(outcomes, model, owner, *parts, begin=T.start(x="3"), constants=constants, cells=cells)


@pytest.mark.parametrize(
    ("condition", "good"),
    [
        (["or", ["<", X, "1/2"], [">=", X, "1/2"]], True),
        (["or", ["<", X, "1/2"], ["<=", X, "1/2"]], False),
        (["or", ["<", X, "1/2"], [">", X, "1/2"]], False),
        (["or", ["==", X, "1/2"], ["!=", X, "1/2"]], True),
    ],
)
def test_alternatives_leave_no_gap(outcomes, condition, good):
    model, parts = T.automaton(T.mode("A", T.UP_TO_1)), [("dwell", "A", "x", ["b"])]
    assert decided(outcomes, model, T.claim("always", condition), *parts) is good


@pytest.mark.parametrize(("at", "good"), [("1/2", True), ("0", False), ("1", False), ("2", False)])
def test_a_box_is_split_inside_also_where_a_variable_falls(outcomes, at, good):
    model = T.automaton(T.mode("A", [">=", X, "0"], x="-1"), init=[T.init(("x", "1"))])
    parts, cells = [("dwell", "A", "x", [["s", "x", at, "b", "b"]])], [T.cell("A", "1", x=["1", "1"])]
    owner = T.claim("always", [">=", X, "0"])
    assert decided(outcomes, model, owner, *parts, begin=T.start(x="1"), cells=cells) is good


def test_a_bound_that_is_touched_but_not_passed_ends_no_stay(outcomes):
    model = T.automaton(
        T.mode("A", T.UP_TO_1, x="0", y="1"), vars=[T.variable(v) for v in "xy"], init=[T.init(("x", "1"), ("y", "0"))]
    )
    parts, cells = [("dwell", "A", "y", ["b"])], [T.cell("A", "0", x=["1", "1"], y=["0", "0"])]
    owner = T.claim("always", ["<=", Y, "0"])
    assert not decided(outcomes, model, owner, *parts, begin=T.start(x="1", y="0"), cells=cells)


@pytest.mark.parametrize(("high", "good"), [("2", True), ("3/2", False)])
def test_all_entries_are_followed_through_an_edge(outcomes, high, good):
    modes = [T.mode("A", True, x="1", y="1"), T.mode("B", True, x="0", y="0")]
    line = T.init(("y", "0"), where=["and", ["<=", "0", X], ["<=", X, "1"]])
    model = T.automaton(
        *modes, edges=[T.edge("A", "B", [">=", Y, "1"])], vars=[T.variable(v) for v in "xy"], init=[line]
    )
    cells = [T.cell("A", "1", x=["0", "1"], y=["0", "0"]), T.cell("B", None, x=["1", high], y=["1", "1"])]
    parts = [("dwell", "A", "y", ["b"]), ("dwell", "B", "y", ["b"])]
    begin = T.start(x="0", y="0")
    assert decided(outcomes, model, T.claim("always", ["<=", Y, "1"]), *parts, begin=begin, cells=cells) is good
