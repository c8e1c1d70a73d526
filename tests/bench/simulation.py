"""Simulated runs beside scipy and heyoka: how exact, how fast. `make bench-sim`.

Relative errors are against runs of heyoka in 80 bits (heyoka_runs.py, in an environment of its own), which start from
the same doubles. Times are of the processor, without making the integrators.
"""

from __future__ import annotations

import json
import math
import random
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from haverify.elaborate.elaborate import elaborate
from haverify.run.load import load
from haverify.simulate.draws import Drawing
from haverify.simulate.model import SimulatedAutomaton
from haverify.simulate.orbits import orbit_of
from haverify.simulate.run import Settings, followed, plan_of

SAMPLES = Path(__file__).parents[1] / "samples"
ORBITS = Path(__file__).parents[1] / "peers" / "orbits"
Json = Any
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


def ours(text: str, until: float) -> tuple[list[float], float]:
    """The state at a time, seconds."""
    model = model_of(text)
    plan = plan_of(Drawing(model, until).nominal(), Settings(until, steps=10_000_000))
    start = process_time()
    [(_, _, _, _, state)] = model.kernel.ends([plan])
    return state[: len(model.automaton.vars)], process_time() - start


def theirs(field: Field, first: list[float], until: float) -> tuple[list[float], float]:
    start = process_time()
    found = solve_ivp(field, (0.0, until), first, method="DOP853", rtol=TIGHT, atol=TIGHT, t_eval=[until])
    return [float(x) for x in found.y[:, -1]], process_time() - start


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


def number(pair: Sequence[float]) -> np.longdouble:
    return np.longdouble(pair[0]) + np.longdouble(pair[1])


def apart(found: Sequence[float], exact: Sequence[Sequence[float]]) -> float:
    """How far a state is from the exact one, of its size."""
    true = np.array([number(x) for x in exact])
    return float(
        np.linalg.norm((np.array(found, dtype=np.longdouble) - true).astype(float)) / np.linalg.norm(true.astype(float))
    )


def line(name: str, errors: Sequence[float], seconds: Sequence[float]) -> None:
    """Errors of ours, DOP853 and heyoka, our time, and how many times as long the others take."""
    ratios = [f"{s / max(seconds[0], 1e-9):9.2f} x" for s in seconds[1:]]
    print(f"{name:30}" + "".join(f"{e:10.1e}" for e in errors) + f"{seconds[0]:10.4f}" + "".join(ratios), flush=True)


def compared(name: str, text: str, field: Field, first: list[float], peer: Json) -> None:
    mine, seconds = ours(text, peer["until"])
    other, their_seconds = theirs(field, first, peer["until"])
    errors = [apart(x, peer["exact"]) for x in (mine, other, [number(x) for x in peer["state"]])]
    line(name, errors, [seconds, their_seconds, peer["seconds"]])


def accuracy(peers: Json) -> None:
    print(f"{'relative error':30}{'own':>10}{'DOP853':>10}{'heyoka':>10}{'own s':>10}{'DOP853':>11}{'heyoka':>11}")
    first = [0.994, 0.0, 0.0, -2.00158510637908252240537862224]
    compared("Arenstorf, one orbit", ARENSTORF, arenstorf, first, peers["arenstorf"])
    compared("Kepler, e = 0.5, 50 orbits", KEPLER, kepler, [0.5, 0.0, 0.0, math.sqrt(3)], peers["kepler"])
    relaxed = peers["van_der_pol"]
    compared(f"Van der Pol 1000, t = {relaxed['until']:g}", VAN_DER_POL, van_der_pol, [2.0, 0.0], relaxed)
    walker(peers["walker"])


def walker(peer: Json) -> None:
    """The simplest walker for as many steps as the peer took: states, and the times of all strikes."""
    model, count = loaded(ORBITS / "simplest_walker.ha"), len(peer["times"])
    plan = plan_of(Drawing(model, 1000.0).nominal(), Settings(1000.0, jumps=count))
    start = process_time()
    model.kernel.ends([plan])
    seconds = process_time() - start
    jumps = model.kernel.run(plan).jumps()
    times, state, their_seconds = walker_of_scipy(count)
    exact = [number(t) for t in peer["exact_times"]]

    def late(found: Sequence[float]) -> float:
        return float(max(abs(np.longdouble(t) - e) / e for t, e in zip(found, exact, strict=True)))

    errors = [apart(x, peer["exact"]) for x in (jumps[-1][3][:4], state, [number(x) for x in peer["state"]])]
    line(f"walker, state after {count} steps", errors, [seconds, their_seconds, peer["seconds"]])
    late_by = [late([j[0] for j in jumps]), late(times), late([float(number(t)) for t in peer["times"]])]
    print(f"{'walker, times of all strikes':30}" + "".join(f"{e:10.1e}" for e in late_by))


def walker_of_scipy(count: int) -> tuple[list[float], list[float], float]:
    state, t, times = [0.2003, 0.4006, -0.1998, -0.0158], 0.0, list[float]()

    def field(_: float, s: Sequence[float]) -> list[float]:
        turn = math.sin(s[0] - 0.009)
        return [s[2], s[3], turn, turn + s[2] ** 2 * math.sin(s[1]) - math.cos(s[0] - 0.009) * math.sin(s[1])]

    def strike(_: float, s: Sequence[float]) -> float:
        return s[1] - 2 * s[0] if s[0] <= -0.05 else -1.0

    strike.terminal, strike.direction = True, 1.0  # type: ignore[attr-defined]
    start = process_time()
    while len(times) < count:
        found = solve_ivp(field, (t, t + 20), state, method="DOP853", rtol=TIGHT, atol=TIGHT, events=strike)
        t, (th, _, w, _) = float(found.t[-1]), found.y[:, -1]
        c = math.cos(2 * th)
        state = [-th, -2 * th, c * w, c * (1 - c) * w]
        times.append(t)
    return times, state, process_time() - start


def zeno() -> None:
    """Runs that stop at their Zeno points: a ball and tanks, whose limits have a closed form, and the rocking block."""
    ball, tanks = math.sqrt(2 * 10.1 / 9.81) * 1.75 / 0.25, (1.1 + 1.1 - 2 * 0.5) / (2 * 0.01 - 0.015)
    for name, until, exact in (
        ("bouncing_ball", 20.0, ball),
        ("water_tanks", 1000.0, tanks),
        ("rocking_block", 100.0, None),
    ):
        model = loaded(SAMPLES / f"{name}.ha")
        draw = Drawing(model, until).nominal()
        start = process_time()
        run = followed(model, draw, Settings(until))
        known = "" if exact is None else f", off by {abs(run.limit - exact):.1e} s"
        seconds = process_time() - start
        print(f"Zeno point of {name}: {run.limit:.12g} s after {len(run.jumps)} jumps{known} ({seconds:.4f} s)")


def orbits() -> None:
    """Periodic orbits, with the seconds they take to find."""
    for name, until in (
        ("van_der_pol", 60.0),
        ("simplest_walker", 60.0),
        ("compass_gait", 40.0),
        ("rocking_forced", 100.0),
    ):
        model = loaded(ORBITS / f"{name}.ha")
        run = followed(model, Drawing(model, until).nominal(), Settings(until))
        start = process_time()
        found = orbit_of(run)
        print(f"orbit of {name} ({process_time() - start:.2f} s): {found.told().partition('; ')[0]}")


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
    accuracy(json.loads(Path(sys.argv[1]).read_text()))
    zeno()
    orbits()
    speed()
