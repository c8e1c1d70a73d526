"""Samples that leap: told with their place, left out where one stands alone; none in walks that have none."""

from fractions import Fraction as Q

import pytest
from tests.walks import TRIAL, WALKS, as_motion, codes, made, walk_of

from haverify.fitting.walk import Options, walk
from haverify.recordings.leaps import leaps, settled
from haverify.recordings.read import read
from haverify.recordings.recording import Recording
from haverify.text.record import replace
from haverify.text.source import Source

CLEAN = sorted(
    f.name for f in WALKS.glob("*.*") if f.suffix in (".mot", ".sto", ".trc", ".json") and "grf" not in f.name
)


def moved(r: Recording, joint: str, first: int, count: int, by: int) -> Recording:
    """A recording of which some samples are moved."""
    v = list(r.angles[joint])
    for k in range(first, first + count):
        v[k] = (v[k] or Q(0)) + by
    return replace(r, angles={**r.angles, joint: tuple(v)})


@pytest.mark.parametrize("name", CLEAN)
def test_no_sample_of_a_clean_recording_leaps(name: str) -> None:
    assert leaps(walk_of(name)) == []


@pytest.mark.parametrize("noise", [0.0, 0.3])
@pytest.mark.parametrize("rate", [25.0, 50.0, 200.0])
def test_a_made_up_walk_does_not_leap(noise: float, rate: float) -> None:
    assert leaps(made(5.0, rate=rate, noise=noise)) == []


@pytest.mark.parametrize("at", [0, 1, 2, 17, 40, 100, 208, 209, 210])
@pytest.mark.parametrize("by", [-9, 60])
def test_one_sample_that_leaps_is_found_where_it_is(at: int, by: int) -> None:
    (found,) = leaps(moved(walk_of(TRIAL), "rk", at, 1, 3 * by if at in (0, 1, 209, 210) else by))
    assert (found.joint, found.first, found.count) == ("rk", at, 1)


@pytest.mark.parametrize("count", [2, 3])
def test_a_run_is_told_and_kept_unless_it_is_to_go(count: int) -> None:
    r = moved(walk_of("fukuchi_healthy.json"), "la", 60, count, 25)
    kept, found = settled(r, "single")
    assert (codes(found), kept.angles) == (["HA227"], r.angles)
    dropped, _ = settled(r, "drop")
    assert [k for k, v in enumerate(dropped.angles["la"]) if v is None] == list(range(60, 60 + count))


def test_a_leap_is_told_with_line_column_and_instant_and_changes_no_curve() -> None:
    straight = walk_of("subject01_walk1_ik.mot")
    text = as_motion(moved(straight, "lk", 30, 1, 40))
    source = Source.of_text("a.mot", text)
    r = read(source).recording
    assert r is not None
    w, (found,) = walk([r], (), Options())
    assert w is not None
    assert found.span is not None
    assert source.position(found.span.start)[0] == 8 + 30
    assert source.at(found.span) == text.split("\n")[7 + 30].split("\t")[3]
    assert "left knee leaps by 40.0 deg at 0.9 s for one sample: left out" in found.message
    whole, _ = walk([straight], (), Options())
    assert whole is not None
    assert max(abs(a.high - b.high) for a, b in zip(w.residuals, whole.residuals, strict=True)) < Q(1, 10)


def test_a_leap_that_is_kept_makes_the_interval_wide() -> None:
    r = moved(walk_of("subject01_walk1_ik.mot"), "lk", 30, 1, 40)
    w, found = walk([r], (), Options(outliers="keep"))
    assert w is not None
    assert codes(found) == ["HA227"]
    assert w.residuals[2].high > 15
