"""`haverify fit` and `haverify compare` as users call them."""

import math
import re
from pathlib import Path

import pytest
from tests.walks import TRIAL, WALKS, as_motion, made

from haverify.cli import main


def fit(folder: Path, *files: str, more: tuple[str, ...] = ()) -> int:
    paths = [f if "/" in f else str(WALKS / f) for f in files]
    return main(["fit", *paths, "-o", str(folder / "walk.ha"), *more])


def checked(folder: Path) -> int:
    return main(["check", str(folder / "walk.ha"), "--no-report", "--no-cache"])


SETS = [
    ("subject01_walk1_ik.mot",),
    (TRIAL, "subject01_walk_grf.mot"),
    ("subject01_walk_IK_gait10dof18musc.mot",),
    ("normal_gait.mot",),
    ("crouch_gait.mot",),
    ("moco_coordinates.sto", "moco_grf_walk.mot"),
    ("referenceCoordinates_2d_halfcycle.sto",),
    ("bmc_walk1.trc",),
    ("fukuchi_healthy.json",),
    ("normal_gait.mot", "moco_coordinates.sto", TRIAL),
]


@pytest.mark.parametrize("files", SETS, ids=lambda files: files[0])
def test_every_recording_becomes_a_spec_that_checks(files: tuple[str, ...], tmp_path: Path) -> None:
    assert fit(tmp_path, *files) == 0
    assert checked(tmp_path) == 0
    assert main(["fmt", "--check", str(tmp_path / "walk.ha")]) == 0


def test_held_out_cycles_are_claimed_of(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "long.mot").write_text(as_motion(made(9.0, noise=0.3)), encoding="utf-8")
    assert fit(tmp_path, str(tmp_path / "long.mot")) == 0
    assert "holds" in capsys.readouterr().out
    assert "property held_out_rk" in (tmp_path / "walk.ha").read_text(encoding="utf-8")
    assert checked(tmp_path) == 0


def test_the_same_recording_gives_the_same_bytes(tmp_path: Path) -> None:
    texts = []
    for name in ("a", "b"):
        folder = tmp_path / name
        assert fit(folder, TRIAL) == 0
        texts.append({p.relative_to(folder): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()})
    assert texts[0] == texts[1]
    assert len(texts[0]) == 9


def test_the_spec_names_its_recording_by_hash(tmp_path: Path) -> None:
    fit(tmp_path, "normal_gait.mot")
    import hashlib

    digest = hashlib.sha256((WALKS / "normal_gait.mot").read_bytes()).hexdigest()
    assert digest in (tmp_path / "walk.ha").read_text(encoding="utf-8")


def test_another_solution_of_the_same_walk_is_proved_to_be_near(tmp_path: Path) -> None:
    other = str(WALKS / "std_subject01_walk1_ik_simmheader.mot")
    assert fit(tmp_path, "subject01_walk1_ik.mot", more=("--held-out", other)) == 0
    assert checked(tmp_path) == 0


def test_the_walk_of_another_person_is_refuted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    other = str(WALKS / "moco_coordinates.sto")
    assert fit(tmp_path, "subject01_walk1_ik.mot", more=("--held-out", other)) == 0
    assert checked(tmp_path) == 1
    out = capsys.readouterr().out
    assert re.search(r"!! refuted +held_out_\w\w", out)
    assert not re.search(r"!! .* recorded_\w\w", out)


def test_other_numbers_in_a_table_are_refuted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    fit(tmp_path, "subject01_walk1_ik.mot")
    path = tmp_path / "walk" / "recorded.csv"
    lines = path.read_text(encoding="utf-8").split("\n")
    cells = lines[5].split(",")
    cells[3] = "45.0"
    path.write_text("\n".join([*lines[:5], ",".join(cells), *lines[6:]]), encoding="utf-8")
    assert checked(tmp_path) == 1
    assert re.search(r"!! refuted +recorded_lh", capsys.readouterr().out)


def test_continuity_of_the_second_derivative_checks_too(tmp_path: Path) -> None:
    assert fit(tmp_path, TRIAL, more=("--order", "2")) == 0
    assert checked(tmp_path) == 0


