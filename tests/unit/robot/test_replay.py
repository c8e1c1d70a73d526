"""Cycles, claims, the greatest pace, recordings: what a replay is made of."""

import math
import sys
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from tests.unit.robot.scene import FOLDER, ROOT, changed, cycle, engine, gait_map, moved, robot

from haverify.cli import main
from haverify.errors import UsageError
from haverify.obligations.translate import OutsideFragmentError
from haverify.robot import mechanics
from haverify.robot.checks import Sampled, margins
from haverify.robot.claims import angle_text, claims_text
from haverify.robot.comparison import compared
from haverify.robot.cycle import cycle_of
from haverify.robot.pace import greatest_pace
from haverify.robot.recorded import recorded
from haverify.robot.slack import slacks
from haverify.robot.trajectory import sampled
from haverify.run.examine import read
from haverify.run.replay import without_effect
from haverify.run.replay_recording import angles_of
from haverify.run.replay_rows import sampled_row
from haverify.text.record import replace

Q = Fraction
MAP = (FOLDER / "gait.toml").read_text()
WALK = str(ROOT / "models" / "walks" / "subject01_walk1_ik.mot")


def test_a_cycle_is_the_seven_phases_of_1_2_s():
    assert [p.mode for p in cycle().pieces] == ["LR", "MST", "TS", "PS", "IS", "MSW", "TSW"]
    assert cycle().length == Q(6, 5)
    assert cycle().closes and cycle().pace_only and cycle().fastest == Q(11, 10)


def test_the_printed_range_of_the_knee_is_outside_the_robots():
    """The source prints -68.3523 deg .. 3.2090 deg for the knee; the robot's, in the same sign, is -130 .. 1."""
    limits = robot().robot.hinges["l_knee_pitch"].limits
    upper = -math.degrees(limits.lower)
    assert upper == pytest.approx(1) and upper - 3.2090 == pytest.approx(-2.209)


def test_speeds_and_accelerations_are_derivatives_of_angles():
    t = sampled(cycle(), gait_map("gait_mended.toml"), robot().robot)
    inner = np.array([a == b for a, b in zip(t.modes[:-2], t.modes[2:], strict=True)])
    for values, rates in ((t.q, t.v), (t.v, t.a)):
        step = (t.times[2:] - t.times[:-2])[inner, None]
        slope = (values[2:] - values[:-2])[inner] / step
        assert np.abs(slope - rates[1:-1][inner]).max() <= 2e-3 * (1 + np.abs(rates).max())


def test_the_stance_sole_rests_and_the_ground_carries_the_weight():
    slow = replace(gait_map("gait_mended.toml"), speed=Q(1, 1000))
    t, m = moved(slow, 1)
    assert m.slip.max() < 1e-12
    assert m.wrench[:, 2] == pytest.approx(float(robot().robot.mass) * 9.81, rel=1e-5)
    for side in ("left", "right"):
        chosen = np.array(t.stance) == side
        assert np.abs(m.feet[side][chosen][:, :, 2]).max() < 1e-12


def test_static_torques_are_those_known_of_a_crouch():
    """On the left foot, hips -20, knees 40, ankles -20 deg, at rest: 2.7 N m at both rolls, 1.7 at the knee."""
    posture = {name: Q(0) for name in robot().robot.hinges} | {"l_shoulder_pitch": Q(90), "r_shoulder_pitch": Q(90)}
    for side in "lr":
        posture |= {f"{side}_hip_pitch": Q(-20), f"{side}_knee_pitch": Q(40), f"{side}_ankle_pitch": Q(-20)}
    still = replace(gait_map(), drives=(), posture=posture, sway=None, stance=dict.fromkeys(gait_map().stance, "left"))
    t, m = moved(still, 1)
    torque = dict(zip(t.joints, np.abs(m.torque[0]), strict=True))
    known = {"l_hip_roll": 2.75, "l_hip_pitch": 0.35, "l_knee_pitch": 1.73, "l_ankle_pitch": 0.56, "l_ankle_roll": 2.73}
    assert {n: torque[n] for n in known} == pytest.approx(known, abs=0.05)


def test_the_greatest_pace_is_where_the_fastest_joint_meets_its_limit():
    pace = greatest_pace(cycle(), gait_map(), robot().robot)
    t = sampled(cycle(), gait_map(), robot().robot)
    fastest = np.abs(t.v).max() * 1.1
    assert pace.proved == Q("0.4665") and pace.refuted == Q("0.4666")
    assert float(pace.proved) <= 5 / fastest < float(pace.refuted)


