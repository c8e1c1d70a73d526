"""Runs with jumps along records, goals that are to be met, formulas: shown, and no damage goes unseen."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from typing import Any

import pytest
from tests.unit.hacheck.flowing import Flowing
from tests.unit.hacheck.test_recorded_jumps import BALL

from hacheck.core import Core
from hacheck.obligations import Question, Setting, canonical_hash
from hacheck.rational import Refused

CLAIMS = [
    ("within 1; always v <= 3.2", "refuted"),
    ("can reach jump(bounce) within 1", "proved"),
    ("can reach at(Rise) and v <= 1 within 1", "proved"),
    ("reach jump(bounce) within 0.6", "proved"),
    ("reach at(Rise) and v <= 1 within 1", "proved"),
    ("reach at(Rise) and v <= 1 within 0.5", "refuted"),
    ("reach jump(stop) within 0.6", "refuted"),
    ("stl globally[0, 0.7] (h <= 1.21 and v <= 3.6)", "proved"),
    ("stl globally[0.1, 0.7] v <= 3.2", "refuted"),
    ("stl eventually[0.3, 0.6] h <= 0.4", "proved"),
]


@pytest.fixture(scope="module")
def shown(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Flowing]:
    """The ball with a claim, decided once; copies of it, to be damaged."""
    known: dict[str, Flowing] = {}

    def made(claim: str) -> Flowing:
        if claim not in known:
            folder = tmp_path_factory.mktemp("ball")
            known[claim] = Flowing(folder, f"{BALL}\nproperty p on A {{ {claim} }}")
        return deepcopy(known[claim])

    return made


def rehashed(made: Flowing) -> Flowing:
    """With the hash that the core, damaged or not, asks for."""
    core = Core(made.core)
    setting = Setting(core, next(iter(core.automata.values())), False, made.cells.__getitem__)
    claim = next(iter(core.claims.values()))
    question = Question(setting, claim, claim["goals"][0])
    made.entry["hash"] = canonical_hash(["haverify.obligation/1", setting.hash, question.hash, "flow", "Fall", ""])
    return made


@pytest.mark.parametrize(("claim", "verdict"), CLAIMS)
def test_goals_along_records(shown: Callable[[str], Flowing], claim: str, verdict: str) -> None:
    assert rehashed(shown(claim)).shown() == verdict


Json = Any
Damage = Callable[[Flowing], None]


def _run(made: Flowing) -> Json:
    return made.entry["run"]


def _earlier(made: Flowing) -> None:
    _run(made)["last"] = "-1/1000"


def _much_later(made: Flowing) -> None:
    _run(made)["last"] = "9"


def _another_dwell(made: Flowing) -> None:
    _run(made)["steps"][0]["dwell"] = "1/10"


def _another_edge(made: Flowing) -> None:
    _run(made)["steps"][0]["edge"] = 2


def _no_edge(made: Flowing) -> None:
    _run(made)["steps"] = []


def _a_choice(made: Flowing) -> None:
    _run(made)["steps"][0]["values"] = {"v": "1"}


def _another_start(made: Flowing) -> None:
    _run(made)["values"]["h"] = "3"


def _another_value(made: Flowing) -> None:
    _run(made)["params"]["c"] = "1/2"


def _stretch_gone(made: Flowing) -> None:
    made.after(0)["jumps"] = []


def _another_landing(made: Flowing) -> None:
    made.after(1)["x"][1] = [made.after(1)["x"][1][0] * 2]


def _steps_gone(made: Flowing) -> None:
    made.after(0)["steps"] = made.after(0)["steps"][:2]


def _harder_guard(made: Flowing) -> None:
    made.core["automata"][0]["edges"][0]["guard"] = ["<", ["var", "v"], "-9"]


def _doubtful_guard(made: Flowing) -> None:
    made.core["automata"][0]["edges"][0]["guard"] = ["<", ["var", "h"], "0"]


def _narrower_target(made: Flowing) -> None:
    made.core["automata"][0]["modes"][1]["domain"] = [">=", ["var", "v"], "9"]


def _narrower_range(made: Flowing) -> None:
    made.core["automata"][0]["vars"][0] |= {"low": "1/2", "high": "9"}


RUNS = [
    _earlier, _much_later, _another_dwell, _another_edge, _no_edge, _a_choice, _another_start, _another_value,
    _stretch_gone, _steps_gone, _harder_guard, _doubtful_guard, _narrower_target, _narrower_range,
]  # fmt: skip


@pytest.mark.parametrize("damage", RUNS)
def test_damages_of_runs_with_jumps_are_found(shown: Callable[[str], Flowing], damage: Damage) -> None:
    made = shown("within 1; always v <= 3.2")
    assert made.entry["kind"] == "flow_run" and len(made.entry["run"]["steps"]) == 1
    damage(made)
    with pytest.raises((Refused, KeyError, TypeError, ValueError, IndexError)):
        rehashed(made).shown()


def _sooner(made: Flowing) -> None:
    made.core["claims"][0]["goals"][0]["within"] = "2/5"


MET = [
    _sooner, _stretch_gone, _another_landing, _steps_gone, _harder_guard, _doubtful_guard, _narrower_target,
    _narrower_range,
]  # fmt: skip


@pytest.mark.parametrize("damage", MET)
def test_what_has_to_be_met_is_met_by_runs_that_go_on(shown: Callable[[str], Flowing], damage: Damage) -> None:
    made = shown("reach at(Rise) and v <= 1 within 1")
    assert made.entry["kind"] == "flowpipe"
    damage(made)
    with pytest.raises((Refused, KeyError, TypeError, ValueError, IndexError)):
        rehashed(made).shown()


@pytest.mark.parametrize("damage", [_steps_gone, _doubtful_guard, _narrower_target])
def test_a_formula_asks_for_runs_that_go_on(shown: Callable[[str], Flowing], damage: Damage) -> None:
    made = shown("stl globally[0, 0.7] (h <= 1.21 and v <= 3.6)")
    damage(made)
    with pytest.raises((Refused, KeyError, TypeError, ValueError, IndexError)):
        rehashed(made).shown()


def test_a_run_that_meets_its_goal_at_a_border_misses_nothing(shown: Callable[[str], Flowing]) -> None:
    """Just before it bounces the ball is at `h == 0`, which the steps before do not show."""
    made = shown("reach jump(stop) within 0.6")
    made.core["claims"][0]["goals"][0]["condition"] = ["and", ["at", "Fall"], ["<=", ["var", "h"], "0"]]
    with pytest.raises(Refused):
        rehashed(made).shown()
