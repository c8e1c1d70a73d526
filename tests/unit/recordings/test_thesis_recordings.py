"""Recordings of the thesis' devices: counts of potentiometers, and positions of a leg of two links."""

import math
import random
from fractions import Fraction as Q

import pytest
from tests.walks import codes, made

from haverify.recordings.counts import Calibration, counted, printed_degrees
from haverify.recordings.read import read
from haverify.recordings.recording import JOINTS
from haverify.recordings.two_link import Bent, OutOfReach, as_printed, forward, inverse
from haverify.text.source import Source

LABELS = ",".join(f"{n}_{s}_counts" for n in ("hip", "knee", "ankle") for s in "lr") + ",force_counts"
HEAD = "# counts 999\n# range 300 deg\n# rate 50 Hz\n"


def counts_of(seconds: float, noise: float) -> str:
    """A made-up walk as a suit of potentiometers would record it; each sensor has its own zero."""
    draw = random.Random(3)
    walk = made(seconds, rate=50.0)
    rows = []
    for k in range(len(walk.times)):
        cells = []
        for i, j in enumerate(JOINTS):
            angle = walk.angles[j][k]
            assert angle is not None
            first = walk.angles[j][0] or Q(0)
            cells.append(str(round(float(angle - first) * 999 / 300 + 400 + 10 * i + draw.gauss(0, noise))))
        rows.append(",".join([*cells, str(100 + k % 7)]))
    return HEAD + LABELS + "\n" + "\n".join(rows) + "\n"


def test_300_degrees_are_999_counts_and_not_100() -> None:
    assert Calibration().angle("lk", Q(999), Q(0)) == 300
    assert printed_degrees(Q(999), Q(0)) == 2997


def test_counts_become_angles_from_the_first_row() -> None:
    source = Source.of_text("suit.csv", counts_of(6.0, 1.0))
    found, told = counted(source, len(HEAD), ",")
    assert told == []
    assert found is not None
    truth = made(6.0, rate=50.0)
    for j in JOINTS:
        zero = truth.angles[j][0]
        off = [
            abs(float((a or 0) - (b or 0) + (zero or 0)))
            for a, b in zip(found.recording.angles[j], truth.angles[j], strict=True)
        ]
        assert sum(off) / len(off) < 0.8
    assert found.newtons[1] == Q("9.898")
    assert found.raw["lh"][0] == round(found.raw["lh"][0])


def test_a_recording_of_counts_is_a_walk() -> None:
    from haverify.fitting.walk import Options, walk

    r = read(Source.of_text("suit.csv", counts_of(6.0, 1.0))).recording
    assert r is not None
    w, _ = walk([r], (), Options())
    assert w is not None
    assert float(w.knots.period) == pytest.approx(1.1, rel=0.02)


@pytest.mark.parametrize(
    ("text", "code"),
    [
        (HEAD + LABELS + "\n" + ",".join(["1200"] * 7) + "\n", "HA108"),
        (HEAD + LABELS + "\n" + ",".join([""] * 6) + ",1\n", "HA210"),
        (LABELS + "\n" + ",".join(["500"] * 7) + "\n", "HA224"),
        (HEAD + LABELS.replace("knee_l", "elbow_l") + "\n" + ",".join(["500"] * 7) + "\n", "HA224"),
    ],
)
def test_counts_that_cannot_be(text: str, code: str) -> None:
    assert set(codes(read(Source.of_text("suit.csv", text)).found)) == {code}


def test_a_count_that_leaps_is_left_out_before_smoothing() -> None:
    lines = counts_of(3.0, 1.0).split("\n")
    cells = lines[60].split(",")
    lines[60] = ",".join([*cells[:2], str(int(cells[2]) + 150), *cells[3:]])
    found = read(Source.of_text("suit.csv", "\n".join(lines)))
    assert codes(found.found) == ["HA227"]
    clean = read(Source.of_text("suit.csv", counts_of(3.0, 1.0))).recording
    assert found.recording is not None
    assert clean is not None
    pairs = zip(found.recording.angles["lk"], clean.angles["lk"], strict=True)
    assert max(abs((a or Q(0)) - (b or Q(0))) for a, b in pairs) < 2


