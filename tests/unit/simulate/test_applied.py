"""Fuzzy systems and interpolated tables inside automata: the values that rules and rows say, corners found."""

import json
from pathlib import Path

import pytest

from haverify.cli import main
from haverify.elaborate.elaborate import elaborate
from haverify.run.load import load
from haverify.simulate.draws import Drawing
from haverify.simulate.model import SimulatedAutomaton

SAMPLES = Path(__file__).parents[2] / "samples"
TABLED = """spec "Tabled" version "1.0" unitless
table speed from "speed.csv" { axis x: 1; column v: 1; interpolate INTERPOLATE }
automaton A { var x
  init M with { x := 0 }
  mode M { flow { x' = speed.v(x) } } }
"""


def by_hand(force: float) -> list[float]:
    """Strengths of ankle, knee, hip, fall_side, fall_front, fall for roll = pitch = 0.5, from the printed rules."""
    small = min(max(5 - force, 0), 0.5)
    average = min(max(min(force - 4, 9 - force), 0), 0.5)
    large = min(max(force - 8, 0), 0.5)
    mixed = min(average, large)
    return [small, min(small, average), max(min(small, large), average), mixed, mixed, large]


def test_a_controller_in_the_loop_chooses_as_its_rules_say() -> None:
    read, _ = load(str(SAMPLES / "push_recovery.ha"))
    assert read is not None
    spec, _ = elaborate(read.tree, read.files)
    assert spec is not None
    model = SimulatedAutomaton(spec, spec.automata[0])
    draw = Drawing(model, 5.0).nominal()
    recover = model.mode("Recover")
    place = [o.name for o in model.outputs].index("strat")
    terms = dict(spec.fuzzy[1].outputs)["strategy"]
    for force in range(0, 121, 3):
        state = list(draw.state)
        state[model.places["peak"]] = force / 10
        register = model._output(model.codes[recover], model.outputs[place], spec.automata[0].modes[recover])
        strengths = by_hand(force / 10)
        first = strengths.index(max(strengths)) if max(strengths) > 0 else -1
        assert model.kernel.values(recover, state)[register] == (
            float(model.values.positions["Strategy"][terms[first]]) if first >= 0 else -1.0
        )


def test_a_hard_push_falls_and_a_weak_one_does_not(capsys: pytest.CaptureFixture[str]) -> None:
    call = ["simulate", str(SAMPLES / "push_recovery.ha"), "--until", "3s", "-n", "12", "--format", "json"]
    assert main(call) == 0
    runs = json.loads(capsys.readouterr().out)
    fallen = [r["end"]["mode"] == "Fallen" for r in runs]
    hardest = [max(x for s in r["stays"] for x in s["peak"]) for r in runs]
    assert any(fallen) and not all(fallen)
    assert all(p > 8.4 for p, f in zip(hardest, fallen, strict=True) if f)


@pytest.mark.parametrize(("kind", "at_two"), [("linear", 3.0), ("hold", 2.0)])
def test_a_table_is_followed_over_its_corners_and_ends_where_it_has_no_value(
    kind: str, at_two: float, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "speed.csv").write_text("x,v\n0,1\n1,2\n2,4\n3,4\n")
    path = tmp_path / "tabled.ha"
    path.write_text(TABLED.replace("INTERPOLATE", kind))
    assert main(["simulate", str(path), "--until", "9s", "--format", "json", "--samples", "9000"]) == 0
    (run,) = json.loads(capsys.readouterr().out)
    assert run["end"]["how"] == "undefined"
    (stay,) = run["stays"]
    near = min(range(len(stay["x"])), key=lambda k: abs(stay["x"][k] - 1.5))
    slope = (stay["x"][near + 1] - stay["x"][near - 1]) / (stay["time"][near + 1] - stay["time"][near - 1])
    assert abs(slope - at_two) < 0.01 and abs(stay["x"][-1] - 3) < 1e-6
