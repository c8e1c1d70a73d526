"""What is wrong with a robot's files or a map is said with a code and a place."""

import pytest
from tests.unit.robot.scene import FOLDER, changed, gait_map, robot

from haverify.diagnostics.codes import is_error
from haverify.robot.folder import describe
from haverify.robot.mapping import check_against
from haverify.robot.urdf import read_urdf
from haverify.run.load import read_text
from haverify.text.source import Source

MAP = (FOLDER / "gait.toml").read_text()
URDF = (FOLDER / "hoap2.urdf").read_text()
KNEE = 'joint = "l_knee_pitch"\noutput = "lk"\nunit = "deg"\nsign = -1\n'


def told(source, found):
    """The codes with the text at each place."""
    return [(d.code, source.text[d.span.start : d.span.end]) for d in found]


def of_map(old, new):
    assert old in MAP
    text = MAP.replace(old, new, 1)
    made, found = changed(text)
    assert made is None
    return told(Source.of_text("map.toml", text), found), found


@pytest.mark.parametrize(
    ("old", "new", "code", "place"),
    [
        ('joint = "l_knee_pitch"', 'joint = "l_knee"', "HA002", 'joint = "l_knee"'),
        ('joint = "r_knee_pitch"', 'joint = "l_knee_pitch"', "HA004", 'joint = "l_knee_pitch"'),
        (KNEE, KNEE.replace('"deg"', '"m"'), "HA101", 'unit = "m"'),
        (KNEE, KNEE.replace('unit = "deg"\n', ""), "HA106", 'output = "lk"'),
        (KNEE, KNEE.replace("-1", "nan"), "HA210", "sign = nan"),
        (KNEE, KNEE + "ofset = 1\n", "HA002", "ofset = 1"),
        (KNEE, KNEE + "amplitude = inf\n", "HA210", "amplitude = inf"),
        (KNEE, KNEE.replace('"lk"', '"lk -"'), "HA210", 'output = "lk -"'),
        ("waist_pitch = 0\n", "", "HA210", "[posture]"),
        ("waist_pitch = 0", "waist_pitch = 95", "HA108", "waist_pitch = 95"),
        ("waist_pitch = 0", "waist = 0", "HA002", "waist = 0"),
        ("waist_pitch = 0", 'waist_pitch = "a"', "HA210", 'waist_pitch = "a"'),
        ("waist_pitch = 0", "waist_pitch = 0\nl_knee_pitch = 0", "HA004", "l_knee_pitch = 0"),
        ("roll = 0 ", "roll = 26 ", "HA108", "roll = 26"),
        ('LR = "left"', 'LR = "both"', "HA210", 'LR = "both"'),
        ("speed = 1 ", "speed = 0 ", "HA210", "speed = 0"),
        ('left_hip = "l_hip_roll"', 'left_hip = "l_hip"', "HA002", 'left_hip = "l_hip"'),
        ('automaton = "Gait"', "", "HA210", "# How"),
        ("[time]", "[time", "HA001", "[time"),
    ],
)
def test_a_wrong_map(old, new, code, place):
    found, findings = of_map(old, new)
    assert [c for c, _ in found][:1] == [code]
    assert place in found[0][1]
    assert is_error(findings[0])


@pytest.mark.parametrize(
    "value", ["[]", "{ a = 1 }", "true", "1979-05-27", "99999999999999999999999", '""', "1e400000"]
)
@pytest.mark.parametrize("key", ["joint", "output", "unit", "sign", "speed", "roll", "left_hip", "waist_pitch", "LR"])
def test_values_of_any_kind_are_findings(key, value):
    lines = [f"{key} = {value}" if line.startswith(f"{key} = ") else line for line in MAP.splitlines()]
    made, found = changed("\n".join(lines))
    assert (made is None) == bool(found)


