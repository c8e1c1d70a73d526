"""Figures of flows with jumps: a colour for each mode, guards, sampled runs that jump, areas that hold all of it."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

import pytest

from haverify.evidence.verdict import Trust
from haverify.report.figures import of_claims, pipes
from haverify.report.figures.jumping import strokes
from haverify.report.figures.material import Material
from haverify.report.figures.pipes import Pipe, Step
from haverify.report.figures.tubes import rims
from haverify.report.report import Report
from haverify.run.material import material
from haverify.run.pipeline import Options, check

SPEC = """spec "Ball" version "1.0" unitless
automaton Ball {
  var h
  var v
  init Down where 1 <= h <= 1.1 and -0.1 <= v <= 0
  mode Down { domain h >= 0 and v <= 0; flow { h' = v; v' = -1 + v^2 / 9 }
    urgent edge bounce: -> Up when h == 0 and v < 0 do v := -0.5 * v }
  mode Up { domain h >= 0 and v >= 0; flow { h' = v; v' = -1 - v^2 / 9 }
    urgent edge turn: -> Down when v == 0 }
}
property low on Ball { within 2.5, 5 jumps; always h <= 1.2; expect proved }
property too_low on Ball { within 2.5, 5 jumps; always h >= 0.5; expect refuted }
"""


@pytest.fixture(scope="module")
def checked(tmp_path_factory: pytest.TempPathFactory) -> tuple[Report, Material]:
    folder = tmp_path_factory.mktemp("ball")
    (folder / "ball.ha").write_text(SPEC, encoding="utf-8")
    options = Options(None, Fraction(60), 1, folder / "report", False, None, Trust.ENCLOSED)
    return check(str(folder / "ball.ha"), options).report, material(folder / "report")


def pipe_of(checked: tuple[Report, Material], name: str = "low") -> Pipe:
    return pipes.read(checked[1].flowpipes[name])


def test_modes_have_colours_and_guards_are_drawn(checked: tuple[Report, Material]) -> None:
    facts, drawn_from = checked
    over_time, portrait = of_claims.of_claim(drawn_from, facts.claims[0])
    for figure in (over_time, portrait):
        assert ">Down<" in figure.svg and ">Up<" in figure.svg
        assert 'class="tube f0"' in figure.svg and 'class="tube f1"' in figure.svg
        assert 'class="jump"' in figure.svg
    assert "guards dotted" in over_time.caption
    assert "up to t = 2.5 s" in over_time.caption  # where the claim ends, though some steps go on


def test_sampled_runs_jump_and_stay_in_the_boxes(checked: tuple[Report, Material]) -> None:
    pipe = pipe_of(checked)
    runs = strokes(checked[1], checked[1].listed("automata")[0], pipe)
    assert len(runs) >= 5
    assert any(first.states[-1]["v"] * second.states[0]["v"] < 0 for first, second in pairwise(runs))  # a bounce
    steps = [s for p in pipe.pieces for s in p.steps]
    for run in runs:
        for t, state in zip(run.times, run.states, strict=True):
            if t <= 2.5:
                assert any(holds(s, t, state) for s in steps), (t, state)


def holds(s: Step, t: float, state: dict[str, float]) -> bool:
    slack = 1e-3  # of sampling, and of rounding for drawing
    is_then = s.time[0] - slack <= t <= s.time[1] + slack
    return is_then and all(s.box[n][0] - slack <= x <= s.box[n][1] + slack for n, x in state.items() if n in "hv")


def test_steps_that_overlap_in_time_are_drawn_with_all_their_boxes() -> None:
    steps = [Step((0, 2), {"x": (0, 1)}), Step((1, 3), {"x": (1, 2)}), Step((2, 4), {"x": (2, 3)})]
    assert rims(steps, "x") == [((0, 1), (0, 1)), ((1, 2), (0, 2)), ((2, 3), (1, 3)), ((3, 4), (2, 3))]


def test_a_jump_to_anywhere_has_no_sampled_run(checked: tuple[Report, Material]) -> None:
    drawn_from = checked[1]
    automaton = drawn_from.listed("automata")[0]
    loose = [{**e, "resets": [{"var": "v", "low": "0", "high": "1"}]} for e in automaton["edges"]]
    assert strokes(drawn_from, {**automaton, "name": "Other", "edges": loose}, pipe_of(checked)) == []


def test_the_run_that_violates_is_drawn(checked: tuple[Report, Material]) -> None:
    pipe = pipe_of(checked, "too_low")
    assert all(high - low < 1e-6 for low, high in pipe.pieces[0].start.values())
    assert min(s.box["h"][0] for p in pipe.pieces for s in p.steps) < 0.5
