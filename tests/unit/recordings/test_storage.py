"""OpenSim's files of every header version are read; what their headers get wrong is told."""

from fractions import Fraction as Q
from pathlib import Path

import pytest
from tests.walks import TRIAL, codes, files, walk_of

from haverify.recordings.read import read
from haverify.recordings.recording import Read
from haverify.text.source import Source

LABELS = "time\thip_flexion_r\thip_flexion_l\tknee_angle_r\tknee_angle_l\tankle_angle_r\tankle_angle_l"
DEGREES = "endheader\n" + LABELS + "\n0\t20\t-10\t-5\t-60\t1\t2\n0.5\t-10\t20\t-60\t-5\t2\t1\n"


def mot(text: str, angles: str = "") -> Read:
    return read(Source.of_text("walk.mot", text), angles)


def test_the_header_states_the_unit_with_in_degrees() -> None:
    r = mot("Coordinates\nversion=1\nnRows=2\nnColumns=7\ninDegrees=yes\n" + DEGREES).recording
    assert r is not None
    assert r.angles["lh"] == (Q(-10), Q(20))
    assert r.rounding == 0
    assert "inDegrees=yes" in r.facts[0]


def test_radians_become_degrees_to_a_millionth() -> None:
    rows = "0\t0.3\t-0.2\t-0.1\t-1\t0.02\t0.1\n0.5\t-0.2\t0.3\t-1\t-0.1\t0.1\t0.02\n"
    r = mot("version=3\ninDegrees=no\nendheader\n" + LABELS + "\n" + rows).recording
    assert r is not None
    assert r.angles["rk"][1] == Q("-57.29578")
    assert r.rounding == Q(1, 1_000_000)


def test_a_sentence_states_the_unit_in_files_without_a_version() -> None:
    assert walk_of(TRIAL).facts == ("angles in degrees (Angles are in degrees)",)


def test_a_simm_header_states_no_unit_and_values_show_it() -> None:
    read = files("std_subject01_walk1_ik_simmheader.mot")
    assert codes(read.found) == ["HA106"]
    assert len(read.recordings[0].times) == 73


def test_wrong_counts_are_told_with_their_place() -> None:
    read = files("crouch_gait.mot")
    assert codes(read.found) == ["HA221"]
    (finding,) = read.found
    assert finding.span is not None
    assert read.sources[finding.span.path].position(finding.span.start) == (3, 1)
    assert len(read.recordings[0].times) == 119


def test_state_paths_are_labels_and_a_positive_knee_is_turned() -> None:
    read = files("moco_coordinates.sto")
    assert codes(read.found) == ["HA221", "HA221", "HA223"]  # rows and columns
    knee = [v for v in read.recordings[0].angles["rk"] if v is not None]
    assert min(knee) < -60 < 10 > max(knee)


def test_ground_forces_are_no_recording() -> None:
    read = files("subject01_walk_grf.mot")
    assert read.recordings == ()
    assert len(read.forces) == 1


@pytest.mark.parametrize(
    ("text", "code", "said"),
    [
        ("no header here", "HA210", "no line `endheader`"),
        ("endheader\n" + LABELS, "HA210", "no rows"),
        ("endheader\n" + LABELS + "\n0\t1\t2\n", "HA210", "row 1 has 3 cells, the line of labels 7"),
        (DEGREES.replace("-60\t1", "fast\t1"), "HA210", "`fast` in column knee_angle_l is no number"),
        (DEGREES.replace("0.5\t-10", "0\t-10"), "HA210", "time does not increase"),
        (DEGREES.replace("hip_flexion_l", "elbow_l"), "HA224", "no column for left hip"),
        ("inDegrees=no\n" + DEGREES, "HA108", "states radians, but values go up to 60"),
    ],
)
def test_what_cannot_be_read_is_an_error(text: str, code: str, said: str) -> None:
    found = mot(text)
    assert found.recording is None
    assert code in codes(found.found)
    assert any(said in d.message for d in found.found)


def test_radians_that_call_themselves_degrees_are_an_error() -> None:
    rows = "0\t0.3\t-0.2\t-0.1\t-1\t0.02\t0.1\n0.5\t-0.2\t0.3\t-1\t-0.1\t0.1\t0.02\n"
    found = mot("inDegrees=yes\nendheader\n" + LABELS + "\n" + rows)
    assert codes(found.found) == ["HA108"]
    assert found.found[0].help == "haverify fit --angles rad"
    assert mot("inDegrees=yes\nendheader\n" + LABELS + "\n" + rows, "rad").recording is not None


def test_small_values_without_a_unit_are_asked_about() -> None:
    rows = "0\t0.3\t-0.2\t-0.1\t-1\t0.02\t0.1\n0.5\t-0.2\t0.3\t-1\t-0.1\t0.1\t0.02\n"
    found = mot("endheader\n" + LABELS + "\n" + rows)
    assert found.recording is None
    assert codes(found.found) == ["HA106"]


def test_gaps_and_rows_of_zeros_are_left_out_and_told() -> None:
    gap = mot("inDegrees=yes\n" + DEGREES + "1.0\tnan\t1\t1\t1\t1\t1\n")
    assert codes(gap.found) == ["HA222"]
    assert gap.recording is not None
    assert gap.recording.angles["rh"][2] is None
    zeros = mot("inDegrees=yes\n" + DEGREES + "1.0\t0\t0\t0\t0\t0\t0\n")
    assert codes(zeros.found) == ["HA222"]
    assert zeros.recording is not None
    assert len(zeros.recording.times) == 2


def test_line_ends_and_letters_of_other_systems(tmp_path: Path) -> None:
    from haverify.run.recordings import recorded

    path = tmp_path / "walk.mot"
    path.write_bytes(("Gehen f\xfcr Tests\r\n" + DEGREES.replace("\n", "\r\n")).encode("latin-1"))
    assert len(recorded([str(path)]).recordings) == 1


def test_milliseconds_that_call_themselves_seconds_are_an_error() -> None:
    rows = "".join(f"{20 * k}\t{k}\t{-k}\t-5\t{-3 * k}\t1\t2\n" for k in range(30))
    found = mot("inDegrees=yes\nendheader\n" + LABELS + "\n" + rows)
    assert found.recording is None
    assert codes(found.found) == ["HA108"]
    assert "milliseconds" in found.found[0].message


def test_more_than_a_turn_is_an_error_at_its_cell() -> None:
    found = mot("inDegrees=yes\n" + DEGREES + "1.0\t1\t1\t-1e300\t1\t1\t1\n")
    assert found.recording is None
    assert codes(found.found) == ["HA108"]
    assert "the right knee is at -1e+300 deg, more than a turn" in found.found[0].message


def test_a_single_wrong_sample_turns_no_knee() -> None:
    knees = [200 if k == 30 else -(k % 60) for k in range(99)]
    rows = "".join(f"{k / 60:.6f}\t{k % 30}\t{-(k % 30)}\t{v}\t{-(k % 50)}\t1\t2\n" for k, v in enumerate(knees))
    found = mot("inDegrees=yes\nendheader\n" + LABELS + "\n" + rows)
    assert "HA223" not in codes(found.found)
