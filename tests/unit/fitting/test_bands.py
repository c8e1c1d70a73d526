"""Bands of 95 % hold about 95 % of what they are not made of."""

import pytest
from tests.walks import TRIAL, files, made, walk_of

from haverify.fitting.bands import band, coverage, csv, in_turns
from haverify.fitting.difference import difference
from haverify.fitting.percent import normalised
from haverify.fitting.walk import Options, walk
from haverify.text.record import replace


@pytest.mark.parametrize("noise", [0.3, 1.0])
def test_bands_of_95_percent_hold_90_to_99_percent_of_what_they_are_not_made_of(noise: float) -> None:
    w, _ = walk([made(28.0, noise=noise, seed=2)], (), Options())
    assert w is not None
    held = [coverage(b, w.held_out) for b in w.bands]
    assert len(held) == 6
    assert 0.90 <= sum(c.samples for c in held) / 6 <= 0.99
    turns = [in_turns(w.whole_sample, j) for j in ("lh", "rk", "ra")]
    assert all(t is not None and 0.90 <= t.samples <= 0.99 for t in turns)
    assert all(t is not None and t.curves is not None and t.curves >= 0.90 for t in turns)


PEOPLE = [TRIAL, "normal_gait.mot", "moco_coordinates.sto", "fukuchi_healthy.json", "bmc_walk1.trc"]


def shares(names: list[str], leg: str) -> float:
    """The share of samples of people left out in turns that bands of the others hold."""
    w, _ = walk([walk_of(n) for n in names], (), Options(leg=leg))
    assert w is not None
    turns = [in_turns(w.whole_sample, c.joint) for c in w.curves]
    return sum(t.samples for t in turns if t is not None) / 6


@pytest.mark.parametrize("leg", ["l", "r"])
def test_of_five_people_left_out_in_turns_bands_of_the_others_hold_90_to_99_percent(leg: str) -> None:
    assert 0.90 <= shares(PEOPLE, leg) <= 0.99


def test_a_band_of_ordinary_walkers_does_not_hold_a_crouch_gait() -> None:
    w, _ = walk([walk_of(n) for n in PEOPLE], (), Options(leg="r"))
    crouch, _ = walk([walk_of("crouch_gait.mot")], (), Options(leg="r"))
    assert w is not None
    assert crouch is not None
    everyone = [band(w.whole_sample, c.joint) for c in w.curves]
    assert sum(coverage(b, crouch.training).samples for b in everyone if b is not None) / 6 < 0.5


def test_two_cycles_make_no_band() -> None:
    w, _ = walk([walk_of(TRIAL)], (), Options())
    assert w is not None
    assert w.bands == ()
    assert band(w.training, "lh") is None


def test_fewer_cycles_make_a_wider_band() -> None:
    w, _ = walk([made(28.0, noise=1.0)], (), Options())
    assert w is not None
    few, many = band(w.training[:4], "lh"), band(w.training, "lh")
    assert few is not None
    assert many is not None
    assert few.k > 3 > many.k > 2


def test_the_difference_of_two_fits_is_no_band_of_95_percent() -> None:
    w, _ = walk([made(28.0, noise=1.0)], (), Options())
    assert w is not None
    found = difference(w.training, "rk", w.knots)
    assert found.width > 0
    assert found.samples < 0.6


def test_bands_are_written_by_percent() -> None:
    w, _ = walk([made(10.0, noise=0.5)], (), Options())
    assert w is not None
    lines = csv(w.bands).splitlines()
    assert lines[0].startswith("percent,lh_low,lh_high,lh_curve_low,lh_curve_high,rh_low")
    assert len(lines) == 102


REFERENCE = {  # percent: right hip, knee, ankle of the cycle between two strikes on the plate, made elsewhere
    25: (3.403, -14.519, 5.517),
    50: (-20.854, -7.570, 14.680),
    75: (11.574, -68.833, -1.020),
}


def test_normalised_cycles_are_those_of_a_reference() -> None:
    read = files(TRIAL, "subject01_walk_grf.mot")
    w, _ = walk(read.recordings, read.forces, Options(leg="r"))
    assert w is not None
    curves = [normalised(w.training, j)[0] for j in ("rh", "rk", "ra")]
    for percent, expected in REFERENCE.items():
        assert [float(c[percent]) for c in curves] == pytest.approx(expected, abs=0.05)


def test_cycles_of_one_recording_count_once_among_several() -> None:
    many = [
        replace(made(5.0, period=p, noise=0.5, seed=k), path=f"{k}.mot")
        for k, p in enumerate((1.0, 1.05, 1.1, 1.15, 1.2))
    ]
    w, _ = walk(many, (), Options(leg="r"))
    assert w is not None
    assert len(w.training) > 6
    assert {b.count for b in w.bands} == {3}
