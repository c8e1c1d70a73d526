"""Systems of parts with flows: what is decided of them is what is decided of their parts, whatever their order."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import pytest

from haverify.analyses.networks.product import Product
from haverify.analyses.networks.whole import whole_of
from haverify.analyses.portfolio import decide
from haverify.evidence.verdict import Proved, Refuted
from haverify.model.core import to_core
from haverify.model.spec import Spec
from haverify.run.examine import read
from haverify.simulate.crosscheck import Beside
from haverify.simulate.draws import Drawing
from haverify.simulate.model import SimulatedAutomaton
from haverify.simulate.run import Settings, followed

Q = Fraction
SAMPLES = Path(__file__).parents[1] / "samples"
WORDS = {Proved: "proved", Refuted: "refuted"}

ROOM = """automaton Room {
  param beside in [9.98, 10]
  const first = 20
  var T in [0, 40]
  init Off where first <= T <= first + 0.01
  mode Off { domain T >= 17; flow { T' = 0.2 * (beside - T) }
    urgent edge heat: -> On when T <= 18 }
  mode On { domain T <= 23; flow { T' = 0.2 * (beside - T) + 4 }
    urgent edge cool: -> Off when T >= 21 }
}
"""
SWING = """automaton Swing {
  var x in [-5, 5]
  var v in [-5, 5]
  init Free where 1 <= x <= 1.1 with v := 0
  mode Free { flow { x' = v; v' = -x - 0.1 * v } }
}
"""
# Goals about `Room` under the name P; the last ones fail.
GOALS = [
    "within 4; always 17.5 <= P.T and P.T <= 21.5",
    "within 1; never at(P.On)",
    "reach at(P.On) within 2",
    "can reach at(P.On) and P.T >= 19 within 3",
    "stl globally[0, 2] P.T <= 20.5",
    "within 4; always jump(P.heat) implies P.T <= 18.01",
    "within 4; always P.T >= 18.5",
    "reach P.T >= 20.9 within 1",
    "can reach P.T >= 22 within 4",
]
LAST = len(GOALS) - 3


def spec_of(folder: Path, text: str) -> Spec:
    path = folder / "system.ha"
    path.write_text('spec "S" version "1.0" unitless\n' + text, encoding="utf-8")
    spec, _, found = read(str(path))
    assert spec is not None, found
    return spec


def words(spec: Spec) -> list[str]:
    return [WORDS.get(type(decide(spec, c).verdict), "unknown") for c in spec.claims]


def claims(on: str, prefix: str) -> str:
    goals = (g.replace("P.", prefix) for g in GOALS)
    return "".join(f"property c{k} on {on} {{ {g} }}\n" for k, g in enumerate(goals))


def test_a_part_alone_beside_others_and_in_any_order_has_the_verdicts_of_its_automaton(tmp_path: Path) -> None:
    alone = words(spec_of(tmp_path, ROOM + claims("Room", "")))
    assert alone == ["proved"] * LAST + ["refuted"] * 3
    systems = ["part p = Room", "part p = Room\n  part s = Swing", "part s = Swing\n  part p = Room"]
    for parts in systems:
        text = ROOM + SWING + f"system S {{\n  {parts}\n}}\n" + claims("S", "p.")
        assert words(spec_of(tmp_path, text)) == alone, parts


def test_six_tanks_and_a_pump_have_the_verdicts_that_are_known() -> None:
    spec, _, _ = read(str(SAMPLES / "six_tanks.ha"))
    assert spec is not None
    assert words(spec) == [c.expect.verdict for c in spec.claims if c.expect is not None]
    low = decide(spec, next(c for c in spec.claims if c.name == "low"))
    assert low.run is not None and [n for n, _ in low.run.values if n == "tank[4].level"]
    assert low.run.path[-1].mode.startswith("pump.Idle, tank[1].Draining")


def test_sampled_runs_stay_inside(tmp_path: Path) -> None:
    spec, _, _ = read(str(SAMPLES / "six_tanks.ha"))
    assert spec is not None
    claim = next(c for c in spec.claims if c.name == "never_over")
    pipe = decide(spec, claim).flowpipe
    whole = whole_of(spec, "Yard", to_core(spec))
    told = next(c for c in whole.claims if c.name == claim.name)
    beside = Beside(whole, whole.automata[0], told, pipe)
    assert beside.disagreement(20.0, runs=40) is None and beside.checked == 40


BELL = """automaton Bell { var t in [0, 9]; init Quiet with t := 0; mode Quiet { domain t <= 1; flow { t' = 1 } }
  urgent edge ring: Quiet -> Quiet when t >= 1 do t := 0 }
automaton Cup { const low = 0; var x in [-1, 9]; init Down where 1 <= x <= 1.1
  mode Down { flow { x' = -0.5 * x } }
  mode Up { domain x >= low; flow { x' = 1 - 0.5 * x } }
  edge turn: Down -> Up when x <= 0.9 }
"""


@pytest.mark.parametrize("low", ["0", "0.6"])
def test_who_listens_joins_where_it_may_enter_its_mode(tmp_path: Path, low: str) -> None:
    text = BELL + f"system S {{ part b = Bell\n part c = Cup with {{ low = {low} }}\n sync r: b.ring -> c.turn }}\n"
    text += "property p on S { reach at(c.Up) within 1.5 }\nproperty turns on S { reach jump(c.turn) within 1.5 }\n"
    text += "property q on S { reach jump(r) within 1.5 }\n"
    assert words(spec_of(tmp_path, text)) == ["proved", "proved", "proved"]


def test_who_listens_stays_out_where_it_may_not_enter_and_the_rest_goes_on(tmp_path: Path) -> None:
    """At 1 s the cup holds less than 0.7, and its next mode asks for 0.95."""
    text = BELL + "system S { part b = Bell\n part c = Cup with { low = 0.95 }\n sync r: b.ring -> c.turn }\n"
    spec = spec_of(tmp_path, text)
    model = SimulatedAutomaton(spec, Product(spec, to_core(spec), "S").automaton())
    run = followed(model, Drawing(model, 2.5).nominal(), Settings(2.5))
    assert [round(j[0], 9) for j in run.jumps] == [1, 2]
    assert {model.automaton.modes[p[0]].name for p in run.record.pieces()} == {"b.Quiet, c.Down"}


RACE = """automaton Cup { var x in [-9, 9]; init Down where 1 <= x <= 1.1
  mode Down { flow { x' = -0.5 * x } }
  mode Up { flow { x' = 1 - 0.5 * x } }
  urgent edge a: Down -> Up when x <= 0.8
  urgent edge b: Down -> Up when x <= 0.8 do x := 5
  urgent edge c: Down -> Up when x <= 0.8 do x := 6 }
"""


@pytest.mark.parametrize(
    ("order", "wanted"),
    [
        ("priority c.a over c.b over c.c", "proved"),
        ("priority c.a over c.b when c.x <= 0.9\n priority c.b over c.c", "proved"),
        ("priority c.a over c.b\n priority c.b over c.c when c.x >= 2", "refuted"),
        ("priority c.b over c.a\n priority c.b over c.c", "refuted"),
    ],
)
def test_a_priority_silences_what_is_below_it_where_it_holds(tmp_path: Path, order: str, wanted: str) -> None:
    text = f"{RACE}system S {{ part c = Cup\n {order} }}\nproperty p on S {{ within 2; always c.x <= 3 }}\n"
    assert words(spec_of(tmp_path, text)) == [wanted]


def test_params_of_parts_are_their_own_and_may_be_narrowed(tmp_path: Path) -> None:
    text = """automaton A { param k in [0, 2]; var x in [-9, 9]; init M with x := 1; mode M { flow { x' = -k * x } } }
system S { part a = A with { k in [1, 2] }
  part b = A with { k = 0.5 } }
property one on S { reach a.x <= 0.4 within 1 }
property two on S { within 1; always b.x >= 0.6 }
property both on S { within 1; always a.x >= 0.1 }
"""
    assert words(spec_of(tmp_path, text)) == ["proved", "proved", "proved"]
