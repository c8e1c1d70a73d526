"""Figures of flowpipes: what is drawn of a checked spec, where nothing can be drawn, and how large it gets."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from haverify.evidence.verdict import Trust
from haverify.report.as_html import as_html
from haverify.report.figures import of_claims, pipes
from haverify.report.figures.evaluate import scope
from haverify.report.figures.material import Figure, Material
from haverify.report.figures.sampled import trails
from haverify.report.html.style import standalone
from haverify.report.report import Report
from haverify.run.material import material
from haverify.run.pipeline import Options, check

SPEC = """spec "Pendulum" version "1.0"
param damping: 1/s in [0.1 Hz, 0.3 Hz]
const limit: rad = 1.1 rad
automaton Pendulum {
  var angle: rad
  var rate: rad/s
  init Swing where 0.9 rad <= angle <= 1 rad and rate == 0 rad/s
  mode Swing { flow { angle' = rate; rate' = -sin(angle) * 1 s^-2 - damping * rate } }
}
property small on Pendulum { within 5 s; always during [1 s, 4 s] abs(angle) <= limit; expect proved }
property one_sided on Pendulum { within 5 s; always angle >= -0.5 rad; expect refuted }
"""
Checked = tuple[Report, Material]


@pytest.fixture(scope="module")
def checked(tmp_path_factory: pytest.TempPathFactory) -> Checked:
    folder = tmp_path_factory.mktemp("flows")
    (folder / "pendulum.ha").write_text(SPEC, encoding="utf-8")
    options = Options(None, Fraction(60), 1, folder / "report", False, None, Trust.ENCLOSED)
    return check(str(folder / "pendulum.ha"), options).report, material(folder / "report")


def figures(checked: Checked, name: str, found: Any = None) -> list[Figure]:
    facts, drawn_from = checked
    if found is not None:
        drawn_from = Material(drawn_from.core, flowpipes={name: found})
    claim = next(c for c in facts.claims if c.name == name)
    return of_claims.of_claim(drawn_from, claim)


def areas(figure: Figure) -> list[str]:
    tree = ElementTree.fromstring(standalone(figure.svg))
    return [e.attrib["d"] for e in tree.iter() if "tube" in e.attrib.get("class", "")]


def test_a_claim_is_drawn_over_time_and_as_a_portrait(checked: Checked) -> None:
    over_time, portrait = figures(checked, "small")
    assert over_time.name == "flow_small" and portrait.name == "portrait_small"
    assert len(areas(over_time)) == 1 and len(areas(portrait)) == 1
    assert "angle [rad]" in over_time.svg and "rate [rad/s]" in portrait.svg
    assert over_time.svg.count('class="bound"') == 2  # both signs of the magnitude
    assert over_time.svg.count('class="trail"') == 5
    assert "sampled runs" in over_time.caption


def test_a_window_of_the_claim_is_where_its_bound_is_drawn(checked: Checked) -> None:
    over_time, _ = figures(checked, "small")
    ends = re.findall(r'class="bound" d="M([\d.]+) [\d.]+L([\d.]+) ', over_time.svg)
    room = 680 - 58 - 14
    assert [[round((float(x) - 58) / room * 4, 2) for x in pair] for pair in ends] == [[1, 4], [1, 4]]


def test_a_violation_shows_the_one_run_that_violates(checked: Checked) -> None:
    pipe = pipes.read(checked[1].flowpipes["one_sided"])
    (piece,) = pipe.pieces
    assert all(high - low < 1e-6 for low, high in piece.start.values())
    assert min(s.box["angle"][1] for s in piece.steps) < -0.5


def test_runs_that_are_drawn_stay_in_the_boxes(checked: Checked) -> None:
    _, drawn_from = checked
    pipe = pipes.read(drawn_from.flowpipes["small"])
    automaton = drawn_from.listed("automata")[0]
    runs = trails(scope(drawn_from, automaton, automaton["modes"][0]), pipe.pieces[0])
    assert len(runs) == 5
    for run in runs:
        for t, state in zip(run.times, run.states, strict=True):
            boxes = [s.box for s in pipe.pieces[0].steps if s.time[0] - 1e-5 <= t <= s.time[1] + 1e-5]
            assert boxes
            near = [all(b[n][0] - 1e-4 <= x <= b[n][1] + 1e-4 for n, x in state.items()) for b in boxes]
            assert any(near)


def test_steps_are_cut_to_what_the_claim_was_decided_by(checked: Checked) -> None:
    """The watched quantity is looked at more closely than the state: what is drawn keeps the bound, too."""
    pipe = pipes.read(checked[1].flowpipes["small"])
    asked = [s for s in pipe.pieces[0].steps if s.time[0] >= 1 and s.time[1] <= 4]
    assert all(s.box["angle"][0] >= -1.1 and s.box["angle"][1] <= 1.1 for s in asked)


def broken(change: Callable[[Any], Any]) -> Any:
    value = {
        "names": ["angle", "rate"],
        "pieces": [{"mode": "Swing", "jumps": 0, "start": [[0, 1], [0, 1]], "steps": [[0, 1, 0, 1, 0, 1]]}],
    }
    change(value)
    return value


@pytest.mark.parametrize(
    "change",
    [
        lambda v: v.pop("names"),
        lambda v: v.update(names=[]),
        lambda v: v.update(pieces=[]),
        lambda v: v["pieces"][0].update(mode="Elsewhere"),
        lambda v: v["pieces"][0].update(steps=[[0, 1, 0, 1]]),
        lambda v: v["pieces"][0].update(steps=[[0, 1, 0, float("nan"), 0, 1]]),
        lambda v: v["pieces"][0].update(steps=[[0, 1, 0, 1e999, 0, 1]]),
        lambda v: v["pieces"][0].update(steps=[[1, 0, 0, 1, 0, 1]]),
        lambda v: v["pieces"][0].update(steps=[[0, 1, "0", "1", 0, 1]]),
        lambda v: v["pieces"][0].update(steps="many"),
        lambda v: v["pieces"][0].update(start=None),
        lambda v: v["pieces"][0].update(steps=[[0, 1, 0, 1, 0, 1]] * 6000),
    ],
)
def test_a_foreign_file_has_no_figure(checked: Checked, change: Callable[[Any], Any]) -> None:
    assert figures(checked, "small", broken(change)) == []
    assert len(figures(checked, "small", broken(lambda v: None))) == 2


@pytest.mark.parametrize("scale", [1e-300, 1e-9, 1e12, 1e300])
def test_values_of_any_size_can_be_drawn(checked: Checked, scale: float) -> None:
    steps = [[k, k + 1, -scale, scale * (k + 1), 0, 0] for k in range(50)]
    value = broken(lambda v: v["pieces"][0].update(steps=steps))
    for figure in figures(checked, "small", value):
        ElementTree.fromstring(standalone(figure.svg))
        assert "nan" not in figure.svg and "inf" not in figure.svg


def test_the_page_stays_small(checked: Checked) -> None:
    facts, drawn_from = checked
    steps = [[k, k + 1, k % 7, 10 + k % 5, k % 3, 10 + k % 11] for k in range(33)]
    piece = {"mode": "Swing", "jumps": 0, "start": [[0, 1], [0, 1]], "steps": steps}
    value = {"names": ["angle", "rate"], "pieces": [piece] * 60}
    page = as_html(facts, Material(drawn_from.core, flowpipes={c.name: value for c in facts.claims}))
    assert 'class="tube' in page
    assert len(page.encode()) < 1_000_000


def test_a_claim_that_is_open_shows_how_far_it_got(tmp_path: Path) -> None:
    flow = "automaton E { var x; init R where x == 1; mode R { flow { x' = x^2 } } }"
    claim = "property p on E { within 2; always x <= 1000000^30; expect unknown }"
    (tmp_path / "e.ha").write_text(f'spec "E" version "1.0" unitless\n{flow}\n{claim}\n')
    outcome = check(str(tmp_path / "e.ha"), Options(None, Fraction(60), 1, tmp_path / "r", False, None, Trust.ENCLOSED))
    pipe = pipes.read(json.loads((tmp_path / "r" / "flowpipes" / "p.json").read_text()))
    assert 0.99 < pipe.end <= 1
    (figure,) = of_claims.of_claim(material(tmp_path / "r"), outcome.report.claims[0])
    assert "up to t = 1 s" in figure.caption
