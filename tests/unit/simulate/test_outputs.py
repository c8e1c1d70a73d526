"""What `haverify simulate` and `haverify falsify` write: tables, motions, JSON, drawings, exit codes."""

import csv
import io
import json
import math
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from haverify.cli import main
from haverify.recordings.storage import storage
from haverify.text.source import Source

ROOT = Path(__file__).parents[3]
SAMPLES = ROOT / "tests" / "samples"


def test_a_table_has_both_sides_of_each_jump(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["simulate", str(SAMPLES / "bouncing_ball.ha"), "--until", "2s", "--samples", "4", "--csv", "-"]) == 0
    rows = list(csv.reader(io.StringIO(capsys.readouterr().out)))
    assert rows[0] == ["run", "time [s]", "mode", "jumps", "h [m]", "v [m/s]"]
    before, after = (next(r for r in rows[1:] if r[1].startswith("1.434") and r[3] == k) for k in "01")
    assert math.isclose(float(after[5]), -0.75 * float(before[5])) and float(after[4]) == 0


def test_a_motion_is_read_back(tmp_path: Path) -> None:
    out = tmp_path / "out.mot"
    assert main(["simulate", str(ROOT / "spec" / "gait.ha"), "--until", "3s", "--mot", str(out)]) == 0
    _, columns, found = storage(Source.of_text(str(out), out.read_text()))
    assert columns is not None and not found
    assert columns.labels == ("time", "lh", "rh", "lk", "rk", "la", "ra") and len(columns.rows) == 201


@pytest.mark.parametrize("kind", ["series", "phase", "field", "modes"])
def test_drawings_are_whole(kind: str, tmp_path: Path) -> None:
    out = tmp_path / "out.svg"
    call = [
        "simulate",
        str(SAMPLES / "rocking_block.ha"),
        "-n",
        "2",
        "--plot",
        str(out),
        "--kind",
        kind,
        "--of",
        "x1,x2",
    ]
    assert main(call) == 0
    root = ET.fromstring(out.read_text())
    assert len(list(root.iter())) > 8 and "nan" not in out.read_text()


def test_json_says_where_a_run_ended(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["simulate", str(SAMPLES / "bouncing_ball.ha"), "--until", "20s", "--format", "json"]) == 0
    (run,) = json.loads(capsys.readouterr().out)
    assert run["end"]["how"] == "zeno" and len(run["jumps"]) == len(run["stays"]) - 1


def test_exit_codes(capsys: pytest.CaptureFixture[str]) -> None:
    block = str(SAMPLES / "rocking_block.ha")
    assert main(["simulate", block, "-a", "Nobody"]) == 2
    assert main(["simulate", block, "-n", "0"]) == 2 and main(["falsify", block, "-n", "0"]) == 2
    assert main(["simulate", str(SAMPLES / "push_recovery.ha"), "-a", "Push"]) == 2  # a fuzzy system inside
    assert main(["falsify", block, "-n", "64", "-p", "printed_sign_is_wrong"]) == 0
    assert main(["falsify", block, "-n", "64", "-p", "never_topples"]) == 3
    assert main(["falsify", block, "-n", "64", "-p", "rocks"]) == 5
    assert "least margin" in capsys.readouterr().out
