"""Bands of 95 % hold about 95 % of what they are not made of."""

import pytest
from tests.walks import TRIAL, files, made, walk_of

from haverify.fitting.bands import band, coverage, csv, difference, normalised
from haverify.fitting.walk import Options, walk
from haverify.text.record import replace


@pytest.mark.parametrize("seed", [1, 2])
def test_a_band_of_95_percent_holds_90_to_99_percent_of_held_out_samples(seed: int) -> None:
    w, _ = walk([made(28.0, noise=1.0, seed=seed)], (), Options())
    assert w is not None
    shares = [coverage(b, w.held_out).samples for b in w.bands]
    assert len(shares) == 6
    assert 0.90 <= sum(shares) / 6 <= 0.99


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
    assert lines[0].startswith("percent,lh_low,lh_high,rh_low")
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
