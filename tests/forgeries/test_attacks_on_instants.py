"""Runs and cells that would hold if an instant were read wrongly: choices that move, frozen runs, the start's time."""

import importlib.util
import json
from pathlib import Path

import pytest

_spec = importlib.util.spec_from_file_location("hacheck_attacks", Path(__file__).parent / "test_attacks.py")
T = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(T)
outcomes = T.outcomes
X = T.X


def outcome(outcomes, data, entry, verdict, files=None):
    """What the checker says of a claim with one goal."""
    return outcomes(data, files or {}, {"c": entry}, verdict)


def by_run(owner, data, run):
    return {"kind": "run", "run": run, "hash": T.part_hash(data, owner, "goal", "", "")}


@pytest.fixture
def moving_choice():
    """An urgent edge that is due at the start, though each single choice is allowed at one instant only."""
    return T.automaton(
        T.mode("A", ["<=", X, "0"], x="1", y="0"), T.mode("B", True, x="0", y="0"),
        edges=[T.edge("A", "B", [">", X, "0"], {"var": "y", "low": X, "high": ["*", "2", X]})],
        vars=[T.variable("x"), T.variable("y")], init=[T.init(("x", "0"), ("y", "0"))],
    )  # fmt: skip


@pytest.mark.parametrize(
    ("owner", "verdict"),
    [
        (T.claim("can_reach", ["stuck"]), "proved"),
        (T.claim("reach", ["at", "B"], within="5"), "refuted"),
    ],
)
def test_a_run_is_not_stuck_where_choices_move_along(outcomes, moving_choice, owner, verdict):
    data = T.core(moving_choice, owner)
    run = T.run(T.start(x="0", y="0"), "0")
    assert outcome(outcomes, data, by_run(owner, data, run), verdict) != T.ACCEPTED


def test_time_is_zero_at_the_start(outcomes):
    line = T.init(where=["and", [">=", X, ["time"]], ["<=", X, "3"]])
    model = T.automaton(T.mode("A", True, x="0"), vars=[T.variable("x", low="1", high="5")], init=[line])
    owner = T.claim("always", [">=", X, "1"])
    data = T.core(model, owner)
    shown = T.shown(data, owner, T.start(x="1"), ("dwell", "A", "x", ["b"]))
    files = {"c": T.table(T.cell("A", None, x=["1", "3"]))}
    assert outcome(outcomes, data, shown, "proved", files) != T.ACCEPTED


def test_an_ended_run_misses_nothing_while_an_assumption_on_time_fails(outcomes):
    mode = T.mode("A", True, x="1")
    mode["terminal"] = True
    owner = T.claim("reach", [">=", X, "9"], within="10", assume=[["<=", ["time"], "5"]])
    data = T.core(T.automaton(mode), owner)
    assert outcome(outcomes, data, by_run(owner, data, T.run(T.start(), "1")), "refuted") != T.ACCEPTED


@pytest.mark.parametrize(
    "quotient",
    [
        ["/", "1", ["/", "1", ["-", X, X]]],
        ["^", ["/", "1", "0"], "-1"],
        ["^", ["/", "1", "0"], "0"],
        ["/", "1", ["/", "1", "0"]],
    ],
)
def test_the_inverse_of_nothing_is_nothing(outcomes, quotient):
    owner = T.claim("always", ["<=", quotient, "2"])
    data = T.core(T.automaton(T.mode("A", T.UP_TO_1)), owner)
    output = "x" if "x" in json.dumps(quotient) else ""
    shown = T.shown(data, owner, T.start(), ("dwell", "A", output, ["b"]))
    assert outcome(outcomes, data, shown, "proved", {"c": T.LINE}) != T.ACCEPTED
