"""Laws of flows with inputs: runs under piecewise constant inputs stay in the trees that enclose them."""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from fractions import Fraction
from math import sin
from pathlib import Path

import pytest

from haverify.analyses.hybrid.model import hybrid_model
from haverify.analyses.hybrid.question import Question, follow, question_of
from haverify.run.examine import read
from haverify.solvers.kernel import Stretch

Q = Fraction
SLACK = 1e-6  # the error of a sampled run
State = list[float]
Rates = Callable[[State, State], State]  # of a state and of inputs in [-1, 1]

SYSTEMS: list[tuple[str, Rates]] = [
    ("input u in [-0.2, 0.2]; x in [0.9, 1]; y in [0, 0.1]; x' = y + u; y' = -x - 0.3 * y - u",
     lambda s, u: [s[1] + 0.2 * u[0], -s[0] - 0.3 * s[1] - 0.2 * u[0]]),
    ("input u in [1.4, 1.6]; x in [0.5, 0.6]; y in [-0.1, 0]; x' = u * y; y' = -sin(u * x)",
     lambda s, u: [(1.5 + 0.1 * u[0]) * s[1], -sin((1.5 + 0.1 * u[0]) * s[0])]),
    ("x in [1, 1.2]; y in [0, 0]; x' in [-x, -x / 2]; y' in [-0.1, 0.3]",
     lambda s, u: [-0.75 * s[0] + 0.25 * s[0] * u[0], 0.1 + 0.2 * u[1]]),
    ("input u in [0.4, 0.6]; input w in [-0.6, -0.4]; x in [0, 0.1]; y in [0, 0]; x' = u - u * x^2; y' = w * x + y^2",
     lambda s, u: [(1 - s[0] ** 2) * (0.5 + 0.1 * u[0]), (0.1 * u[1] - 0.5) * s[0] + s[1] ** 2]),
]  # fmt: skip


def question(folder: Path, system: str) -> Question:
    """A claim about a system: what follows the inputs are starts and rates of x and y."""
    parts = [p.strip() for p in system.split(";")]
    inputs, (x, y), rates = parts[:-4], parts[-4:-2], parts[-2:]
    lines = ['spec "S" version "1.0" unitless', *inputs, "automaton A {", "  var x", "  var y"]
    lines += [f"  init R where {x} and {y}", f"  mode R {{ flow {{ {'; '.join(rates)} }} }}", "}"]
    lines.append("property p on A { within 2; always x <= 100 }")
    path = folder / "driven.ha"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    spec, _, found = read(str(path))
    assert spec is not None, found
    claim = spec.claims[0]
    model = hybrid_model(spec, spec.automata[0], [g.condition for g in claim.goals])
    return question_of(model, claim, claim.goals[0])


def stepped(rates: Rates, state: State, inputs: State, h: float) -> State:
    """A Runge-Kutta step of order 4 with the inputs held."""

    def at(slope: State, h: float) -> State:
        return [s + h * k for s, k in zip(state, slope, strict=True)]

    k1 = rates(state, inputs)
    k2 = rates(at(k1, h / 2), inputs)
    k3 = rates(at(k2, h / 2), inputs)
    k4 = rates(at(k3, h), inputs)
    return at([(a + 2 * b + 2 * c + d) / 6 for a, b, c, d in zip(k1, k2, k3, k4, strict=True)], h)


def escaped(tree: Sequence[Stretch], rates: Rates, start: State, choose: Callable[[float], State]) -> float | None:
    """The first instant at which a run is in no stage that has the instant."""
    (stretch,) = tree
    state, time, h = start, 0.0, 1 / 256
    while time < 2:
        here = [g.states for g in stretch.stages if g.time[0] <= time <= g.time[1]]
        inside = [all(a - SLACK <= x <= b + SLACK for x, (a, b) in zip(state, box, strict=False)) for box in here]
        if not all(inside):
            return time
        state, time = stepped(rates, state, choose(time), h), time + h
    return None


@pytest.mark.parametrize("number", range(len(SYSTEMS)))
def test_runs_under_all_sorts_of_inputs_stay_inside(tmp_path: Path, number: int) -> None:
    text, rates = SYSTEMS[number]
    asked = question(tmp_path, text)
    start = asked.model.starts[0]
    tree = follow(asked, start, start.box, "horizon")
    assert tree[0].end == "horizon"
    chance = random.Random(number)
    for _ in range(25):
        period = chance.choice([1 / 64, 0.1, 0.5, 3])
        ends = [[chance.choice([-1, 1, chance.uniform(-1, 1)]) for _ in range(2)] for _ in range(130)]
        point = [chance.choice([float(low), float(high)]) for low, high in start.box[:2]]
        assert escaped(tree, rates, point, lambda t, p=period, e=ends: e[int(t / p)]) is None  # type: ignore[misc]


def test_inputs_beyond_their_range_are_noticed(tmp_path: Path) -> None:
    """The look above can fail."""
    text, rates = SYSTEMS[0]
    asked = question(tmp_path, text)
    start = asked.model.starts[0]
    tree = follow(asked, start, start.box, "horizon")
    point = [float(high) for _, high in start.box[:2]]
    assert escaped(tree, rates, point, lambda _: [1.5, 0.0]) is not None
    assert escaped(tree, rates, point, lambda _: [1.0, 0.0]) is None


@pytest.mark.parametrize("number", range(len(SYSTEMS)))
def test_a_constant_input_is_inside_of_what_encloses_all(tmp_path: Path, number: int) -> None:
    """Enclosures of runs under one choice meet those of all at the horizon."""
    from haverify.analyses.hybrid.inputs import choices
    from haverify.analyses.hybrid.listing import listings
    from haverify.text.record import replace

    asked = question(tmp_path, SYSTEMS[number][0])
    start = asked.model.starts[0]
    whole = follow(asked, start, start.box, "horizon")[-1].last
    point = tuple((low, low) for low, _ in start.box)
    for chosen in choices(asked.model):
        one = replace(asked, modes=listings(asked.model, asked.judged, chosen=chosen), driven=chosen)
        last = follow(one, start, point, "horizon")[-1].last
        for (a, b), (low, high) in zip(last, whole, strict=True):
            assert low - SLACK <= a and b <= high + SLACK
