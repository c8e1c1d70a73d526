"""Heel strikes and toe-offs: from plates, from two published methods, against references read off by hand elsewhere."""

from fractions import Fraction as Q

import pytest
from tests.walks import TRIAL, codes, cut, files, made, walk_of

from haverify.diagnostics.diagnostic import Severity
from haverify.recordings.cycles import cycles, timed, whole
from haverify.recordings.events import METHODS, Steps, moving, steps
from haverify.recordings.forces import contacts
from haverify.recordings.phases import USUAL, boundaries
from haverify.recordings.recording import Events, Forces
from haverify.recordings.stride import is_still, stride
from haverify.text.record import replace


def forces_of(name: str) -> Forces:
    (found,) = files(name).forces
    return found


def near(found: tuple[Q, ...], expected: list[float], within: float) -> bool:
    """Is there an instant found for each expected one?"""
    return all(min(abs(float(t) - e) for t in found) <= within for e in expected)


def test_plates_give_the_instants_of_20_newtons() -> None:
    plates = forces_of("subject01_walk_grf.mot")
    left, right = (contacts(plates, side) for side in "lr")
    assert near(right.strikes, [0.6183, 1.8533], 0.0002)
    assert near(right.offs, [0.1650, 1.4100], 0.0002)
    assert near(left.strikes, [1.2467], 0.0002)
    assert near(left.offs, [0.7883, 2.0183], 0.0002)


def test_plates_with_sides_in_their_names() -> None:
    plates = forces_of("moco_grf_walk.mot")
    assert near(contacts(plates, "r").strikes, [0.267, 1.4115], 0.003)
    assert near(contacts(plates, "l").offs, [1.590], 0.003)


def test_noise_on_an_empty_plate_is_no_step() -> None:
    times = tuple(Q(k, 100) for k in range(100))
    vertical = tuple(Q(700) if 30 <= k < 80 else Q(25) if k in (5, 90) else Q(0) for k in range(100))
    found = contacts(Forces("p", times, {"l": vertical, "r": vertical}), "l")
    assert found.strikes == (Q(3, 10),)
    assert found.offs == (Q(8, 10),)


@pytest.mark.parametrize("method", sorted(METHODS))
def test_both_methods_find_the_strikes_of_markers(method: str) -> None:
    r = walk_of("bmc_walk1.trc")
    found = moving(r, stride(r), method)
    assert near(found["l"].strikes, [1.2600, 2.3730], 0.06)
    assert near(found["r"].strikes, [0.7000, 1.8200], 0.06)
    assert near(found["l"].offs, [0.8670, 1.9870], 0.02)
    assert near(found["r"].offs, [0.3270, 1.4330], 0.02)


def test_joint_angles_alone_place_events_near_those_of_the_plates() -> None:
    r = walk_of(TRIAL)
    found = moving(r, stride(r), "zeni")
    assert near(found["r"].strikes, [0.6183, 1.8533], 0.04)
    assert near(found["l"].strikes, [1.2467, 2.4600], 0.04)
    assert near(found["r"].offs, [1.4100], 0.02)
    assert near(found["l"].offs, [0.7883, 2.0183], 0.02)


@pytest.mark.parametrize(
    ("name", "kind", "seconds", "within"),
    [
        (TRIAL, "repeats", 1.235, 0.02),
        ("subject01_walk1_ik.mot", "alternates", 1.235, 0.005),
        ("moco_coordinates.sto", "alternates", 1.1445, 0.01),
        ("normal_gait.mot", "closes", 1.0, 0.001),
        ("crouch_gait.mot", "closes", 1.0, 0.001),
        ("referenceCoordinates_2d_halfcycle.sto", "mirrors", 0.9402, 0.001),
        ("fukuchi_healthy.json", "repeats", 1.085, 0.01),
    ],
)
def test_the_stride_is_seen_in_the_angles(name: str, kind: str, seconds: float, within: float) -> None:
    found = stride(walk_of(name))
    assert found.kind == kind
    assert found.seconds == pytest.approx(seconds, abs=within)


@pytest.mark.parametrize("period", [0.7, 1.1, 1.9])
@pytest.mark.parametrize("share", [1.05, 1.7, 2.5, 6.0])
def test_strides_of_any_speed_and_number(period: float, share: float) -> None:
    found = stride(made(period * share, period))
    assert found.seconds == pytest.approx(period, rel=0.015)


