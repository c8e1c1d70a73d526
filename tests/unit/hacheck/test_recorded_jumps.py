"""Recorded flows with jumps: crossings are found again, and no jump, stretch or branch can be left out or changed."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest
from tests.unit.hacheck.flowing import Flowing

from hacheck.rational import Refused

Json = Any
BALL = """
param c in [0.7, 0.75]
automaton A {
  var h
  var v
  init Fall where 0.95 <= h <= 1.2 and v == 0
  mode Fall {
    domain h >= 0
    flow { h' = v; v' = -9.81 + 0.1 * v^2 }
    urgent edge bounce: -> Rise when h <= 0 and v < 0 do v := -c * v
  }
  mode Rise {
    domain v >= 0
    flow { h' = v; v' = -9.81 - 0.1 * v^2 }
    edge turn: -> Fall when v == 0
    edge stop: -> Fall when h >= 9 do v := 0
  }
}
"""


@pytest.fixture
def ball(tmp_path: Path) -> Callable[[str], Flowing]:
    return lambda claim: Flowing(tmp_path, f"{BALL}\nproperty p on A {{ {claim} }}")


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Flowing:
    """A claim with a record that shows it."""
    claim = "property p on A { within 1; always v <= 3.6 and h <= 1.21 }"
    made = Flowing(tmp_path_factory.mktemp("ball"), f"{BALL}\n{claim}")
    assert made.shown() == "proved"
    return made


@pytest.mark.parametrize(
    ("claim", "verdict"),
    [
        ("within 1; always h <= 1.21", "proved"),
        ("within 1; always v <= 3.6", "proved"),
        ("within 0.6; always jump(bounce) implies time >= 0.44 and v < pre(-v)", "proved"),
        ("within 1; always at(Rise) implies time >= 0.44", "proved"),
        ("can reach jump(stop) within 1", "refuted"),
        ("can reach at(Rise) and h >= 0.6 within 1", "refuted"),
    ],
)
def test_flows_with_jumps_show_their_claims(ball: Callable[[str], Flowing], claim: str, verdict: str) -> None:
    assert ball(claim).shown() == verdict


def _no_jump(made: Flowing) -> None:
    made.after(0)["jumps"] = []


def _jump_left_out(made: Flowing) -> None:
    del made.after(0)["jumps"]


def _another_edge(made: Flowing) -> None:
    made.after(1)["edge"] = 1


def _another_landing(made: Flowing) -> None:
    made.after(1)["x"][1][0] -= 1 << made.record["bits"] - 3


def _no_landing(made: Flowing) -> None:
    del made.after(1)["x"]


def _later_step_gone(made: Flowing) -> None:
    made.after(1)["steps"].pop()


def _step_before_the_jump_gone(made: Flowing) -> None:
    made.after(0)["steps"].pop()


def _steps_after_the_jump_gone(made: Flowing) -> None:
    made.after(2)["steps"] = []


def _backwards(made: Flowing) -> None:
    steps = made.after(0)["steps"]
    paced = next(s for s in steps if isinstance(s["h"], list))
    paced["h"][0] = -paced["h"][0]


def _another_pace(made: Flowing) -> None:
    paced = next(s for s in made.after(0)["steps"] if isinstance(s["h"], list))
    paced["h"][1] += 1 << made.record["bits"] - 5


def _another_reset(made: Flowing) -> None:
    made.core["automata"][0]["edges"][0]["resets"][0]["to"] = ["*", "-6/5", ["var", "v"]]


def _another_guard(made: Flowing) -> None:
    made.core["automata"][0]["edges"][2]["guard"] = [">=", ["var", "h"], "1/10"]


def _wider_domain(made: Flowing) -> None:
    made.core["automata"][0]["modes"][0]["domain"] = [">=", ["var", "h"], "-1"]


DAMAGES = [
    _no_jump, _jump_left_out, _another_edge, _another_landing, _no_landing, _later_step_gone,
    _step_before_the_jump_gone, _steps_after_the_jump_gone, _backwards,
    _another_pace, _another_reset, _another_guard, _wider_domain,
]  # fmt: skip


@pytest.mark.parametrize("damage", DAMAGES)
def test_damages_to_jumps_are_found(whole: Flowing, damage: Callable[[Flowing], None]) -> None:
    made = deepcopy(whole)
    made.entry["hash"] = ""  # the core's damages change the hash, which is not what is tested here
    damage(made)
    made.entry["hash"] = _hash(made)
    with pytest.raises((Refused, KeyError, TypeError, ValueError, IndexError)):
        made.shown()


def _hash(made: Flowing) -> str:
    from hacheck.core import Core
    from hacheck.obligations import Question, Setting, canonical_hash

    core = Core(made.core)
    setting = Setting(core, next(iter(core.automata.values())), False, made.cells.__getitem__)
    claim = next(iter(core.claims.values()))
    question = Question(setting, claim, claim["goals"][0])
    return canonical_hash(["haverify.obligation/1", setting.hash, question.hash, "flow", "Fall", ""])


def test_the_hash_of_the_damages_is_right(whole: Flowing) -> None:
    """So that it is the damage, not the hash, that the test above sees."""
    assert whole.entry["hash"] == _hash(whole)


def test_a_strict_bound_fails_at_the_border_itself(ball: Callable[[str], Flowing]) -> None:
    """Before the impact `h > 0`, at it `h == 0`: that is no part of what holds strictly inside."""
    made = ball("within 0.6; always at(Fall) implies h >= 0")
    assert made.shown() == "proved"
    condition = made.core["claims"][0]["goals"][0]["condition"]
    assert condition[2][0] == ">="
    condition[2][0] = ">"
    made.entry["hash"] = _hash(made)
    with pytest.raises(Refused):
        made.shown()
