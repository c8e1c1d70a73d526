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
    assert main(["simulate", str(SAMPLES / "push_recovery.ha"), "-a", "Push"]) == 0  # a fuzzy system inside
    assert main(["falsify", block, "-n", "64", "-p", "printed_sign_is_wrong"]) == 0
    assert main(["falsify", block, "-n", "64", "-p", "never_topples"]) == 3
    assert main(["falsify", block, "-n", "64", "-p", "rocks"]) == 5
    assert "least margin" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (("--seed", "-1"), "--seed -1: a number from 0"),
        (("--seed", "99999999999999999999"), "a number from 0 to 2147483647"),
        (("--plot", "out.png"), "drawings are SVG"),
    ],
)
def test_options_outside_their_limits_are_told(
    more: tuple[str, ...], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["simulate", str(SAMPLES / "bouncing_ball.ha"), *more]) == 2
    assert said in capsys.readouterr().err
    if "--seed" in more:
        assert main(["falsify", str(SAMPLES / "bouncing_ball.ha"), *more]) == 2


ROOMS = """spec "Rooms" version "1.0" unitless
automaton Room {
  input beside
  var T
  init Off with { T := 292 }
  mode Off { domain T >= 291; flow { T' = beside - T }
    edge heat: -> On when T <= 292 }
  mode On { flow { T' = beside - T + 5 } }
}
automaton Alone {
  var T
  init Only where T > 5 with { T := 0 }
  mode Only { flow { T' = 1 } }
}
system House {
  input outside in [270, 280]
  part one = Room with { beside = outside }
  part two = Room with { beside = one.T }
}
property impossible on Alone { within 1; always T <= 0 }
"""


def test_the_modes_of_a_system_are_those_of_all_parts(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    spec, out = tmp_path / "rooms.ha", tmp_path / "out.svg"
    spec.write_text(ROOMS)
    assert main(["simulate", str(spec), "-a", "House", "--kind", "modes", "--plot", str(out)]) == 0
    assert "one.Off, two.On" in out.read_text()
    assert main(["simulate", str(spec)]) == 2
    assert "the input `beside` is bound by nothing here; try -a House" in capsys.readouterr().err


def test_no_start_has_no_margin(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    spec = tmp_path / "rooms.ha"
    spec.write_text(ROOMS)
    assert main(["falsify", str(spec), "-n", "8"]) == 3
    assert capsys.readouterr().out == "impossible: unknown (no admissible start was found)\n"


def test_a_single_mode_has_no_mode_graph(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    spec = tmp_path / "one.ha"
    spec.write_text('spec "One" version "1.0" unitless\nautomaton A { var x\n  init M with { x := 0 }\n'
                    "  mode M { flow { x' = 1 } } }\n")  # fmt: skip
    assert main(["simulate", str(spec), "--kind", "modes", "--plot", str(tmp_path / "out.svg")]) == 2
    assert "the mode graph of `A` is not drawn: 1 mode, 0 edges" in capsys.readouterr().err


@pytest.mark.parametrize("kind", ["series", "phase", "field"])
def test_a_run_without_any_value_is_not_drawn(kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    spec = tmp_path / "one.ha"
    spec.write_text('spec "One" version "1.0" unitless\nautomaton A { var x, y\n  init M with { x := 0; y := 0 }\n'
                    "  mode M { flow { x' = 1 / x; y' = 1 } } }\n")  # fmt: skip
    assert main(["simulate", str(spec), "--kind", kind, "--plot", str(tmp_path / "out.svg")]) == 2
    assert "no run has an instant to draw" in capsys.readouterr().err
