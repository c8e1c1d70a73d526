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
