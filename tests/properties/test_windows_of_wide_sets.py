"""Laws of wide sets that cross a border at paces of their own: windows of time are judged at the time of each run.

States of a set differ in time after its pace was changed (decision 51). What sampled runs do in a window, or at a jump,
is never denied; bounds are far enough from what was seen that errors of the samples do not count.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from fractions import Fraction
from pathlib import Path

import pytest
from tests.properties.hybrid import Instant, Jump, Machine, Simulator

from haverify.analyses.portfolio import decide_all
from haverify.evidence.verdict import Proved, Refuted
from haverify.run.examine import read

HORIZON, RUNS = 1.5, 30
NEAR = 1e-9
Seen = Callable[[Instant], bool]


def machine(chance: random.Random) -> Machine:
    """A set that is wide along its way crosses `x = 1`; what it does then depends on where it was."""
    speed, turn, kick = (round(chance.uniform(*ends), 2) for ends in ((0.8, 1.5), (-0.8, 0.8), (-1.0, 1.0)))
    low, width = round(chance.uniform(0.0, 0.4), 2), chance.choice([0.1, 0.25, 0.4])
    modes = {
        "Before": ("x <= 1", {"x": f"{speed} + 0.2 * y", "y": f"{turn} * x - 0.3 * y"}),
        "After": ("true", {"x": f"-0.5 * x + {turn} * y", "y": f"{kick} - 0.5 * y"}),
    }
    cross = Jump("cross", "Before", "After", "x >= 1", {"y": f"0.5 * y + {kick}"})
    return Machine("wide", "Before", {"x": (low, low + width), "y": (0.0, 0.1)}, modes, (cross,))


def runs(made: Machine, chance: random.Random) -> list[list[Instant]]:
    simulator = Simulator(made, chance)
    return [list(simulator.run(simulator.start(made.start), HORIZON)) for _ in range(RUNS)]


def greatest(sampled: Sequence[Sequence[Instant]], is_asked: Seen) -> list[float]:
    """The greatest `y` of each run where it is asked for."""
    found = [[i.values["y"] for i in run if is_asked(i)] for run in sampled]
    return [max(values) for values in found if values]


@pytest.mark.parametrize("seed", range(6))
def test_what_runs_do_in_a_window_is_never_denied(tmp_path: Path, seed: int) -> None:
    chance = random.Random(seed)
    made = machine(chance)
    sampled = runs(made, chance)
    first = round(chance.uniform(0.3, 0.8), 2)
    last = round(first + chance.uniform(0.1, 0.5), 2)
    in_window = greatest(sampled, lambda i: first - NEAR <= i.values["time"] <= last + NEAR)
    landed = greatest(sampled, lambda i: i.jump is not None)
    latest = max(i.values["time"] for run in sampled for i in run if i.jump is not None)
    assert len(in_window) == RUNS
    window = f"time >= {first} and time <= {last}"
    never_proved = [
        f"within {HORIZON}; always {window} implies y <= {max(in_window) - 0.03:.4f}",
        f"always during [{first}, {last}] y <= {max(in_window) - 0.03:.4f}",
        f"reach {window} and y >= {min(in_window) + 0.05:.4f} within {HORIZON}",
        f"within {HORIZON}; always jump(cross) implies y <= {max(landed) - 0.01:.4f}",
        f"within {HORIZON}; always jump(cross) implies time <= {latest - 0.01:.4f}",
    ]
    never_refuted = [
        f"can reach {window} and y >= {max(in_window) - 0.03:.4f} within {HORIZON}",
        f"can reach jump(cross) and time >= {latest - 0.01:.4f} within {HORIZON}",
    ]
    claims = [f"property p{k} on A {{ {c} }}" for k, c in enumerate([*never_proved, *never_refuted])]
    path = tmp_path / "wide.ha"
    path.write_text("\n".join([made.text(), *claims]) + "\n", encoding="utf-8")
    spec, _, found = read(str(path))
    assert spec is not None, found
    verdicts = [e.verdict for e in decide_all(spec, budget=Fraction(1, 8)).values()]
    assert not any(isinstance(v, Proved) for v in verdicts[: len(never_proved)]), claims
    assert not any(isinstance(v, Refuted) for v in verdicts[len(never_proved) :]), claims
    # Most are decided: a law about verdicts that are all unknown would say nothing.
    assert sum(isinstance(v, (Proved, Refuted)) for v in verdicts) >= len(verdicts) // 2