def test_standing_still_is_no_walk() -> None:
    r = made(3.0)
    still = replace(r, angles={j: tuple(v[0] for _ in r.times) for j, v in r.angles.items()})
    assert is_still(still)
    assert not is_still(r)


def test_annotated_events_too_close_to_one_another_are_settled_by_the_stride() -> None:
    r = walk_of("fukuchi_healthy.json")
    found = steps(r, stride(r))
    assert codes(found.found) == ["HA226", "HA226"]
    assert [round(float(t), 3) for t in found.of["l"].strikes] == [0.087, 1.18, 2.267]


def test_plates_with_exchanged_legs_are_an_error() -> None:
    r, plates = walk_of(TRIAL), forces_of("subject01_walk_grf.mot")
    assert steps(r, stride(r), plates).found == ()
    swapped = replace(plates, vertical={"l": plates.vertical["r"], "r": plates.vertical["l"]})
    found = steps(r, stride(r), swapped)
    assert codes(found.found) == ["HA225"]
    assert found.found[0].severity is Severity.ERROR


def test_plates_of_another_walk_are_not_used() -> None:
    r, plates = walk_of(TRIAL), forces_of("subject01_walk_grf.mot")
    late = replace(plates, times=tuple(t + Q(3, 10) for t in plates.times))
    found = steps(r, stride(r), late)
    assert codes(found.found) == ["HA226"]
    assert "Zeni" in found.of["r"].method


def test_two_strikes_on_a_plate_measure_the_stride() -> None:
    r = walk_of("moco_coordinates.sto")
    s = stride(r)
    assert timed(s, steps(r, s, forces_of("moco_grf_walk.mot"))).seconds == pytest.approx(1.1445, abs=0.003)


def test_cycles_are_cut_from_strike_to_strike() -> None:
    r = made(6.0, 1.1)
    s = stride(r)
    found = cycles(r, s, steps(r, s), "r")
    assert len(found) == 4 or len(found) == 5
    assert all(abs(c.length - Q(11, 10)) < Q(1, 50) for c in found)
    assert all(0 <= share < 1 for c in found for share in c.at)


def test_a_missing_strike_makes_no_double_cycle() -> None:
    r = made(6.0, 1.1)
    s = stride(r)
    seen = steps(r, s)
    gap = replace(seen.of["r"], strikes=seen.of["r"].strikes[:2] + seen.of["r"].strikes[3:])
    found = whole(r, s, Steps({**seen.of, "r": gap}), "r")
    assert len(found) == len(whole(r, s, seen, "r")) - 2


def test_less_than_a_stride_is_one_cycle_of_all_samples() -> None:
    r = walk_of("subject01_walk1_ik.mot")
    s = stride(r)
    (cycle,) = cycles(r, s, steps(r, s), "r")
    assert len(cycle.at) == 73
    assert list(cycle.at) == sorted(cycle.at)


def test_phases_end_with_events() -> None:
    r = walk_of(TRIAL)
    s = stride(r)
    plates = steps(r, s, forces_of("subject01_walk_grf.mot"))
    shares, found = boundaries(cycles(r, timed(s, plates), plates, "r"))
    assert found == []
    expected = [(0.7883 - 0.6183) / 1.235, None, (1.2467 - 0.6183) / 1.235, (1.41 - 0.6183) / 1.235]
    assert all(e is None or abs(float(q) - e) < 0.001 for q, e in zip(shares, expected, strict=False))


def test_missing_events_are_replaced_by_usual_shares_and_told() -> None:
    r = made(3.0)
    s = stride(r)
    none = Steps({"r": steps(r, s).of["r"], "l": Events()})
    found = cycles(r, s, none, "r")
    shares, told = boundaries([replace(c, events={}) for c in found])
    assert shares == USUAL
    assert codes(told) == ["HA226"]


def test_a_part_of_a_stride_has_none() -> None:
    assert stride(cut(walk_of(TRIAL), 0, 30)).kind == ""


def test_a_recording_cut_to_one_stride_begins_where_it_was_cut() -> None:
    for name in ("normal_gait.mot", "crouch_gait.mot"):
        r = walk_of(name)
        s = stride(r)
        (cycle,) = cycles(r, s, steps(r, s), "r")
        assert cycle.start == 0
        assert cycle.at[0] == 0