def test_accelerations_count_where_they_have_a_limit():
    m = replace(gait_map(), acceleration=Q(20))
    pace = greatest_pace(cycle(), m, robot().robot)
    t = sampled(cycle(), m, robot().robot)
    most = math.sqrt(20 / np.abs(t.a).max()) / 1.1
    assert pace.proved < Q("0.4665") and float(pace.proved) == pytest.approx(most, abs=2e-4)
    text = claims_text("x", "g.ha", m, robot().robot, pace)
    assert "der(der(lk))) <= 20 rad/s^2" in text and text.count("property acceleration_") == 6


def test_a_limit_is_told_in_whole_degrees_where_it_was_meant_so():
    assert angle_text(Q(repr(math.radians(130)))) == "130 deg"
    assert angle_text(Q("0.5")) == "0.5 rad"


def test_margins_of_the_joints_that_move():
    t, m = moved(gait_map(), 500)
    table = margins(robot(), t, m)
    assert set(table) == {d.joint for d in gait_map().drives}
    assert table["l_knee_pitch"]["position"] == pytest.approx(-2.319, abs=1e-3)


def test_hips_and_knees_beside_the_recording():
    """The fits follow the recording to about half a degree; the robot's left knee misses 0.6 deg of them."""
    seen = angles_of(WALK, ["lh", "rh", "lk", "rk"])
    rows = {c.output: c for c in compared(cycle(), gait_map(), robot().robot, seen.times, seen.values)}
    assert set(rows) == {"lh", "rh", "lk", "rk"}
    assert all(c.fit_rms < 0.6 for c in rows.values())
    assert rows["lh"].robot_rms == rows["rh"].robot_rms == 0
    assert rows["lk"].robot_rms == pytest.approx(0.56, abs=0.02)
    assert max(v for _, v in rows["lk"].robot) == pytest.approx(1)


def test_a_recording_stands_on_the_lower_foot():
    wanted = ["lh", "rh", "lk", "rk", "la", "ra"]
    seen = angles_of(WALK, wanted)
    t = recorded(seen.times, seen.values, gait_map(), robot().robot, engine(), 200)
    sides = [a for a, b in zip(t.stance, ["", *t.stance], strict=False) if a != b]
    assert sides == ["left", "right", "left"]
    knee = np.degrees(t.q[0, t.joints.index("l_knee_pitch")])
    assert knee == pytest.approx(-seen.values["lk"][0])


def with_gap(folder):
    """The walk, one angle of the left knee being no number."""
    lines = Path(WALK).read_text().splitlines()
    start = next(k for k, line in enumerate(lines) if line.startswith("time"))
    column = lines[start].split("\t").index("knee_angle_l")
    cells = lines[start + 5].split("\t")
    cells[column] = "nan"
    path = folder / "gap.mot"
    path.write_text("\n".join([*lines[: start + 5], "\t".join(cells), *lines[start + 6 :]]))
    return path


def test_a_recording_with_a_gap_or_without_a_joint_is_refused(tmp_path):
    found = angles_of(str(with_gap(tmp_path)), ["lk"]).found
    assert found and all(d.code.startswith("HA") for d in found)
    assert angles_of(str(tmp_path / "none.mot"), ["lk"]).found[0].code == "HA006"


def test_recordings_are_read_as_those_to_fit_are(tmp_path):
    text = (ROOT / "models" / "walks" / "subject01_walk1_ik.mot").read_text()
    path = tmp_path / "walk.mot"
    path.write_bytes(("Gang f\xfcr Tests\n" + text.split("\n", 1)[1]).replace("\n", "\r\n").encode("latin-1"))
    assert len(angles_of(str(path), ["lk"]).times) == 73
    (tmp_path / "none.c3d").write_bytes(b"\x00\x01")
    assert "binary" not in angles_of(str(tmp_path / "none.c3d"), ["lk"]).found[0].message


def test_an_output_in_rad_has_no_offset_in_deg():
    text = (FOLDER / "gait.toml").read_text().replace('unit = "deg"', 'unit = "rad"\noffset = 1', 1)
    assert [d.code for d in changed(text)[1]] == ["HA101"]


