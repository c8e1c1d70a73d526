"""What a right band may hold of few curves."""

import pytest
from tests.walks import TRIAL, made, walk_of

from haverify.fitting import luck
from haverify.fitting.bands import Band, coverage
from haverify.fitting.deviations import roughness
from haverify.fitting.luck import of_held_out, of_turns
from haverify.fitting.table import table
from haverify.fitting.walk import Options, walk
from haverify.text.record import replace

PEOPLE = [TRIAL, "normal_gait.mot", "moco_coordinates.sto", "fukuchi_healthy.json", "bmc_walk1.trc"]


def bands(noise: float = 1.0) -> tuple[Band, ...]:
    w, _ = walk([made(28.0, noise=noise, seed=2)], (), Options())
    assert w is not None
    return w.bands


def few(count: int) -> list[Band]:
    return [replace(b, count=count) for b in bands()]


@pytest.mark.parametrize("rough", [3.0, 10.0, 25.0])
def test_curves_are_drawn_as_rough_as_asked_for(rough: float) -> None:
    drawn = luck._drawn(rough, 12)[:60, 0]
    assert sum(roughness(curves) for curves in drawn) / 60 == pytest.approx(rough, rel=0.12)


@pytest.mark.parametrize("n", [3, 5, 20])
def test_bands_hold_95_percent_of_what_is_drawn_on_average(n: int) -> None:
    drawn = luck._drawn(10.0, n + 2)
    samples, curves = luck._shares(drawn[..., :n, :], drawn[..., n:, :], few(n))
    assert samples.mean() == pytest.approx(0.95, abs=0.01)
    assert curves is None if n < 5 else curves is not None and curves.mean() > 0.93


def test_of_fewer_curves_a_share_tells_less() -> None:
    little, more = of_held_out(few(3), 2).samples, of_held_out(few(20), 20).samples
    assert little[0] < more[0] < 0.95 < more[1] <= little[1]
    assert of_turns(few(4), 4).curves is None


def test_what_a_default_split_of_five_people_holds_is_told_with_its_chance() -> None:
    w, _ = walk([walk_of(n) for n in PEOPLE], (), Options())
    assert w is not None
    held = sum(coverage(b, w.held_out).samples for b in w.bands) / 6
    low, high = of_held_out(w.bands, 2).samples
    assert low <= held <= high
    assert f"holds {held:.1%} of samples\n    (a right band holds {int(100 * low)} to " in table(w)