def test_a_near_name_is_offered():
    _, found = of_map('joint = "l_knee_pitch"', 'joint = "l_knee_ptch"')
    assert "did you mean l_knee_pitch?" in found[0].message


def test_a_map_for_another_automaton():
    found = check_against(gait_map(), {"lh": "deg", "lk": "rad"}, ["LR", "MST"])
    codes = [d.code for d in found]
    assert codes.count("HA101") == 1 and codes.count("HA002") == 4 + 5
    missing = check_against(
        gait_map(), dict.fromkeys(("lh", "lk", "la", "rh", "rk", "ra"), "deg"), [*gait_map().stance, "Z"]
    )
    assert [d.code for d in missing] == ["HA210"]


@pytest.mark.parametrize(
    ("old", "new", "code", "place"),
    [
        ('<limit lower="-0.01', '<limits lower="-0.01', "HA210", '<joint name="waist_pitch"'),
        ('upper="1.5707963267948966"', 'upper="90"', "HA101", '<limit lower="-0.017453292519943295" upper="90"'),
        ('upper="1.5707963267948966"', 'upper="-1"', "HA201", "<limit"),
        ('<parent link="torso"/>', '<parent link="trunk"/>', "HA002", '<parent link="trunk"/>'),
        ('<mass value="2.37622"/>', '<mass value="2,37622"/>', "HA210", '<mass value="2,37622"/>'),
        ('<mass value="2.37622"/>', '<mass value="nan"/>', "HA210", '<mass value="nan"/>'),
        ('<mass value="2.37622"/>', "", "HA210", "<inertial>"),
        ('ixx="0.008602"', 'ixx="0.000002"', "HA210", '<link name="torso">'),
        ('<axis xyz="0 -1 0"/>', '<axis xyz="0 -0.7 0.7"/>', "HA210", '<axis xyz="0 -0.7 0.7"/>'),
        ('type="revolute"', 'type="planar"', "HA210", '<joint name="waist_pitch" type="planar">'),
        ('<link name="waist">', '<link name="torso">', "HA004", '<link name="torso">'),
        ("</robot>", "</robo>", "HA001", ""),
        ('<robot name="HOAP-2">', '<!DOCTYPE robot><robot name="HOAP-2">', "HA001", "<?xml"),
        ("<robot ", "<model ", "HA001", ""),
        (
            '<parent link="torso"/><child link="waist"/>',
            '<parent link="l_foot"/><child link="waist"/>',
            "HA210",
            "<robot",
        ),
    ],
)
def test_a_broken_urdf(old, new, code, place):
    assert old in URDF
    source = Source.of_text("x.urdf", URDF.replace(old, new, 1))
    robot_, found = read_urdf(source)
    assert robot_ is None
    (c, text), *_ = told(source, found)
    assert c == code and place in text


def test_no_urdf_text_is_too_strange():
    for text in ("", "{", "<a>" * 300_000, "\x00", "<robot/>", "<robot><link/></robot>"):
        robot_, found = read_urdf(Source.of_text("x.urdf", text))
        assert robot_ is None and found


def described(files):
    return describe(
        "r", lambda path: ("missing", None) if path not in files else ("", Source.of_text(path, files[path]))
    )


def test_a_folder_without_its_files():
    good = (FOLDER / "robot.toml").read_text()
    assert [d.code for d in described({})[2]] == ["HA006"]
    assert [d.code for d in described({"r/robot.toml": good})[2]] == ["HA006"]
    assert [d.code for d in described({"r/robot.toml": ""})[2]][:2] == ["HA210", "HA210"]
    wrong = good.replace('left = "l_foot"', 'left = "l_fot"')
    assert [d.code for d in described({"r/robot.toml": wrong, "r/hoap2.urdf": URDF})[2]] == ["HA002"]


def test_the_folder_of_hoap2_is_fine():
    assert robot().robot.name == "HOAP-2" and robot().advice
    assert read_text(robot().urdf)[1] is not None
