"""Files other than OpenSim's: separated values, markers, landmarks; what is written is read again."""

import sys
import warnings
from fractions import Fraction as Q
from pathlib import Path

import pytest
from tests.walks import WALKS, codes, files, made, walk_of

from haverify.cli import main
from haverify.recordings.labels import joint_of
from haverify.recordings.read import read
from haverify.recordings.recording import JOINTS
from haverify.recordings.trc import vertical
from haverify.recordings.write import motion, separated
from haverify.run.recordings import recorded
from haverify.text.source import Source

ROW = "0.0,20,-10,-5,-60,1,2\n0.5,-10,20,-60,-5,2,1\n"
LABELS = "time_s,hip_r_deg,hip_l_deg,knee_r_deg,knee_l_deg,ankle_r_deg,ankle_l_deg\n"


@pytest.mark.parametrize(
    "write", [lambda r: ("a.mot", motion("a", r.times, r.angles)), lambda r: ("a.csv", separated(r.times, r.angles))]
)
def test_what_is_written_is_read_again(write) -> None:  # type: ignore[no-untyped-def]
    r = made(1.2)
    name, text = write(r)
    again = read(Source.of_text(name, text))
    assert again.found == ()
    assert again.recording is not None
    assert again.recording.times == r.times
    assert again.recording.angles == r.angles


def test_separated_values_state_their_unit_in_the_labels() -> None:
    r = read(Source.of_text("a.csv", "# a remark\n" + LABELS + ROW)).recording
    assert r is not None
    assert r.angles["rk"] == (Q(-5), Q(-60))


def test_quoted_cells_are_read() -> None:
    text = "\n".join(",".join(f'"{cell}"' for cell in line.split(",")) for line in (LABELS + ROW).split("\n")[:-1])
    r = read(Source.of_text("a.csv", text + "\n")).recording
    assert r is not None
    assert r.angles["rk"] == (Q(-5), Q(-60))


def test_a_percentage_is_a_cycle_of_one_second() -> None:
    text = LABELS.replace("time_s", "percent") + ROW.replace("0.5,", "50,")
    r = read(Source.of_text("a.csv", text)).recording
    assert r is not None
    assert r.times == (0, Q(1, 2))


def test_milliseconds_and_semicolons() -> None:
    text = (LABELS.replace("time_s", "Time [ms]") + ROW.replace("0.5,", "500,")).replace(",", ";")
    r = read(Source.of_text("a.csv", text)).recording
    assert r is not None
    assert r.times == (0, Q(1, 2))


def test_a_file_without_time_is_no_recording() -> None:
    found = read(Source.of_text("a.csv", LABELS.replace("time_s", "frame") + ROW))
    assert codes(found.found) == ["HA224"]


@pytest.mark.parametrize(
    "label",
    [
        "hip_flexion_r",
        "RHipAngle",
        "right hip [deg]",
        "hip_r_deg",
        "rHip",
        "rh",
        "rh [deg]",
        "/jointset/hip_r/hip_flexion_r/value",
    ],
)
def test_names_of_the_right_hip(label: str) -> None:
    assert joint_of(label) == "rh"


@pytest.mark.parametrize(
    "label", ["hip_adduction_r", "hip_rotation_r", "knee_moment_r", "hip", "/jointset/hip_r/hip_flexion_r/speed"]
)
def test_names_of_something_else(label: str) -> None:
    assert joint_of(label) is None


def test_markers_become_joint_angles() -> None:
    read = files("bmc_walk1.trc")
    assert codes(read.found) == ["HA225"]  # the file's sideways axis is mirrored
    r = read.recordings[0]
    knee = [v for v in r.angles["rk"] if v is not None]
    assert -75 < min(knee) < -50
    assert max(knee) < 10
    assert len(r.times) == 364


def test_a_marker_at_the_origin_is_missing() -> None:
    text = (WALKS / "bmc_walk1.trc").read_text(encoding="utf-8").split("\n")
    for k in range(6, 106):
        cells = text[k].split("\t")
        cells[2 + 3 * 3 : 5 + 3 * 3] = ["0", "0", "0"]
        text[k] = "\t".join(cells)
    found = read(Source.of_text("a.trc", "\n".join(text)))
    assert "HA222" in codes(found.found)
    assert found.recording is not None
    assert len(found.recording.times) == 264


