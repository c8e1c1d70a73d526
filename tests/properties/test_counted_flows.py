"""Random turning flows across random circles and lines: what is proved of the number of jumps holds on sampled runs."""

from __future__ import annotations

import random
from pathlib import Path

import numpy as np
import pytest
from tests.soak.runs import stepped

from haverify.analyses.hybrid.counted import proved_by_counting
from haverify.analyses.hybrid.model import hybrid_model
from haverify.analyses.hybrid.question import question_of
from haverify.run.examine import read

TEXT = """
spec "turning" version "1.0" unitless
enum Count = 0..9
automaton A {{
  var x
  var y
  var n: Count
  init Out where {low} <= x <= {high} and y == 0 with {{ n := 0 }}
  mode Out {{
    domain {g} >= 0
    flow {{ x' = {fx}; y' = {fy} }}
    urgent edge enter: -> In when {g} < 0 do n := if n < 9 then n + 1 else 9
  }}
  mode In {{
    domain {g} <= 0
    flow {{ x' = {fx}; y' = {fy} }}
    urgent edge leave: -> Out when {g} > 0 do n := if n < 9 then n + 1 else 9
  }}
}}
property p on A {{
  within {end}
  always during [{end}, {end}] {claim}
}}
"""


def instance(seed: int) -> dict[str, str]:
    """A damped and bent turn from around (2, 0), and a circle or a line near its way."""
    r = random.Random(seed)
    damping, bend = round(r.uniform(0, 0.1), 3), round(r.uniform(-0.1, 0.1), 3)
    low = round(r.uniform(1.6, 2), 3)
    if r.random() < 0.6:
        a, b, size = round(r.uniform(-0.5, 0.5), 2), round(r.uniform(-3, -1.5), 2), round(r.uniform(0.3, 1), 2)
        g = f"((x - ({a}))^2 + (y - ({b}))^2 - {size}^2)"
    else:
        g = f"(y + {round(r.uniform(1.3, 1.9), 2)})"
    return {
        "low": f"{low}", "high": f"{round(low + r.uniform(0.05, 0.4), 3)}", "g": g, "fx": "y",
        "fy": f"(-x - {damping} * y + {bend} * x * x)", "end": f"{round(r.uniform(2, 7), 2)}",
    }  # fmt: skip


def counts(made: dict[str, str]) -> set[int]:
    """How often sampled runs change the sign of `g`; -1 where one begins below 0."""
    field, g = (compile(made[k].replace("^", "**"), k, "eval") for k in ("fy", "g"))
    states = np.stack([np.linspace(float(made["low"]), float(made["high"]), 41), np.zeros(41)])
    steps = 800
    signs = []
    for _ in range(steps + 1):
        signs.append(np.sign(eval(g, {"x": states[0], "y": states[1]})))
        states = stepped(lambda s: np.stack([s[1], eval(field, {"x": s[0], "y": s[1]})]), states,
                         float(made["end"]) / steps)  # fmt: skip
    changes = (np.diff(np.array(signs), axis=0) != 0).sum(axis=0)
    return {int(c) if first > 0 else -1 for c, first in zip(changes, signs[0], strict=True)}


def is_proved(made: dict[str, str], numbers: set[int], path: Path) -> bool:
    claim = " or ".join(f"n == {k}" for k in sorted(numbers))
    path.write_text(TEXT.format(**made, claim=claim), encoding="utf-8")
    spec, found, _ = read(str(path))
    assert spec is not None, found
    (claim,) = spec.claims
    model = hybrid_model(spec, spec.automata[0], [g.condition for g in claim.goals])
    shown = proved_by_counting(question_of(model, claim, claim.goals[0]))
    assert shown is not None
    return shown


@pytest.fixture(scope="module")
def instances() -> list[tuple[dict[str, str], set[int]]]:
    made = [instance(seed) for seed in range(24)]
    known = [(m, counts(m)) for m in made]
    return [(m, c) for m, c in known if -1 not in c][:10]


def test_no_number_of_jumps_that_a_run_makes_is_excluded(
    instances: list[tuple[dict[str, str], set[int]]], tmp_path: Path
) -> None:
    for made, seen in instances:
        left_out = min(seen)
        others = (seen | {left_out + 1, left_out + 2}) - {left_out}
        assert not is_proved(made, others, tmp_path / "a.ha"), made


def test_most_numbers_are_shown(instances: list[tuple[dict[str, str], set[int]]], tmp_path: Path) -> None:
    shown = sum(is_proved(made, seen, tmp_path / "a.ha") for made, seen in instances)
    mixed = sum(len(seen) > 1 for _, seen in instances)
    assert shown >= len(instances) // 2
    assert mixed >= 2
