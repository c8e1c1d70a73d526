"""`python -m tests.soak.stiff [RUNS]`: stiff problems from random starts, each in the flowpipe of its own start.

Runs are computed twice by SciPy's Radau method, with two tolerances; how far they are apart is the slack.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from haverify.analyses.hybrid.model import hybrid_model
from haverify.analyses.hybrid.question import Question, follow, question_of
from haverify.run.examine import read
from haverify.solvers.kernel import Stretch

FOLDER = Path(__file__).parents[1] / "peers" / "nln"
Array = NDArray[np.float64]
Field = Callable[[float, Array], list[float]]
RATES = {"robertson_1": (100.0, 1e3), "robertson_2": (1000.0, 1e5), "robertson_3": (1000.0, 1e7)}
RUNS = 100
END = 40.0


def robertson(name: str) -> Field:
    beta, gamma = RATES[name]

    def field(_: float, s: Array) -> list[float]:
        made, back, fast = 0.4 * s[0], beta * s[1] * s[2], gamma * s[1] * s[1]
        return [-made + back, made - back - fast, fast]

    return field


def question(name: str) -> Question:
    spec, _, _ = read(str(FOLDER / f"{name}.ha"))
    assert spec is not None
    claim = spec.claims[0]
    model = hybrid_model(spec, spec.automata[0], [g.condition for g in claim.goals])
    return question_of(model, claim, claim.goals[0])


def flowpipe(asked: Question, start: Array) -> Stretch:
    """The stretch from one start."""
    (given,) = asked.model.starts
    box = tuple((type(low)(float(x)),) * 2 for x, (low, _) in zip([*start, 0.0], given.box, strict=True))
    (stretch,) = follow(asked, given, box, "horizon")
    assert stretch.end == "horizon"
    return stretch


def escapes(name: str, asked: Question, start: Array) -> list[str]:
    """Where a run is outside the enclosure of its own start."""
    stretch, field = flowpipe(asked, start), robertson(name)
    looked = {sum(g.time) / 2: g.states for g in stretch.stages if 0 < sum(g.time) / 2 < END} | {END: stretch.last}
    at = np.array(sorted(looked))
    rough, fine = (
        solve_ivp(field, (0, END), start, method="Radau", rtol=tol, atol=tol * 1e-6, t_eval=at).y
        for tol in (1e-8, 1e-10)
    )
    slack = 2 * np.abs(rough - fine) + 1e-13
    boxes = [looked[t] for t in at]
    return [
        f"{name} from {start}: at {t}, variable {v}: {fine[v, k]!r} is not in {box[v]}"
        for k, (t, box) in enumerate(zip(at, boxes, strict=True))
        for v in range(3)
        if not box[v][0] - slack[v, k] <= fine[v, k] <= box[v][1] + slack[v, k]
    ]


def soak(name: str, count: int) -> list[str]:
    random, asked = np.random.default_rng(7), question(name)
    found = []
    for _ in range(count):
        shares = random.dirichlet([2, 1, 2])
        # The fast reactant is never there in large amounts.
        start = np.array([shares[0], 1e-3 * shares[1] * 1e3 / RATES[name][1] ** 0.5, shares[2]])
        found += escapes(name, asked, start)
    return found


def main() -> int:
    """A line for each problem; exit code 1 if a run was found outside."""
    count, every = int(sys.argv[1]) if len(sys.argv) > 1 else RUNS, 0
    for name in RATES:
        started = time.process_time()
        found = soak(name, count)
        every += len(found)
        print(f"{name:<16} {count} runs, {len(found)} outside ({time.process_time() - started:.0f} s)", flush=True)
        for text in found[:5]:
            print(f"    {text}")
    return 1 if every else 0


if __name__ == "__main__":
    sys.exit(main())
