"""Runs by heyoka, in an environment of its own: `python heyoka_runs.py` prints them as JSON.

Each problem is followed in double precision, for errors and times, and in 80 bits with tighter steps, for the state
that counts as true. Times are of the processor, without making the integrators.
"""

from __future__ import annotations

import json
import math
import sys
from time import process_time

import heyoka as hy
import numpy as np

LONG = np.longdouble
MU = 0.012277471
JUMPS = 40  # of the walker


def fields():
    """Equations, start, and time of each problem."""
    x, y, u, v = hy.make_vars("x", "y", "u", "v")
    a, b = ((x + MU) ** 2 + y**2) ** 1.5, ((x - 1 + MU) ** 2 + y**2) ** 1.5
    moon = [
        (x, u),
        (y, v),
        (u, x + 2 * v - (1 - MU) * (x + MU) / a - MU * (x - 1 + MU) / b),
        (v, y - 2 * u - (1 - MU) * y / a - MU * y / b),
    ]
    r = (x**2 + y**2) ** 1.5
    planet = [(x, u), (y, v), (u, -x / r), (v, -y / r)]
    relaxation = [(x, y), (y, 1000 * (1 - x**2) * y - x)]
    return {
        "arenstorf": (moon, [0.994, 0.0, 0.0, -2.00158510637908252240537862224], 17.0652165601579625588917206249),
        "kepler": (planet, [0.5, 0.0, 0.0, math.sqrt(3)], 100 * math.pi),
        "van_der_pol": (relaxation, [2.0, 0.0], float(sys.argv[1]) if len(sys.argv) > 1 else 2000.0),
    }


def plain(equations, start, until, precision):
    options = {"fp_type": precision, "tol": LONG(1e-19) if precision is LONG else 1e-15}
    run = hy.taylor_adaptive(equations, np.array(start, dtype=precision), **options)
    started = process_time()
    found = run.propagate_until(precision(until), max_steps=100_000_000)
    return run.state, process_time() - started, found[3]


def walker(precision):
    """The simplest walker: the state after each of its first strikes."""
    th, ph, vth, vph = hy.make_vars("th", "ph", "vth", "vph")
    turn = hy.sin(th - hy.par[0])
    equations = [
        (th, vth),
        (ph, vph),
        (vth, turn),
        (vph, turn + vth**2 * hy.sin(ph) - hy.cos(th - hy.par[0]) * hy.sin(ph)),
    ]
    kind = {"direction": hy.event_direction.positive, "fp_type": precision}
    strike = hy.t_event(ph - 2 * th, **kind)
    start = np.array([0.2003, 0.4006, -0.1998, -0.0158], dtype=precision)
    options = {"fp_type": precision, "tol": LONG(1e-19) if precision is LONG else 1e-15}
    run = hy.taylor_adaptive(equations, start, t_events=[strike], pars=[precision(0.009)], **options)
    started, times = process_time(), []
    while len(times) < JUMPS:
        found = run.propagate_until(precision(1000), max_steps=100_000)
        assert found[0] != hy.taylor_outcome.time_limit, found
        th_, _, w, _ = run.state
        if th_ > -0.05:
            continue
        c = np.cos(2 * th_)
        run.state[:] = [-th_, -2 * th_, c * w, c * (1 - c) * w]
        times.append(run.time)
    return times, run.state, process_time() - started


def written(values):
    """Numbers of 80 bits as pairs of doubles."""
    return [[float(x), float(LONG(x) - LONG(float(x)))] for x in values]


def main() -> None:
    told = {"version": hy.__version__}
    for name, (equations, start, until) in fields().items():
        exact, _, _ = plain(equations, start, until, LONG)
        found, seconds, steps = plain(equations, start, until, float)
        told[name] = {
            "exact": written(exact),
            "state": written(found),
            "seconds": seconds,
            "steps": steps,
            "until": until,
        }
    times, exact, _ = walker(LONG)
    found_times, found, seconds = walker(float)
    told["walker"] = {
        "exact": written(exact), "state": written(found), "seconds": seconds,
        "exact_times": written(times), "times": written(found_times),
    }  # fmt: skip
    print(json.dumps(told))


if __name__ == "__main__":
    main()