def test_a_reversed_walking_direction_changes_no_angle() -> None:
    text = (WALKS / "bmc_walk1.trc").read_text(encoding="utf-8").split("\n")
    for k in range(6, len(text) - 1):
        cells = text[k].split("\t")
        for i in range(2, len(cells), 3):
            cells[i], cells[i + 2] = f"{-float(cells[i]):.1f}", f"{-float(cells[i + 2]):.1f}"
        text[k] = "\t".join(cells)
    turned = read(Source.of_text("a.trc", "\n".join(text))).recording
    straight = walk_of("bmc_walk1.trc")
    assert turned is not None
    apart = [
        abs(a - b)
        for j in JOINTS
        for a, b in zip(turned.angles[j], straight.angles[j], strict=True)
        if a is not None and b is not None
    ]
    assert max(apart) < Q(1, 1000)


def test_walking_backward_is_told() -> None:
    text = (WALKS / "bmc_walk1.trc").read_text(encoding="utf-8").split("\n")
    rows = [x.split("\t", 2) for x in text[6:-1]]
    back = ["\t".join([a[0], a[1], b[2]]) for a, b in zip(rows, reversed(rows), strict=True)]
    found = read(Source.of_text("a.trc", "\n".join([*text[:6], *back]) + "\n"))
    assert "HA223" in codes(found.found)


def test_missing_markers_are_named() -> None:
    text = (WALKS / "bmc_walk1.trc").read_text(encoding="utf-8").replace("R.Heel", "R.Hat")
    found = read(Source.of_text("a.trc", text))
    assert found.recording is None
    assert any("right heel" in d.message for d in found.found)


@pytest.mark.parametrize("text", ["", "{}", '{"fps": 0, "angle_frames": []}', "[" * 2000])
def test_files_that_hold_no_landmarks(text: str) -> None:
    assert codes(read(Source.of_text("a.json", text)).found) == ["HA210"]


def test_c3d_files_hold_the_same_markers(tmp_path: Path) -> None:
    import ezc3d
    import numpy as np

    rows = (WALKS / "bmc_walk1.trc").read_text(encoding="utf-8").split("\n")
    names = rows[3].rstrip().split("\t")[2::3]
    cells = np.array([[float(x) for x in row.split("\t")[2:]] for row in rows[6:-1]]).reshape(-1, len(names), 3)
    file = ezc3d.c3d()
    file["parameters"]["POINT"]["RATE"]["value"] = [150]
    file["parameters"]["POINT"]["LABELS"]["value"] = tuple(names)
    file["parameters"]["POINT"]["UNITS"]["value"] = ("mm",)
    points = np.ones((4, len(names), len(cells)))
    points[:3] = cells.transpose(2, 1, 0)
    file["data"]["points"] = points
    path = tmp_path / "walk.c3d"
    file.write(str(path))
    (r,) = recorded([str(path)]).recordings
    apart = [
        abs(a - b)
        for a, b in zip(r.angles["lk"], walk_of("bmc_walk1.trc").angles["lk"], strict=True)
        if a is not None and b is not None
    ]
    assert max(apart) < Q(1, 100)


def test_a_missing_and_an_unknown_file(tmp_path: Path) -> None:
    read = recorded([str(tmp_path / "no.mot"), "walk.xls"])
    assert codes(read.found) == ["HA006", "HA210"]


def test_a_cell_that_is_no_number_is_told_with_line_and_column() -> None:
    source = Source.of_text("a.csv", LABELS + ROW.replace("-60,-5", "-60,fast"))
    (finding,) = read(source).found
    assert finding.span is not None
    assert source.at(finding.span) == "fast"
    assert source.position(finding.span.start) == (3, 16)


