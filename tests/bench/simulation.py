"""Simulated runs beside scipy: how exact, how fast. `make bench-sim`."""

from __future__ import annotations

import math
import random
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from time import process_time

import numpy as np
from scipy.integrate import solve_ivp

from haverify.elaborate.elaborate import elaborate
from haverify.run.load import load
from haverify.simulate.draws import Drawing
from haverify.simulate.model import SimulatedAutomaton
from haverify.simulate.run import Settings, followed, plan_of

SAMPLES = Path(__file__).parents[1] / "samples"
TIGHT = 1e-12
RUNS, THEIRS = 4000, 10

ARENSTORF = """spec "Arenstorf" version "1.0" unitless
const mu = 0.012277471
automaton Orbit {
  var x; var y; var u; var v
  let d1 = ((x + mu)^2 + y^2)^1.5
  let d2 = ((x - 1 + mu)^2 + y^2)^1.5
  init M with { x := 0.994; y := 0; u := 0; v := -2.00158510637908252240537862224 }
  mode M { flow { x' = u; y' = v
    u' = x + 2 * v - (1 - mu) * (x + mu) / d1 - mu * (x - 1 + mu) / d2
    v' = y - 2 * u - (1 - mu) * y / d1 - mu * y / d2 } }
}
"""
PERIOD = 17.0652165601579625588917206249
KEPLER = """spec "Kepler" version "1.0" unitless
automaton Orbit {
  var x; var y; var u; var v
  init M with { x := 0.5; y := 0; u := 0; v := sqrt(3) }
  mode M { flow { x' = u; y' = v; u' = -x / (x^2 + y^2)^1.5; v' = -y / (x^2 + y^2)^1.5 } }
}
"""
VAN_DER_POL = """spec "Van der Pol" version "1.0" unitless
automaton V {
  var x; var y
  init M with { x := 2; y := 0 }
  mode M { flow { x' = y; y' = 1000 * (1 - x^2) * y - x } }
}
"""

Field = Callable[[float, Sequence[float]], list[float]]


def model_of(text: str) -> SimulatedAutomaton:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "model.ha"
        path.write_text(text)
        return loaded(path)


def loaded(path: Path) -> SimulatedAutomaton:
    read, _ = load(str(path))
    assert read is not None
    spec, _ = elaborate(read.tree, read.files)
    assert spec is not None
    return SimulatedAutomaton(spec, spec.automata[0])


def ours(text: str, until: float) -> tuple[list[float], float, int]:
    """The state at a time, seconds, steps."""
    model = model_of(text)
    draw = Drawing(model, until).nominal()
    start = process_time()
    run = followed(model, draw, Settings(until))
    return run.state[: len(model.automaton.vars)], process_time() - start, run.steps


def theirs(field: Field, first: list[float], until: float, method: str = "DOP853") -> tuple[list[float], float, int]:
    start = process_time()
    found = solve_ivp(field, (0.0, until), first, method=method, rtol=TIGHT, atol=TIGHT)
    return [float(x) for x in found.y[:, -1]], process_time() - start, int(found.t.size)


def arenstorf(_: float, s: Sequence[float]) -> list[float]:
    x, y, u, v = s
    m = 0.012277471
    a, b = ((x + m) ** 2 + y**2) ** 1.5, ((x - 1 + m) ** 2 + y**2) ** 1.5
    first = x + 2 * v - (1 - m) * (x + m) / a - m * (x - 1 + m) / b
    return [u, v, first, y - 2 * u - (1 - m) * y / a - m * y / b]


def kepler(_: float, s: Sequence[float]) -> list[float]:
    x, y, u, v = s
    r = (x * x + y * y) ** 1.5
    return [u, v, -x / r, -y / r]


def van_der_pol(_: float, s: Sequence[float]) -> list[float]:
    x, y = s
    return [y, 1000 * (1 - x * x) * y - x]


def compared(name: str, text: str, field: Field, first: list[float], until: float, expected: list[float]) -> None:
    """One line: relative errors, and how much longer scipy takes."""

    def error(found: list[float]) -> float:
        return float(np.linalg.norm(np.subtract(found, expected)) / np.linalg.norm(expected))

    mine, seconds, steps = ours(text, until)
    other, their_seconds, their_steps = theirs(field, first, until)
    ratio = their_seconds / max(seconds, 1e-9)
    print(f"{name:22} {error(mine):10.1e} {error(other):10.1e} {steps:8} {their_steps:8} {ratio:9.0f} x")


def accuracy() -> None:
    print(f"{'':22} {'error':>10} {'DOP853':>10} {'steps':>8} {'DOP853':>8} {'DOP853 / ours':>11}")
    first = [0.994, 0.0, 0.0, -2.00158510637908252240537862224]
    compared("Arenstorf, one orbit", ARENSTORF, arenstorf, first, PERIOD, first)
    round_trip = [0.5, 0.0, 0.0, math.sqrt(3)]
    compared("Kepler, e = 0.5, 50 orbits", KEPLER, kepler, round_trip, 100 * math.pi, round_trip)
    reference = theirs(van_der_pol, [2.0, 0.0], 20.0, "Radau")[0]
    compared("Van der Pol 1000, t = 20", VAN_DER_POL, van_der_pol, [2.0, 0.0], 20.0, reference)


def zeno() -> None:
    model = loaded(SAMPLES / "bouncing_ball.ha")
    run = followed(model, Drawing(model, 20.0).nominal(), Settings(20.0))
    exact = math.sqrt(2 * 10.1 / 9.81) * 1.75 / 0.25
    print(f"Zeno point of the bouncing ball: off by {abs(run.limit - exact):.1e} s of {exact:.6g} s")


def block_of_scipy(state: list[float], r: float, until: float) -> int:
    """A run of the rocking block with events."""
    alpha, t, side, jumps = 0.2, 0.0, -1.0 if state[0] < 0 else 1.0, 0

    def hit(_: float, s: Sequence[float]) -> float:
        return s[0]

    hit.terminal = True  # type: ignore[attr-defined]
    while t < until and jumps < 10:
        hit.direction = -side  # type: ignore[attr-defined]
        found = solve_ivp(
            lambda _, s, side=side: [s[1], -side * math.sin(alpha * (1 - side * s[0])) / alpha],
            (t, until), state, method="DOP853", rtol=TIGHT, atol=TIGHT, events=hit,
        )  # fmt: skip
        t = float(found.t[-1])
        if found.status != 1:
            break
        state = [0.0, r * float(found.y[1, -1])]
        side, jumps = -side, jumps + 1
    return jumps


def speed() -> None:
    model = loaded(SAMPLES / "rocking_block.ha")
    drawing, chance = Drawing(model, 10.0), random.Random(1)
    plans = [plan_of(drawing.random(chance.random), Settings(10.0, jumps=10)) for _ in range(RUNS)]
    start = process_time()
    ends = model.kernel.ends(plans)
    rate = RUNS / (process_time() - start)
    start = process_time()
    for _, state, *_ in plans[:THEIRS]:
        block_of_scipy(state[:2], state[2], 10.0)
    other = THEIRS / (process_time() - start)
    jumps = sum(e[2] for e in ends) / RUNS
    print(
        f"rocking block to t = 10, {jumps:.1f} jumps: {rate:.0f} runs/s, scipy {other:.1f} runs/s, {rate / other:.0f} x"
    )


if __name__ == "__main__":
    accuracy()
    zeno()
    speed()
