"""Recorded flows: what they show, and that hacheck finds every damage to them or to what they are said to show."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from tests.unit.hacheck.flowing import Flowing

from hacheck.core import Core
from hacheck.obligations import Setting, established
from hacheck.rational import Refused

Json = Any
DECAY = "automaton A { var x; init R where 1 <= x <= 2; mode R { flow { x' = -x } } }"
VAN_DER_POL = """automaton A {
  var x
  var y
  init Run where 1.25 <= x <= 1.55 and 2.35 <= y <= 2.45
  mode Run { flow { x' = y; y' = (1 - x^2) * y - x } }
}"""
FUNCTIONS = """
const k = 1/3
param a in [0.9, 1]
param unread in [0, 7]
automaton A {
  var x
  var y
  let size = sqrt(x^2 + y^2)
  init R where x == 0.1 and y in [1, 1.1]
  mode R { domain y >= -9; flow { x' = sin(a * y) / (2 + cos(x)) - exp(-y) * k; y' = -log(2 + x) * size + pi / 7 } }
}"""


@pytest.fixture
def flowing(tmp_path: Path) -> Callable[[str, str], Flowing]:
    return lambda text, claim: Flowing(tmp_path, f"{text}\nproperty p on A {{ {claim} }}")


@pytest.mark.parametrize(
    ("text", "claim", "verdict"),
    [
        (DECAY, "within 1; always x >= 0.367", "proved"),
        (DECAY, "within 1; always x >= 0.5", "refuted"),
        (DECAY, "always during [0.5, 1] x <= 1.25", "proved"),
        (DECAY, "can reach x <= 0.4 within 1", "proved"),
        (DECAY, "can reach x <= 0.36 within 1", "refuted"),
        (DECAY, "within 1; always x >= 0.8 or time >= 0.2", "proved"),
        (DECAY, "within 1; always x * exp(time) <= 2.1", "proved"),
        (VAN_DER_POL, "within 2; always y <= 2.68", "proved"),
        (VAN_DER_POL, "within 1; always abs(x) <= 1.9", "refuted"),
        (FUNCTIONS, "within 1; always size <= 1.2", "proved"),
        (FUNCTIONS, "within 1; always y >= 0.8", "refuted"),
    ],
)
def test_recorded_flows_show_their_claims(
    flowing: Callable[[str, str], Flowing], text: str, claim: str, verdict: str
) -> None:
    assert flowing(text, claim).shown() == verdict


def test_pieces_are_split_as_the_record_says(flowing: Callable[[str, str], Flowing]) -> None:
    made = flowing(VAN_DER_POL.replace("1.25 <= x <= 1.55", "0 <= x <= 2"), "within 0.5; always y >= -0.2")
    assert "split" in made.record["starts"][0]["pieces"]
    assert made.shown() == "proved"
    piece = made.record["starts"][0]["pieces"]
    piece["low"], piece["high"] = piece["high"], piece["low"]
    refused(made)


def refused(made: Flowing) -> None:
    with pytest.raises((Refused, KeyError, TypeError, ValueError)):
        made.shown()


Damage = Callable[[Flowing], None]


def _coefficient(made: Flowing) -> None:
    made.steps[3]["x"][0][0][0] -= 1 << made.record["bits"] - 8


def _dropped(made: Flowing) -> None:
    del made.steps[1]


def _shorter(made: Flowing) -> None:
    made.steps.pop()


def _slower(made: Flowing) -> None:
    for step in made.steps:
        step["h"] //= 2


def _narrower(made: Flowing) -> None:
    made.record["starts"][0]["box"]["x"] = ["1", "3/2"]


def _wider(made: Flowing) -> None:
    made.record["starts"][0]["box"]["x"] = ["1", "3"]


def _no_set(made: Flowing) -> None:
    made.record["set"], made.record["monomials"] = [], [[]]


def _starts_gone(made: Flowing) -> None:
    made.record["starts"] = []


def _pieces_gone(made: Flowing) -> None:
    made.record["starts"][0]["pieces"] = {"split": "x", "low": made.record["starts"][0]["pieces"]}


def _another_hash(made: Flowing) -> None:
    made.entry["hash"] = "0" * 64


def _another_automaton(made: Flowing) -> None:
    made.record["automaton"] = "B"


def _another_start(made: Flowing) -> None:
    made.entry["start"]["values"]["x"] = "5/2"


def _no_start(made: Flowing) -> None:
    del made.entry["start"]


def _stronger(made: Flowing) -> None:
    made.core["claims"][0]["goals"][0]["condition"][2] = "2/5"


def _longer(made: Flowing) -> None:
    made.core["claims"][0]["horizon"]["time"] = "2"


def _another_field(made: Flowing) -> None:
    made.core["automata"][0]["modes"][0]["flow"][0]["rate"] = ["*", "-101/100", ["var", "x"]]


def _a_float(made: Flowing) -> None:
    made.steps[0]["h"] = 0.5


def _a_truth(made: Flowing) -> None:
    made.steps[0]["x"][0][0][0] = True


def _backwards(made: Flowing) -> None:
    made.steps[0]["h"] = -made.steps[0]["h"]


def _endless_powers(made: Flowing) -> None:
    made.record["monomials"][1] = [10**9]


def _fine_grid(made: Flowing) -> None:
    made.record["bits"] = 10**6


DAMAGES: list[Damage] = [
    _coefficient, _dropped, _shorter, _slower, _narrower, _wider, _no_set, _starts_gone, _pieces_gone, _another_hash,
    _another_automaton, _another_start, _no_start, _stronger, _longer, _another_field, _a_float, _a_truth, _backwards,
    _endless_powers, _fine_grid,
]  # fmt: skip


@pytest.mark.parametrize("damage", DAMAGES)
def test_damages_are_found(flowing: Callable[[str, str], Flowing], damage: Damage) -> None:
    made = flowing(DECAY, "within 1; always x >= 0.367")
    before = json.dumps([made.core, made.certificate, made.cells])
    damage(made)
    assert before != json.dumps([made.core, made.certificate, made.cells])
    refused(made)


def _other_values(made: Flowing) -> None:
    made.entry["run"]["values"]["x"] = "2"


def _impossible_values(made: Flowing) -> None:
    made.entry["run"]["values"]["x"] = "1/10"


def _too_early(made: Flowing) -> None:
    made.entry["run"]["last"] = "1/10"


def _too_late(made: Flowing) -> None:
    made.entry["run"]["last"] = "2"


def _with_a_jump(made: Flowing) -> None:
    made.entry["run"]["steps"] = [{"dwell": "0", "edge": 0, "values": {}}]


@pytest.mark.parametrize(
    "damage", [_other_values, _impossible_values, _too_early, _too_late, _with_a_jump, _slower, _another_hash]
)
def test_damages_of_runs_are_found(flowing: Callable[[str, str], Flowing], damage: Damage) -> None:
    made = flowing(DECAY, "within 1; always x >= 0.5")
    assert made.shown() == "refuted"
    damage(made)
    refused(made)


def test_a_record_of_another_field_encloses_the_right_solutions(flowing: Callable[[str, str], Flowing]) -> None:
    """What the checker finds is about the core's field, wherever the polynomials come from."""
    made = flowing(DECAY, "within 1; always x >= 0.3")
    made.core["automata"][0]["modes"][0]["flow"][0]["rate"] = ["*", "-21/20", ["var", "x"]]
    widths = dict(end_enclosures(made))
    low, high = widths["x"]
    assert low <= math.exp(-1.05) <= 2 * math.exp(-1.05) <= high
    assert low < 0.99 * math.exp(-1.05)