def test_c3d_without_its_library_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "walk.c3d"
    path.write_bytes(b"anything")
    monkeypatch.setitem(sys.modules, "ezc3d", None)
    assert main(["fit", str(path), "-o", str(tmp_path / "walk.ha")]) == 2
    assert "pip install 'haverify[c3d]'" in capsys.readouterr().err


def test_a_c3d_file_that_is_none(tmp_path: Path) -> None:
    path = tmp_path / "walk.c3d"
    path.write_bytes(b"anything")
    assert codes(recorded([str(path)]).found) == ["HA210"]


def test_legs_that_no_frame_shows_have_some_axis_in_silence() -> None:
    import numpy as np

    nowhere = np.full((4, 3), np.nan)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert vertical({"lhip": nowhere, "lankle": nowhere}) in range(3)


@pytest.mark.parametrize("coding", ["utf-16", "utf-16-le", "utf-16-be", "utf-8-sig", "latin-1"])
def test_texts_of_any_coding_are_read(tmp_path: Path, coding: str) -> None:
    path = tmp_path / "walk.csv"
    path.write_bytes((LABELS + ROW).replace("\n", "\r\n").encode(coding))
    (r,) = recorded([str(path)]).recordings
    assert r.angles["rk"] == (Q(-5), Q(-60))


def told_at(tmp_path: Path, name: str, raw: bytes) -> tuple[str, str, str | None]:
    """The first finding in a file: code, the text at its place, help."""
    (tmp_path / name).write_bytes(raw)
    read = recorded([str(tmp_path / name)])
    first = read.found[0]
    assert first.span is not None
    return first.code, read.sources[first.span.path].at(first.span), first.help


@pytest.mark.parametrize(
    ("name", "text", "expected"),
    [
        ("a.mot", "a\nendheader\ntime\0", ("HA210", "\0", None)),
        ("a.csv", LABELS.replace(",", ";") + "0,01;20;1;1;1;1;1\n", ("HA210", "0,01", "write a decimal point: 0.01")),
        ("b.csv", LABELS + "0,01,2,1,1,1,1,1,1,1,1,1,1,1\n", ("HA210", "0,01,2,1,1,1,1,1,1,1,1,1,1,1", "are these")),
        (
            "c.csv",
            LABELS.replace("time_s", "percent") + ROW.replace("0.5,", "100,") * 2,
            ("HA210", "0.0", "write each"),
        ),
        ("d.csv", LABELS + ROW.replace("20,", "1e400,", 1), ("HA210", "1e400", None)),
        ("e.csv", LABELS + ROW.replace("20,", "1e999999999,", 1), ("HA210", "1e999999999", None)),
        ("f.csv", LABELS.replace("knee_l_deg", "knee_l_rad") + ROW, ("HA106", "knee_l_rad", "write all angles in one")),
        (
            "g.csv",
            LABELS.replace("ankle_l", "hip_r_deg,ankle_l") + ROW.replace(",2\n", ",9,2\n").replace(",1\n", ",9,1\n"),
            ("HA221", "hip_r_deg", None),
        ),
        ("a.json", '{"fps": 150, "ok": True}', ("HA210", "True", "a word of Python: write `true`")),
        ("b.json", '{"fps": 150, "ok": ', ("HA210", "", None)),
    ],
)
def test_what_cannot_be_read_is_told_at_its_place(
    tmp_path: Path, name: str, text: str, expected: tuple[str, str, str | None]
) -> None:
    code, at, advice = told_at(tmp_path, name, text.encode())
    assert (code, at) == expected[:2]
    assert (advice or "").startswith(expected[2] or "")


def test_nan_in_landmarks_is_a_missing_point() -> None:
    text = (WALKS / "fukuchi_healthy.json").read_text(encoding="utf-8")
    cut = text.index('"left_knee":[', 3000) + len('"left_knee":[')
    source = Source.of_text("a.json", text[:cut] + "NaN" + text[text.index(",", cut) :])
    found = read(source)
    assert codes(found.found)[:2] == ["HA222", "HA222"]
    assert found.found[0].span is not None
    assert source.at(found.found[0].span) == "NaN"
    assert found.recording is not None
    assert len(found.recording.times) == 373