def test_without_pinocchio_the_command_says_what_to_install(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "pinocchio", None)
    monkeypatch.chdir(ROOT)
    assert main(["replay", "spec/gait.ha", "--robot", "models/hoap2", "--no-report"]) == 2
    assert "pip install 'haverify[robot]'" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["spec/none.ha"], "none.ha"),
        (["spec/gait.ha", "--map", "none.toml"], "cannot read none.toml"),
        (["spec/gait.ha", "--speed", "0"], "positive number"),
        (["spec/leg_ca.ha"], "has no automaton Gait"),
    ],
)
def test_a_call_that_cannot_be_understood(arguments, said, monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    assert main(["replay", *arguments, "--robot", "models/hoap2", "--no-report"]) == 2
    assert said in capsys.readouterr().err


def test_what_somebody_wrote_is_not_overwritten(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    (tmp_path / "own.ha").write_text("spec\n")
    call = ["replay", "spec/gait.ha", "--robot", "models/hoap2", "--report", str(tmp_path / "own")]
    assert main(call) == 2
    assert (tmp_path / "own.ha").read_text() == "spec\n"
    assert "not made by replay" in capsys.readouterr().err


def test_a_shape_that_pinocchio_cannot_read_is_said(tmp_path):
    text = (FOLDER / "hoap2.urdf").read_text().replace('<sphere radius="0.038"/>', '<mesh filename="none.stl"/>')
    path = tmp_path / "mesh.urdf"
    path.write_text(text)
    with pytest.raises(UsageError, match="Pinocchio cannot read"):
        mechanics.engine(replace(robot(), urdf=str(path)))


def test_what_a_map_names_in_vain_is_told():
    text = (FOLDER / "gait.toml").read_text().replace("../walks/subject01_walk1_ik.mot", "none.mot")
    m, _ = changed(text + 'zero_moment = "a check of another name"\n')
    row = sampled_row(Sampled("power", "", 1.0, None, None, "W", 0.0, "LR"))
    told = [replace(row, name=name, basis="enclosed") for name in m.expected if name != "zero_moment"]
    notes = without_effect(m, told, [])
    assert len(notes) == 2
    assert "`zero_moment` is no check here" in notes[0]
    assert "the recording none.mot cannot be read" in notes[1]


GAP = 'lk = "curve"'


@pytest.mark.parametrize(("fill", "told"), [(GAP, "on a curve"), ("lk = -5", "taken as -5 deg"), ("", "")])
def test_a_gap_is_filled_as_the_map_says(fill, told, tmp_path):
    m, found = changed(MAP + (f"\n[missing]\n{fill}\n" if fill else ""))
    assert found == []
    path, whole = with_gap(tmp_path), angles_of(WALK, ["lk"])
    seen = angles_of(str(path), ["lk"], m.missing)
    if not fill:
        assert [d.code for d in seen.found] == ["HA210"] and seen.found[0].span is not None
        assert GAP in seen.found[0].help
        return
    assert seen.found == [] and told in seen.notes[0] and "1 of 73" in seen.notes[0]
    wrong = np.abs(np.array(seen.values["lk"]) - whole.values["lk"])
    assert np.count_nonzero(wrong) == 1
    assert fill != GAP or wrong.max() < 0.2


def test_a_recording_without_ankles_is_replayed_where_the_map_says_what_they_are(tmp_path):
    lines = [line.split("\t") for line in Path(WALK).read_text().splitlines()]
    start = next(k for k, line in enumerate(lines) if line[0] == "time")
    column = lines[start].index("ankle_angle_l")
    path = tmp_path / "walk.mot"
    kept = lines[:start] + [line[:column] + line[column + 1 :] for line in lines[start:]]
    path.write_text("\n".join("\t".join(line) for line in kept))
    refused = angles_of(str(path), ["lk", "la"])
    assert [d.code for d in refused.found if d.code == "HA224"] and "[missing] la" in refused.found[-1].notes[-1]
    seen = angles_of(str(path), ["lk", "la"], {"la": Q(3)})
    assert set(seen.values["la"]) == {3.0} and "73 of 73" in seen.notes[0]
    assert seen.values["lk"] == angles_of(WALK, ["lk"]).values["lk"]


@pytest.mark.parametrize(
    ("line", "code"), [("lx = 0", "HA002"), ('lk = "spline"', "HA210"), ("lk = true", "HA210"), ("lk = nan", "HA210")]
)
def test_a_wrong_fill(line, code):
    assert [d.code for d in changed(MAP + f"\n[missing]\n{line}\n")[1]] == [code]


def test_margins_of_claims_are_those_of_samples_and_say_where():
    """Positions in deg, speeds at the fastest of all paces; where the pace is the greatest next to nothing is left."""
    pace = greatest_pace(cycle(), gait_map(), robot().robot)
    found = slacks(cycle(), gait_map(), robot().robot, pace)
    t = sampled(cycle(), gait_map(), robot().robot)
    for d in gait_map().drives:
        k, limits = t.joints.index(d.joint), robot().robot.hinges[d.joint].limits
        least = np.degrees(np.minimum(t.q[:, k] - float(limits.lower), float(limits.upper) - t.q[:, k])).min()
        assert float(found[f"position_{d.joint}"].margin) == pytest.approx(least, abs=1e-3)
        fastest = 1.1 * np.abs(t.v[:, k])
        assert float(found[f"speed_{d.joint}"].margin) == pytest.approx(5 - fastest.max(), abs=1e-3)
        mode = {t.modes[i] for i in np.flatnonzero(fastest >= fastest.max() - 1e-3)}
        assert found[f"speed_{d.joint}"].mode in mode
    assert 0 <= found["fastest"].margin < Q("0.0011") and -Q("0.0011") < found["too_fast"].margin < 0


def with_shapes(tmp_path, old, new):
    """The cycle of the gait with a param that shapes outputs."""
    text = (ROOT / "spec" / "gait.ha").read_text().replace(old, new, 1)
    text = text.replace("param speed:", "param amp: 1 in [0.5, 1] default 1\nparam speed:")
    for name in ("coeffs", "limits.ha"):
        (tmp_path / name).symlink_to(ROOT / "spec" / name)
    (tmp_path / "gait.ha").write_text(text)
    spec, _, _ = read(str(tmp_path / "gait.ha"))
    return cycle_of(spec, next(a for a in spec.automata if a.name == "Gait"), ["lh", "lk", "la", "rh", "rk", "ra"])


def test_params_that_shape_outputs_are_followed_over_their_ranges(tmp_path):
    found = with_shapes(tmp_path, "let lk: deg = LK[phase](x)", "let lk: deg = amp * LK[phase](x)")
    assert found.steady and not found.pace_only and found.box == {"amp": (Q(1, 2), Q(1))}
    for (low, high), c in zip(found.pieces[0].over("lk", found.box), cycle().pieces[0].outputs["lk"], strict=True):
        assert (low, high) == (min(c, c / 2), max(c, c / 2))
    assert slacks(found, gait_map(), robot().robot, None) == {}


def test_where_a_param_moves_a_switch_only_defaults_are_followed(tmp_path):
    found = with_shapes(tmp_path, "    LR until 0.5 s", "    LR until 0.5 s * amp + 0 s")
    assert not found.steady and found.box == {} and found.slowest == found.fastest == 1


CHOOSING = """spec "Two phases" version "1.0"
automaton A {
  var x: s in [0 s, 2 s]
  let y: s = x
  init P with x := 0 s
  mode P { domain x <= 1 s; flow { x' = 1 } }
  mode R { domain x <= 2 s; flow { x' = 1 } }
  edge on: P -> R when x >= 1 s
  edge back: R -> P when x >= 2 s do x := 0 s
}
"""


def cycle_with(tmp_path, old, new):
    """The cycle of two phases, something changed."""
    assert old in CHOOSING
    path = tmp_path / "two.ha"
    path.write_text(CHOOSING.replace(old, new, 1))
    spec, _, found = read(str(path))
    assert found == []
    return cycle_of(spec, spec.automata[0], ["y"])


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("init P with x := 0 s", "init P with x in [0 s, 0.5 s]", "it starts in more than one state"),
        ("init P", "init R with x := 1 s\n  init P", "it starts in more than one state"),
        ("with x := 0 s", "where 0 s < x < 0.5 s", "it starts in more than one state"),
        ("with x := 0 s", "where x < 0 s", "no state to start from is seen"),
        ("when x >= 1 s", "when x >= 0.5 s", "mode P may be left at any of several instants"),
        ("when x >= 1 s", "when x >= 1 s do x in [1 s, 1.5 s]", "edge on chooses a value of `x`"),
        ("P -> R when x >= 1 s", "P -> R when x > 1 s", "no edge is taken from mode P"),
        (
            "  edge back",
            "  edge aside: P -> P when x >= 1 s do x := 0.5 s\n  edge back",
            "mode P may be left by edge on and by edge aside",
        ),
    ],
)
def test_an_automaton_that_chooses_has_no_cycle(old, new, told, tmp_path):
    with pytest.raises(OutsideFragmentError, match=told):
        cycle_with(tmp_path, old, new)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("with x := 0 s", "where x == 0 s"),
        ("  edge back", "  edge same: P -> R when x == 1 s\n  edge back"),
        ("when x >= 1 s", "when x >= 1 s do x in [1 s, 1 s]"),
    ],
)
def test_an_automaton_with_one_run_has_a_cycle(old, new, tmp_path):
    """Said in other words, the same start, leaving and reset are no choice."""
    pieces = cycle_with(tmp_path, old, new).pieces
    assert [(p.mode, p.length, p.outputs["y"]) for p in pieces] == [("P", 1, (0, 1)), ("R", 1, (1, 1))]
