"""Laws of jumps over a span of time at guards that compare several variables: sampled runs stay in the tree."""

from __future__ import annotations

import random
from collections.abc import Sequence
from pathlib import Path

import pytest

from haverify.analyses.hybrid.decide import decide_flow
from haverify.analyses.hybrid.model import hybrid_model
from haverify.analyses.hybrid.question import Question, follow, question_of
from haverify.evidence.verdict import Proved
from haverify.model.core import to_core
from haverify.run.examine import read
from haverify.solvers.kernel import Stretch

SLACK = 1e-2  # a sampled run jumps up to a step late
STEP = 1 / 512

CRUISE = """spec "Cruise" version "1.0" unitless
input lead in [-1, 1]
automaton Cruise {{
  var gap
  var closing
  var speed
  let command = 0.25 * (gap - 5 - 1.5 * speed) + 0.8 * closing
  init Keep where 60 <= gap <= 61 and closing == 0 and 28 <= speed <= 28.5
  mode Keep {{
    domain gap >= 5 + 1.5 * speed
    flow {{ gap' = closing; closing' = lead - 0.5 * (30 - speed); speed' = 0.5 * (30 - speed) }}
    urgent edge follow: -> Follow when gap <= 5 + 1.5 * speed{slowed}
  }}
  mode Follow {{
    domain gap <= 8 + 1.5 * speed
    flow {{ gap' = closing; closing' = lead - command; speed' = command }}
    urgent edge free: -> Keep when gap >= 8 + 1.5 * speed
  }}
}}
property apart on Cruise {{ within 5; always gap >= 20 }}
property far_apart on Cruise {{ within 5; always gap >= 44 }}
"""
SLOWED = {"as it is": ("", 1.0), "slowed": (" do speed := 0.98 * speed", 0.98)}


def question(folder: Path, slowed: str) -> Question:
    path = folder / "cruise.ha"
    path.write_text(CRUISE.format(slowed=slowed), encoding="utf-8")
    spec, _, found = read(str(path))
    assert spec is not None, found
    claim = spec.claims[0]
    model = hybrid_model(spec, spec.automata[0], [g.condition for g in claim.goals])
    return question_of(model, claim, claim.goals[0])


def walked(chance: random.Random, factor: float, strength: float = 1.0) -> list[tuple[float, int, list[float]]]:
    """A run under inputs that are switched: instants, modes (0: Keep), states."""
    mode, state, time = 0, [chance.choice([60.0, 61.0]), 0.0, chance.uniform(28, 28.5)], 0.0
    period = chance.choice([0.2, 1.0, 3.0, 9.0])
    levels = [strength * chance.choice([-1, 1, chance.uniform(-1, 1)]) for _ in range(30)]
    out = []
    while time < 5:
        out.append((time, mode, list(state)))
        gap, closing, speed = state
        excess = gap - 5 - 1.5 * speed
        pull = 0.5 * (30 - speed) if mode == 0 else 0.25 * excess + 0.8 * closing
        lead = levels[int(time / period)]
        state = [
            gap + STEP * closing + STEP**2 / 2 * (lead - pull),
            closing + STEP * (lead - pull),
            speed + STEP * pull,
        ]
        time += STEP
        excess = state[0] - 5 - 1.5 * state[2]
        if mode == 0 and excess <= 0:
            mode, state[2] = 1, factor * state[2]
        elif mode == 1 and excess >= 3:
            mode = 0
    return out


def outside(tree: Sequence[Stretch], run: Sequence[tuple[float, int, list[float]]]) -> float | None:
    """The first instant of a run that no stage of the tree has."""
    stages = [(s.mode, g) for s in tree for g in s.stages]
    for time, mode, state in run[:: len(run) // 40]:
        here = (g for m, g in stages if m == mode and g.time[0] - STEP <= time <= g.time[1] + STEP)
        if not any(all(a - SLACK <= x <= b + SLACK for x, (a, b) in zip(state, g.states, strict=False)) for g in here):
            return time
    return None


@pytest.mark.parametrize("kind", SLOWED)
def test_runs_that_jump_at_different_times_stay_inside(tmp_path: Path, kind: str) -> None:
    text, factor = SLOWED[kind]
    asked = question(tmp_path, text)
    start = asked.model.starts[0]
    tree = follow(asked, start, start.box, "horizon")
    assert all(s.end in ("horizon", "jumped", "cut") for s in tree)
    chance = random.Random(7)
    runs = [walked(chance, factor) for _ in range(40)]
    assert sum(any(mode == 1 for _, mode, _ in run) for run in runs) > 10
    assert all(outside(tree, run) is None for run in runs)


def test_what_is_no_run_is_noticed(tmp_path: Path) -> None:
    """The look above can fail: with a stronger input, and where the wrong mode is entered."""
    asked = question(tmp_path, "")
    start = asked.model.starts[0]
    tree = follow(asked, start, start.box, "horizon")
    chance = random.Random(7)
    assert any(outside(tree, walked(chance, 1.0, strength=1.6)) is not None for _ in range(10))
    wrong = [(time, 1 - mode, state) for time, mode, state in walked(chance, 1.0)]
    assert outside(tree, wrong) is not None


def test_a_gap_is_kept_and_no_more_is_claimed(tmp_path: Path) -> None:
    """Constant braking leaves a gap below 44: the claim of so much is not proved."""
    question(tmp_path, "")
    spec, _, _ = read(str(tmp_path / "cruise.ha"))
    assert spec is not None
    core = to_core(spec)
    apart, far_apart = (decide_flow(spec, spec.automata[0], c, core).verdict for c in spec.claims)
    assert isinstance(apart, Proved)
    assert not isinstance(far_apart, Proved)