def ends_of(seconds: float, longer: float = 1.0) -> str:
    """A made-up walk as the ends of its legs, hip to ankle, separated by semicolons as phones do."""
    walk, rows = made(seconds, rate=50.0), []
    for k, t in enumerate(walk.times):
        cells = [str(float(t))]
        for s in "lr":
            bent = Bent(float(walk.angles[s + "h"][k] or 0), float(walk.angles[s + "k"][k] or 0))
            cells += [f"{longer * v:.7f}" for v in forward(bent, 0.43, 0.41)]
        rows.append(";".join(cells))
    return "# thigh 0.43\n# shank 0.41\ntime;left_x;left_y;right_x;right_y\n" + "\n".join(rows) + "\n"


def test_ends_of_legs_become_hips_and_knees() -> None:
    found = read(Source.of_text("phone.csv", ends_of(3.0)))
    assert codes(found.found) == ["HA222", "HA222"]
    assert all("no ankle" in d.message for d in found.found)
    assert found.recording is not None
    truth = made(3.0, rate=50.0)
    for j in ("lh", "rh", "lk", "rk"):
        pairs = zip(found.recording.angles[j], truth.angles[j], strict=True)
        assert max(abs((a or Q(0)) - (b or Q(0))) for a, b in pairs) < Q(1, 1000)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (ends_of(1.0, 1.2), "out of reach, the first 1.007 from the hip, but the leg reaches 0.02 .. 0.84"),
        (ends_of(1.0).replace("# thigh 0.43\n", ""), "nothing tells how long thigh and shank are"),
        (ends_of(1.0).replace("time;", "when;"), "no column `time`"),
        (ends_of(1.0).replace("right_y", "right_z"), "no column right_y"),
        ("time,ax (m/s^2),ay (m/s^2)\n0,1,2\n1,2,3\n", "accelerations, which tell no place"),
    ],
)
def test_ends_of_legs_that_tell_no_angles(text: str, said: str) -> None:
    found = read(Source.of_text("phone.csv", text))
    assert found.recording is None
    assert any(said in d.message for d in found.found)


@pytest.mark.parametrize("bent", [Bent(20.0, -60.0), Bent(-15.0, -5.0), Bent(30.0, 10.0)])
def test_one_of_both_ways_to_bend_is_the_one_it_came_from(bent: Bent) -> None:
    found = inverse(forward(bent, 0.43, 0.41), 0.43, 0.41)
    assert not isinstance(found, OutOfReach)
    assert any(
        math.isclose(b.hip, bent.hip, abs_tol=1e-9) and math.isclose(b.knee, bent.knee, abs_tol=1e-9) for b in found
    )
    assert all(math.dist(forward(b, 0.43, 0.41), forward(bent, 0.43, 0.41)) < 1e-12 for b in found)
    assert found[0].knee >= 0 >= found[1].knee


@pytest.mark.parametrize("end", [(0.9, 0.0), (0.0, 0.01), (0.0, 0.0)])
def test_points_out_of_reach_are_told(end: tuple[float, float]) -> None:
    found = inverse(end, 0.45, 0.40)
    assert isinstance(found, OutOfReach)
    assert "0.05 .. 0.85" in str(found)


def test_the_algorithm_as_printed_does_not_lead_back() -> None:
    ends = [forward(Bent(h, -k), 5.0, 4.0) for h, k in ((10, 20), (20, 60), (-5, 5))]
    back = [forward(b, 5.0, 4.0) for b in as_printed(ends, 5.0, 4.0)]
    assert max(math.dist(a, b) for a, b in zip(ends, back, strict=True)) > 0.5