def test_a_joint_is_kept_where_it_has_to_stay(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert fit(tmp_path, "subject01_walk1_ik.mot", more=("--bound", "knee=-130..1")) == 0
    assert float(re.findall(r"left knee +\d+ +([\d.]+)", capsys.readouterr().out)[0]) < 0.7
    assert checked(tmp_path) == 0
    assert re.search(r"ok proved +knees_in_bounds", capsys.readouterr().out)


def test_figures_are_drawn(tmp_path: Path) -> None:
    assert fit(tmp_path, "normal_gait.mot", more=("--plot", str(tmp_path / "w.svg"))) == 0
    assert (tmp_path / "w.svg").read_text(encoding="utf-8").count("<polyline") == 6
    assert (tmp_path / "w_orbits.svg").read_text(encoding="utf-8").count("<polyline") == 6
    assert (tmp_path / "w_sticks.svg").read_text(encoding="utf-8").count("<polyline") == 33


def test_what_cannot_be_used_writes_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    still = made(3.0)
    lines = as_motion(still).split("\n")
    frozen = lines[7].split("\t", 1)[1]
    rows = [line.split("\t", 1)[0] + "\t" + frozen for line in lines[7:-1]]
    (tmp_path / "still.mot").write_text("\n".join([*lines[:7], *rows]) + "\n", encoding="utf-8")
    assert fit(tmp_path, str(tmp_path / "still.mot")) == 2
    assert "HA224" in capsys.readouterr().err
    assert not (tmp_path / "walk.ha").exists()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["no.mot", "-o", "a.ha"], "HA006"),
        ([str(WALKS / "subject01_walk_grf.mot"), "-o", "a.ha"], "only ground forces"),
        ([str(WALKS / TRIAL), "-o", "a.txt"], "ends in .ha"),
        ([str(WALKS / TRIAL), "-o", "a.ha", "--degree", "2"], "3 to 9"),
        ([str(WALKS / TRIAL), "-o", "a.ha", "--plot", "a.png"], "drawings are SVG"),
        ([str(WALKS / TRIAL), "-o", "a.ha", "--bound", "knee=1..-130"], "such as knee=-130..1"),
    ],
)
def test_calls_that_cannot_be_understood(
    arguments: list[str], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["fit", *arguments]) == 2
    assert said in capsys.readouterr().err


def test_walks_are_compared_with_a_spec(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    fit(tmp_path, "subject01_walk1_ik.mot")
    capsys.readouterr()
    assert (
        main(
            [
                "compare",
                str(WALKS / "subject01_walk1_ik.mot"),
                str(tmp_path / "walk.ha"),
                "--plot",
                str(tmp_path / "c.svg"),
            ]
        )
        == 0
    )
    out = capsys.readouterr().out
    rms = [float(x) for x in re.findall(r"^(?:left|right) \w+ +([\d.]+)", out, re.MULTILINE)]
    assert len(rms) == 6
    assert max(rms) < 0.2
    assert (tmp_path / "c.svg").read_text(encoding="utf-8").count("<polyline") == 12


def test_a_cycle_that_begins_elsewhere_is_turned(capsys: pytest.CaptureFixture[str]) -> None:
    gait = str(WALKS.parents[1] / "spec" / "gait.ha")
    assert main(["compare", str(WALKS / "subject01_walk1_ik.mot"), gait]) == 0
    out = capsys.readouterr().out
    assert "% later" in out
    assert all(float(c) > 0.95 for c in re.findall(r"-?\d+\.\d+ +-?\d+\.\d+ +(\d\.\d{3})", out))


def test_large_distances_stay_in_their_columns(capsys: pytest.CaptureFixture[str]) -> None:
    specs = WALKS.parents[1] / "spec"
    assert main(["compare", str(specs / "gait.ha"), str(specs / "gait_printed.ha")]) == 0
    rows = [line.split() for line in capsys.readouterr().out.splitlines()[2:8]]
    assert [len(row) for row in rows] == [12] * 6
    assert all(math.isfinite(float(cell)) for row in rows for cell in row[2:])


def test_one_walk_is_nothing_to_compare(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["compare", str(WALKS / TRIAL)]) == 2
    assert "two walks" in capsys.readouterr().err


def test_what_a_spec_simulates_is_fitted_again(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    fit(tmp_path, "subject01_walk1_ik.mot")
    spec, motion = str(tmp_path / "walk.ha"), str(tmp_path / "simulated.mot")
    assert main(["simulate", spec, "-a", "Walk", "--until", "4s", "--samples", "240", "--mot", motion]) == 0
    capsys.readouterr()
    assert main(["compare", spec, motion]) == 0
    rms = [float(x) for x in re.findall(r"^(?:left|right) \w+ +([\d.]+)", capsys.readouterr().out, re.MULTILINE)]
    assert len(rms) == 6
    assert max(rms) < 0.5
