"""The pictures of a replay and of walks: nothing is cut off, no name stands over another."""

import re
from dataclasses import dataclass
from itertools import pairwise

import pytest
from tests.unit.robot.scene import gait_map, moved, robot

from haverify.report.figures import robot as drawn
from haverify.report.figures.overlay import Pane, Series, overlay
from haverify.report.figures.strides import sticks
from haverify.report.figures.svg import text_width
from haverify.run.replay_pictures import filmed


@dataclass
class Text:
    x: float
    y: float
    kind: str
    said: str


def texts(svg):
    found = re.findall(r'<text x="([-\d.]+)" y="([-\d.]+)" class="([^"]*)">([^<]*)<', svg)
    return [Text(float(x), float(y), kind, said) for x, y, kind, said in found]


def size(svg):
    return tuple(map(float, re.search(r'viewBox="0 0 ([\d.]+) ([\d.]+)"', svg).groups()))


@pytest.mark.parametrize("name", ["gait.toml", "gait_mended.toml"])
def test_names_of_modes_beside_the_soles_stand_apart_and_inside(name):
    """Also where the zero moment point is far outside the sole."""
    svg = drawn.soles(filmed(robot(), *moved(gait_map(name), 100)))
    width, height = size(svg)
    names = [t for t in texts(svg) if t.kind == "edge"]
    assert sorted(t.said for t in names) == ["IS", "LR", "MST", "MSW", "PS", "TS", "TSW"]
    for k, t in enumerate(names):
        assert t.x >= 0 and t.x + text_width(t.said) <= width and 30 < t.y < height - 30
        for other in names[:k]:
            first, second = sorted((t, other), key=lambda n: n.x)
            assert abs(t.y - other.y) >= 11 or first.x + text_width(first.said) * 11 / 12 <= second.x
    assert not any("more characters" in t.said for t in texts(svg))
    points = re.findall(r'points="([^"]*)"', svg)
    xs = [float(p.split(",")[0]) for line in points for p in line.split()]
    assert min(xs) >= 0 and max(xs) <= width


def test_what_a_robot_does_can_be_told_from_what_was_asked_where_both_coincide():
    line = ((0.0, 1.0), (1.0, 2.0))
    curve = drawn.Curve("lk", "deg", (1.0, 2.0), None, {"recording": line, "robot": line})
    blank = ["", ""]
    svg = drawn.joints(drawn.Film((0.0, 1.0), blank, blank, (), (), (), ((0, 0), (0, 0)), [curve]))
    assert re.findall(r'polyline class="([^"]*)"', svg) == ["curve broad", "term t1", "term t2 dashed"]


def test_legends_show_dots_for_samples_and_the_first_of_two_curves_is_broad():
    line = ((0.0, 1.0), (1.0, 2.0))
    of_fit = overlay([Pane("a", (Series(line, 1), Series(line, 0, True)))], ["seen", "made"], [("P", 0, 1)], "t", "a")
    assert of_fit.count('<circle class="f0"') == 3 and 'class="term t0' not in of_fit
    compared = overlay([Pane("a", (Series(line, 0), Series(line, 1)))], ["a", "b"], [("P", 0, 100)], "%", "a")
    assert compared.count('class="term t0 broad"') == compared.count('class="term t1"') == 2
    width, _ = size(compared)
    assert max(t.x + text_width(t.said) / 2 for t in texts(compared) if t.kind == "tick m") <= width


def test_sticks_of_a_long_stride_stand_side_by_side():
    pose = dict(zip(("lh", "lk", "la", "rh", "rk", "ra"), (25.0, 0.0, 0.0, -25.0, 0.0, 0.0), strict=True))
    svg = sticks([pose] * 11, [str(k) for k in range(11)], "a")
    lines = re.findall(r'<polyline class="\w+" points="([^"]*)"', svg)
    figures = [" ".join(lines[k : k + 3]) for k in range(0, 33, 3)]  # a trunk and two legs
    xs = [[float(p.split(",")[0]) for p in figure.split()] for figure in figures]
    spans = [(min(x), max(x)) for x in xs]
    assert all(a[1] <= b[0] + 5 for a, b in pairwise(spans))
    assert spans[0][0] >= 0 and spans[-1][1] <= size(svg)[0]
    assert "left" in svg and "right" in svg
