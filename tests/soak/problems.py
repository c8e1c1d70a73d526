"""The problems of tests/peers/nln once more, for floats and by hand: nothing here is read from the specs or haverify.

Fields take states (n, runs) to rates (n, runs), in the order of the spec's variables.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Field = Callable[[Array], Array]


@dataclass(frozen=True)
class Edge:
    """A jump where `sign * (state[coordinate] - level)` comes up to 0, which it then is; factors of the state."""

    target: int
    coordinate: int
    sign: float
    factors: dict[int, float]
    level: float = 0.0


@dataclass(frozen=True)
class Problem:
    """How many variables, a field for each mode, the edges out of it, the longest step at which runs come out well."""

    size: int
    fields: tuple[Field, ...]
    edges: tuple[tuple[Edge, ...], ...]
    step: float


def van_der_pol(s: Array) -> Array:
    x, y = s
    return np.stack([y, (1 - x * x) * y - x])


def laub_loomis(s: Array) -> Array:
    x1, x2, x3, x4, x5, x6, x7 = s
    return np.stack([
        1.4 * x3 - 0.9 * x1,
        2.5 * x5 - 1.5 * x2,
        0.6 * x7 - 0.8 * x2 * x3,
        2 - 1.3 * x3 * x4,
        0.7 * x1 - x4 * x5,
        0.3 * x1 - 3.1 * x6,
        1.8 * x6 - 1.5 * x2 * x7,
    ])  # fmt: skip


def quadrotor(s: Array) -> Array:
    """As printed in the benchmark's definition, in x1 to x12."""
    g, m, jx, jy, jz = 9.81, 1.4, 0.054, 0.054, 0.104
    _, _, x3, x4, x5, x6, x7, x8, x9, x10, x11, x12 = s
    c7, c8, c9, s7, s8, s9 = np.cos(x7), np.cos(x8), np.cos(x9), np.sin(x7), np.sin(x8), np.sin(x9)
    return np.stack([
        c8 * c9 * x4 + (s7 * s8 * c9 - c7 * s9) * x5 + (c7 * s8 * c9 + s7 * s9) * x6,
        c8 * s9 * x4 + (s7 * s8 * s9 + c7 * c9) * x5 + (c7 * s8 * s9 - s7 * c9) * x6,
        s8 * x4 - s7 * c8 * x5 - c7 * c8 * x6,
        x12 * x5 - x11 * x6 - g * s8,
        x10 * x6 - x12 * x4 + g * c8 * s7,
        x11 * x4 - x10 * x5 + g * c8 * c7 - (m * g - 10 * (x3 - 1) + 3 * x6) / m,
        x10 + s7 * s8 / c8 * x11 + c7 * s8 / c8 * x12,
        c7 * x11 - s7 * x12,
        s7 / c8 * x11 + c7 / c8 * x12,
        (jy - jz) / jx * x11 * x12 + (-x7 - x10) / jx,
        (jz - jx) / jy * x10 * x12 + (-x8 - x11) / jy,
        (jx - jy) / jz * x10 * x11,
    ])  # fmt: skip


def plankton(s: Array) -> Array:
    x, y, _ = s
    eaten, died = x * y / (1 + x), 0.3 * y
    return np.stack([-eaten, eaten - died, died])


def coupled(s: Array) -> Array:
    x1, y1, x2, y2, b = s
    pull = b * (x2 - x1)
    return np.stack([y1, (1 - x1 * x1) * y1 + pull - x1, y2, (1 - x2 * x2) * y2 - pull - x2, 0 * b])


def prey_and_predators(s: Array) -> Array:
    x, y = s
    return np.stack([3 * x - 3 * x * y, x * y - y])


def block_left(s: Array) -> Array:
    alpha = np.pi / 4
    return np.stack([s[1], np.sin(alpha * (1 + s[0])) / alpha])


def block_right(s: Array) -> Array:
    alpha = np.pi / 4
    return np.stack([s[1], -np.sin(alpha * (1 - s[0])) / alpha])


def ball_down(s: Array) -> Array:
    return np.stack([s[1], -9.81 + 0.1 * s[1] ** 2])


def ball_up(s: Array) -> Array:
    return np.stack([s[1], -9.81 - 0.1 * s[1] ** 2])


def chaser(s: Array, steered: Array) -> Array:
    """Metres and minutes; `steered` is what x, y, x', y' are times in the two forces. The last coordinate is time."""
    mu, r, m = 3.986e14 * 3600, 42_164_000.0, 500.0
    n = np.sqrt(mu / r**3)
    x, y, vx, vy, _ = s
    rc = np.hypot(r + x, y)
    ax = n**2 * x + 2 * n * vy + mu / r**2 - mu * (r + x) / rc**3
    ay = n**2 * y - 2 * n * vx - mu * y / rc**3
    force = steered @ s[:4] / m
    return np.stack([vx, vy, ax + force[0], ay + force[1], np.ones_like(x)])


FAR = np.array([[-28.8287, 0.1005, -1449.9754, 0.0046], [-0.087, -33.2562, 0.00462, -1451.5013]])
NEAR = np.array([[-288.0288, 0.1312, -9614.9898, 0.0], [-0.1312, -288.0, 0.0, -9614.9883]])


def drifting(s: Array) -> Array:
    return chaser(s, 0 * FAR)


def approaching(s: Array) -> Array:
    return chaser(s, FAR)


def attempting(s: Array) -> Array:
    return chaser(s, NEAR)


PROBLEMS = {
    "van_der_pol": Problem(2, (van_der_pol,), ((),), 0.05),
    "coupled_van_der_pol": Problem(5, (coupled,), ((),), 0.05),
    # Its jumps have no effect: all runs are in one flowpipe without any.
    "lotka_volterra_circle": Problem(2, (prey_and_predators,), ((),), 0.05),
    "laub_loomis_w001": Problem(7, (laub_loomis,), ((),), 0.2),
    "laub_loomis_w005": Problem(7, (laub_loomis,), ((),), 0.2),
    "laub_loomis_w010": Problem(7, (laub_loomis,), ((),), 0.2),
    "quadrotor": Problem(12, (quadrotor,), ((),), 0.05),
    "production_destruction": Problem(3, (plankton,), ((),), 0.5),
    "rocking_block": Problem(
        2,
        (block_left, block_right),
        ((Edge(1, 0, 1.0, {0: 0.0, 1: 0.8}),), (Edge(0, 0, -1.0, {0: 0.0, 1: 0.8}),)),
        0.05,
    ),
    "bouncing_ball_drag": Problem(
        2,
        (ball_down, ball_up),
        ((Edge(1, 0, -1.0, {0: 0.0, 1: -0.8}),), (Edge(0, 1, -1.0, {1: 0.0}),)),
        0.05,
    ),
    "spacecraft_rendezvous": Problem(
        5,
        (approaching, attempting, drifting),
        ((Edge(1, 0, 1.0, {}, -100.0), Edge(2, 4, 1.0, {}, 120.0)), (Edge(2, 4, 1.0, {}, 120.0),), ()),
        0.2,
    ),
}
