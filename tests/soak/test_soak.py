"""A hundredth of `make soak`, and that it notices what is wrong: too small an enclosure, runs of another field."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from tests.soak.__main__ import RUNS, soak
from tests.soak.campaign import Box, Crossing, Enclosure, Piece, campaign
from tests.soak.enclosures import enclosures
from tests.soak.problems import PROBLEMS, Problem
from tests.soak.runs import Jumped, Runs, starts
from tests.soak.stiff import RATES, flowpipe, question
from tests.soak.stiff import soak as stiff

ROCKING = PROBLEMS["rocking_block"]
ROCKING_START = [(-0.52, -0.48), (-0.01, 0.01)]
STRIKES = [  # instants, and rates before them, of the first impacts on a grid of starts: tests/peers/README.md
    ((1.27648, 1.40915), (0.82643, 0.84974)),
    ((3.01847, 3.22477), (-0.67979, -0.66114)),
    ((4.31286, 4.56450), (0.52891, 0.54383)),
]


@pytest.mark.parametrize("name", PROBLEMS)
def test_a_hundredth_of_the_campaign(name: str) -> None:
    tally = soak(name, RUNS // 100, most=1, claims=1)
    assert tally.escapes == []
    assert tally.runs >= RUNS // 100
    assert tally.looks > 50 * tally.runs


def narrowed(box: Box) -> Box:
    return [(0.95 * low + 0.05 * high, 0.05 * low + 0.95 * high) for low, high in box]


def test_an_enclosure_a_tenth_too_narrow_is_noticed() -> None:
    whole = enclosures("van_der_pol", 1, 1)[0]
    narrow = replace(whole, pieces=[replace(p, box=narrowed(p.box)) for p in whole.pieces])
    assert campaign(PROBLEMS["van_der_pol"], narrow, 100, 1).escapes


def circling(rate: float) -> Problem:
    return Problem(2, (lambda s: np.stack([rate * s[1], -rate * s[0]]),), ((),), 0.05)


def a_quarter_turn() -> Enclosure:
    """The run from (1, 0) that circles once in 2 pi, to nine digits."""
    pieces = []
    for start, end in pairwise(map(float, np.linspace(0, 1.5, 31))):
        x, y = (np.cos(end), np.cos(start)), (-np.sin(end), -np.sin(start))
        pieces.append(Piece(0, 0, (start, end), [(float(a) - 1e-9, float(b) + 1e-9) for a, b in (x, y)]))
    return Enclosure([(1.0, 1.0), (0.0, 0.0)], 0, 1.5, pieces)


def test_runs_of_a_slightly_other_field_or_start_are_noticed() -> None:
    quarter = a_quarter_turn()
    assert campaign(circling(1.0), quarter, 4, 1).escapes == []
    assert campaign(circling(1.000001), quarter, 4, 1).escapes
    assert campaign(circling(1.0), replace(quarter, start=[(1.0, 1.000001), (0.0, 0.0)]), 4, 1).escapes


def strikes() -> list[Jumped]:
    points = starts(ROCKING_START, 400, 1)
    runs = Runs(ROCKING, points, np.zeros(400, dtype=np.int64), np.zeros(400, dtype=np.int64))
    return [jumped for _ in range(100) for jumped in runs.advance(0.05)]


def test_sampled_jumps_are_where_others_found_them() -> None:
    found = strikes()
    for number, (instants, rates) in enumerate(STRIKES, 1):
        own = [(j.times[j.count == number], j.before[1, j.count == number]) for j in found]
        measured = [np.concatenate(values) for values in zip(*own, strict=True)]
        for values, (low, high) in zip(measured, (instants, rates), strict=True):
            assert values.size == 400
            assert values.min() == pytest.approx(low, abs=2e-5)
            assert values.max() == pytest.approx(high, abs=2e-5)


def block(rates: tuple[float, float]) -> Enclosure:
    """Everywhere the same box, and one kind of first impact."""
    box = [(-1.0, 1.0), (-1.0, 1.0)]
    pieces = [Piece(mode, count, (0.0, 2.0), box) for mode, count in ((0, 0), (1, 1))]
    after = [(0.0, 0.0), (0.8 * rates[0], 0.8 * rates[1])]
    first = Crossing((0, 0), 1, STRIKES[0][0], [(-1e-12, 1e-12), rates], after)
    return Enclosure(ROCKING_START, 0, 2.0, pieces, [replace(first, time=(1.2764, 1.4092))])


def test_what_an_impact_does_has_to_be_enclosed() -> None:
    good = campaign(ROCKING, block((0.826, 0.850)), 200, 1)
    assert good.escapes == []
    assert good.jumps == 200
    assert campaign(ROCKING, block((0.830, 0.850)), 200, 1).escapes


@pytest.mark.parametrize("name", RATES)
def test_stiff_runs_stay_inside_the_enclosures_of_their_starts(name: str) -> None:
    assert stiff(name, 2) == []


def test_a_stiff_run_from_another_start_is_noticed() -> None:
    asked = question("robertson_1")
    moved = flowpipe(asked, np.array([0.5, 1e-3, 0.2]))
    assert moved.last[0][1] - moved.last[0][0] < 1e-10
    other = flowpipe(asked, np.array([0.5, 1e-3, 0.2 + 1e-8]))
    assert other.last[0][0] > moved.last[0][1] or other.last[0][1] < moved.last[0][0]
