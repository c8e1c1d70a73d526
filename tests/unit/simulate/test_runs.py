"""Runs against closed forms: event times, Zeno points, stops with a place."""

import math
from pathlib import Path

from haverify.elaborate.elaborate import elaborate
from haverify.run.load import load
from haverify.simulate.draws import Draw, Drawing
from haverify.simulate.model import SimulatedAutomaton
from haverify.simulate.run import Settings, SimulatedRun, followed

SAMPLES = Path(__file__).parents[2] / "samples"


def model_of(text: str, tmp_path: Path, name: str | None = None) -> SimulatedAutomaton:
    path = tmp_path / "model.ha"
    path.write_text(text)
    return loaded(path, name)


def loaded(path: Path, name: str | None = None) -> SimulatedAutomaton:
    read, _ = load(str(path))
    assert read is not None
    spec, _ = elaborate(read.tree, read.files)
    assert spec is not None
    automaton = next(a for a in spec.automata if name in (None, a.name))
    return SimulatedAutomaton(spec, automaton)


def nominal(model: SimulatedAutomaton, until: float, policy: str = "earliest") -> SimulatedRun:
    return followed(model, Drawing(model, until).nominal(), Settings(until, policy=policy))


def test_the_bouncing_ball_stops_at_its_zeno_point() -> None:
    run = nominal(loaded(SAMPLES / "bouncing_ball.ha"), 20.0)
    c, height, g = 0.75, 10.1, 9.81
    assert run.end == "zeno"
    assert math.isclose(run.limit, math.sqrt(2 * height / g) * (1 + c) / (1 - c), abs_tol=1e-9)


def test_two_tanks_stop_at_their_zeno_point() -> None:
    run = nominal(loaded(SAMPLES / "water_tanks.ha"), 1e4)
    w, v, level, r = 0.015, 0.01, 1.1, 0.5
    assert run.end == "zeno"
    assert math.isclose(run.limit, 2 * (level - r) / (2 * v - w), rel_tol=1e-9)


BLOCK = """spec "rocking block, linear" version "1.0" unitless
param r in [0.5, 0.95] default 0.8
@allow(HA401, reason = "impacts accumulate")
automaton Block {
  var x in [-2, 2]
  var v in [-3, 3]
  init Right with { x := 0.4; v := 0 }
  mode Left {
    flow { x' = v; v' = 1 + x }
    urgent edge up: -> Right when x >= 0 and v > 0 do v := r * v
  }
  mode Right {
    flow { x' = v; v' = x - 1 }
    urgent edge down: -> Left when x <= 0 and v < 0 do v := r * v
  }
}
"""


def test_a_rocking_block_stops_at_its_zeno_point(tmp_path: Path) -> None:
    """The linear block meets the ground after acosh(1 / (1 - x)), and each time again after 2 atanh of its speed."""
    run = nominal(model_of(BLOCK, tmp_path), 50.0)
    speed = math.sqrt(1 - 0.6**2)
    limit = math.acosh(1 / 0.6) + sum(2 * math.atanh(0.8**n * speed) for n in range(1, 400))
    assert run.end == "zeno"
    assert math.isclose(run.limit, limit, abs_tol=1e-9)


def test_jump_times_are_exact_to_rounding() -> None:
    run = nominal(loaded(SAMPLES / "bouncing_ball.ha"), 20.0)
    first = math.sqrt(2 * 10.1 / 9.81)
    expected = [first + 2 * first * sum(0.75**i for i in range(1, k + 1)) for k in range(10)]
    assert all(
        math.isclose(jump[0], t, rel_tol=4e-16 * (k + 2))
        for k, (jump, t) in enumerate(zip(run.jumps, expected, strict=False))
    )
    assert all(jump[2][0] == 0.0 for jump in run.jumps)


TOUCH = """spec "touch" version "1.0" unitless
automaton A {
  var x
  var n in [0, 9]
  init M with { x := 0; n := 0 }
  mode M { flow { x' = 2 * (time - 1); n' = 0 } }
  urgent edge hit: M -> Done when x <= %s
  mode Done { terminal; flow { x' = 0; n' = 0 } }
}
"""


def test_a_tangential_touch_is_found_and_a_near_miss_is_none(tmp_path: Path) -> None:
    touching = nominal(model_of(TOUCH % "-1", tmp_path), 3.0)
    assert [round(j[0], 7) for j in touching.jumps] == [1.0]
    assert nominal(model_of(TOUCH % "-1.00000001", tmp_path), 3.0).jumps == []


TWICE = """spec "double" version "1.0" unitless
automaton A {
  var x
  init M with x := 0
  mode M { flow { x' = 1 }; domain time <= 10 }
  edge in_between: M -> Done when x * (x - 0.001) < 0 and x > 0.0002
  mode Done { terminal; flow { x' = 0 } }
}
"""


def test_no_step_passes_over_two_crossings(tmp_path: Path) -> None:
    model = model_of(TWICE, tmp_path)
    early, late = nominal(model, 5.0), nominal(model, 20.0, "latest")
    assert math.isclose(early.jumps[0][0], 0.0002, abs_tol=1e-8)
    assert math.isclose(late.jumps[0][0], 0.001, abs_tol=1e-8)


ENDS = """spec "ends" version "1.0" unitless
automaton Lock { var x; init M with x := 0; mode M { domain x <= 1; flow { x' = 1 } } }
automaton Blow { var x; init M with x := 1; mode M { flow { x' = x^2 } } }
automaton Hole { var x; init M with x := 1; mode M { flow { x' = -1 / sqrt(x) } } }
automaton Loop { var x; init M with x := 0; mode M { flow { x' = 0 } }; edge again: M -> M }
"""


def test_how_runs_end(tmp_path: Path) -> None:
    lock = nominal(model_of(ENDS, tmp_path, "Lock"), 5.0)
    assert (lock.end, lock.time, lock.state[0]) == ("stuck", 1.0, 1.0)
    blow = nominal(model_of(ENDS, tmp_path, "Blow"), 5.0)
    assert blow.end == "escape" and math.isclose(blow.time, 1.0, rel_tol=1e-9)
    hole = nominal(model_of(ENDS, tmp_path, "Hole"), 5.0)
    assert hole.end in ("escape", "undefined") and math.isclose(hole.time, 2 / 3, rel_tol=1e-6)
    assert nominal(model_of(ENDS, tmp_path, "Loop"), 5.0).end == "zeno"


def test_the_same_seed_gives_the_same_run() -> None:
    model = loaded(SAMPLES / "rocking_forced.ha")
    draw = Drawing(model, 5.0).nominal()
    one, two = (followed(model, Draw(draw.mode, draw.state, draw.writes), Settings(3.0)) for _ in range(2))
    assert one.jumps == two.jumps and one.state == two.state
