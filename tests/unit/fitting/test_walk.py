"""Curves fitted to walks: exactly continuous and periodic, near to every sample, on recordings good and bad."""

from fractions import Fraction as Q

import pytest
from tests.walks import TRIAL, codes, cut, files, made, walk_of

from haverify.fitting.walk import Options, Walk, split, walk
from haverify.recordings.recording import Recording
from haverify.text.record import replace

EVERY = [
    "subject01_walk1_ik.mot",
    TRIAL,
    "subject01_walk_IK_gait10dof18musc.mot",
    "std_subject01_walk1_ik_simmheader.mot",
    "normal_gait.mot",
    "crouch_gait.mot",
    "moco_coordinates.sto",
    "referenceCoordinates_2d_halfcycle.sto",
    "bmc_walk1.trc",
    "fukuchi_healthy.json",
]


def fitted(*recordings: Recording, options: Options | None = None) -> Walk:
    made, found = walk(recordings, (), options or Options())
    assert made is not None, found
    return made


@pytest.mark.parametrize("name", EVERY)
def test_curves_have_no_step_and_every_sample_is_in_the_proved_interval(name: str) -> None:
    w = fitted(walk_of(name))
    assert [c.jump(k) for c in w.curves for k in (0, 1)] == [0] * 12
    for c, r in zip(w.curves, w.residuals, strict=True):
        off = [
            a - c.value(share * w.knots.period)
            for cycle in w.training
            for share, a in zip(cycle.at, cycle.angles[c.joint], strict=True)
            if a is not None
        ]
        rounding = max(x.rounding for x in w.recordings)
        assert (r.low, r.high) == (min(off) - rounding, max(off) + rounding)


def test_the_recording_of_the_thesis_is_met_to_an_eighth_of_a_degree() -> None:
    w = fitted(walk_of("subject01_walk1_ik.mot"))
    assert w.strides[0].kind == "alternates"
    assert max(r.rms for r in w.residuals) < 0.125
    assert max(r.high for r in w.residuals) < Q(1, 2)


@pytest.mark.parametrize("order", [0, 1, 2])
def test_the_order_says_which_derivatives_have_no_step(order: int) -> None:
    w = fitted(walk_of(TRIAL), options=Options(order=order))
    assert [c.jump(k) for c in w.curves for k in range(order + 1)] == [0] * (6 * (order + 1))
    assert any(c.jump(order + 1) for c in w.curves)


def test_a_higher_degree_comes_nearer() -> None:
    rms = [sum(r.rms for r in fitted(walk_of("normal_gait.mot"), options=Options(degree=d)).residuals) for d in (3, 4)]
    assert rms[1] < rms[0] / 2


def test_cycles_are_held_out_whole() -> None:
    w = fitted(made(12.0, noise=0.3))
    assert (len(w.training), len(w.held_out)) == (6, 4)
    starts = {c.start for c in w.training}
    assert not any(c.start in starts for c in w.held_out)


def test_recordings_are_held_out_whole_where_there_are_three() -> None:
    a, b, c = (replace(made(4.0, period=p, seed=k), path=f"{k}.mot") for k, p in enumerate((1.0, 1.1, 1.2)))
    w = fitted(a, b, c)
    assert {x.origin for x in w.training}.isdisjoint({x.origin for x in w.held_out})


def test_two_cycles_are_both_for_training() -> None:
    assert split([[1, 2]]) == ([1, 2], [])  # type: ignore[list-item]


def test_noise_is_smoothed() -> None:
    w = fitted(made(12.0, noise=0.5), options=Options(leg="r"))
    clean = made(12.0)
    true = fitted(clean, options=Options(leg="r"))
    import numpy as np

    t = np.linspace(0, 1, 101)
    for a, b in zip(w.curves, true.curves, strict=True):
        apart = a.at(t * float(a.knots.period) * 0.999) - b.at(t * float(b.knots.period) * 0.999)
        assert float(np.sqrt(np.mean(apart**2))) < 1.5  # most of it is where cycles begin, which noise moves by some ms


def test_dropped_samples_change_little() -> None:
    r = walk_of(TRIAL)
    kept = [k for k in range(len(r.times)) if k % 7 != 3]
    thin = replace(
        r, times=tuple(r.times[k] for k in kept), angles={j: tuple(v[k] for k in kept) for j, v in r.angles.items()}
    )
    gaps = {
        j: tuple(None if k % 5 == i % 5 else x for k, x in enumerate(v)) for i, (j, v) in enumerate(r.angles.items())
    }
    full, other, gappy = fitted(r), fitted(thin), fitted(replace(r, angles=gaps))
    for w in (other, gappy):
        assert abs(w.knots.period - full.knots.period) < Q(1, 50)
        assert max(r.rms for r in w.residuals) < 0.5 + max(r.rms for r in full.residuals)


def test_swapped_legs_of_a_symmetric_walk_begin_half_a_stride_later() -> None:
    r = made(6.0)
    swapped = replace(r, angles={j: r.angles[{"l": "r", "r": "l"}[j[0]] + j[1]] for j in r.angles})
    a, b = (fitted(x, options=Options(leg="r")) for x in (r, swapped))
    assert abs(a.training[0].start - b.training[0].start) % a.knots.period > a.knots.period / 3


def test_standing_still_is_an_error() -> None:
    r = made(3.0)
    still = replace(r, angles={j: tuple(v[0] for _ in r.times) for j, v in r.angles.items()})
    found = walk([still], (), Options())
    assert found[0] is None
    assert codes(found[1]) == ["HA224"]


def test_a_third_of_a_stride_is_an_error() -> None:
    found = walk([cut(walk_of(TRIAL), 0, 30)], (), Options())
    assert found[0] is None
    assert codes(found[1]) == ["HA224"]


def test_half_a_symmetric_stride_is_completed_and_told() -> None:
    made_up = made(0.55, 1.1)
    found, told = walk([made_up], (), Options())
    assert found is not None
    assert codes(told)[0] == "HA226"
    assert abs(found.knots.period - Q(11, 10)) < Q(1, 50)


def test_forces_end_phases_where_they_were_measured() -> None:
    read = files(TRIAL, "subject01_walk_grf.mot")
    found, told = walk(read.recordings, read.forces, Options())
    assert found is not None
    assert told == []
    assert found.methods == ("ground force above 20 N",)
    assert [round(float(t), 3) for t in found.knots.at] == [0, 0.17, 0.399, 0.628, 0.792, 0.936, 1.091, 1.235]


def test_the_other_leg_can_begin_the_cycle() -> None:
    w = fitted(walk_of(TRIAL), options=Options(leg="l"))
    assert float(w.training[0].start) == pytest.approx(1.22, abs=0.03)