def end_enclosures(made: Flowing) -> list[tuple[str, tuple[float, float]]]:
    """The states of the last step, for the core as it is."""
    from hacheck.enclosures import at_end, bounds, widened
    from hacheck.records import Record
    from hacheck.scope import Scope

    core = Core(made.core)
    scope = Scope(core, next(iter(core.automata.values())), False)
    record = Record(scope, made.record)
    box = {v: (Fraction(low), Fraction(high)) for v, (low, high) in made.record["starts"][0]["box"].items()}
    here, states = record.start(next(iter(scope.modes)), box), {}
    for stay in (stay for step in made.steps for stay in record.steps(here, {}, step)):
        states, here = stay.states, stay.after
    ends = {v: bounds(widened(at_end(m), m.radius)) for v, m in states.items() if v in scope.types}
    return [(v, (low / record.space.one, high / record.space.one)) for v, (low, high) in ends.items()]


def test_equal_records_are_looked_at_once_and_each_claim_by_itself(tmp_path: Path) -> None:
    """A run with other numbers but the same record is another run."""
    made = Flowing(tmp_path, f"{DECAY}\nproperty p on A {{ within 1; always x >= 0.5 }}")
    core = Core(made.core)
    setting = Setting(core, next(iter(core.automata.values())), False, lambda name: json.loads(json.dumps(made.record)))
    claim = next(iter(core.claims.values()))
    assert established(core, claim, made.certificate, lambda _, rounding: setting)[0] == "refuted"
    assert established(core, claim, made.certificate, lambda _, rounding: setting)[0] == "refuted"
    made.entry["run"]["values"]["x"] = "2"
    with pytest.raises(Refused):
        established(core, claim, made.certificate, lambda _, rounding: setting)
    assert len(setting.records) == 1
