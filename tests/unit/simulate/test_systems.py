"""Systems put together: syncs, broadcasts, shared inputs; random runs keep what is proved of the system."""

from pathlib import Path

from haverify.analyses.networks.product import Product
from haverify.elaborate.elaborate import elaborate
from haverify.model.core import to_core
from haverify.model.spec import Spec
from haverify.run.load import load
from haverify.simulate.draws import Drawing
from haverify.simulate.falsify import searched, subject
from haverify.simulate.model import SimulatedAutomaton
from haverify.simulate.run import Settings, followed

SAMPLES = Path(__file__).parents[2] / "samples"


def spec_of(path: Path) -> Spec:
    read, _ = load(str(path))
    assert read is not None
    spec, _ = elaborate(read.tree, read.files)
    assert spec is not None
    return spec


def test_no_random_run_of_fischer_breaks_exclusion_and_some_enter() -> None:
    spec = spec_of(SAMPLES / "fischer.ha")
    whole = Product(spec, to_core(spec), "Fischer")
    automaton = whole.automaton()
    model = SimulatedAutomaton(spec, automaton)
    draw = Drawing(model, 30.0).nominal()
    entered = 0
    for seed in range(40):
        run = followed(model, draw, Settings(30.0, policy="random", seed=seed))
        modes = [automaton.modes[p[0]].name for p in run.record.pieces()]
        assert all(m.count("Critical") <= 1 for m in modes)
        entered += any("Critical" in m for m in modes)
    assert entered > 3
    claim = next(c for c in spec.claims if c.name == "exclusion")
    told = whole.claim(claim)
    assert not searched(subject(spec, automaton, told, told.goals[0], 10.0, "random", 0), 32, 0).is_violated


BROADCAST = """spec "broadcast" version "1.0" unitless
automaton Bell { var t; init Quiet with t := 0; mode Quiet { domain t <= 1; flow { t' = 1 } }
  urgent edge ring: Quiet -> Quiet when t >= 1 do t := 0 }
automaton Sleeper { var n; init Asleep with n := 0; mode Asleep { flow { n' = 1 } }; mode Awake { flow { n' = 1 } }
  edge wake: Asleep -> Awake when n >= 1.5 do n := 0 }
system House {
  var rung in [0, 99]
  init with rung := 0; flow { rung' = 0 }
  part bell = Bell
  part a = Sleeper
  sync wakes: bell.ring -> a.wake do rung := rung + 1
}
"""


def test_a_broadcast_takes_along_whoever_is_ready(tmp_path: Path) -> None:
    (tmp_path / "house.ha").write_text(BROADCAST)
    spec = spec_of(tmp_path / "house.ha")
    model = SimulatedAutomaton(spec, Product(spec, to_core(spec), "House").automaton())
    run = followed(model, Drawing(model, 4.5).nominal(), Settings(4.5))
    modes = [model.automaton.modes[p[0]].name for p in run.record.pieces()]
    assert [round(j[0], 12) for j in run.jumps] == [1, 2, 3, 4]
    assert modes[0] == "bell.Quiet, a.Asleep" and modes[-1] == "bell.Quiet, a.Awake"
    assert run.state[model.places["rung"]] == 4 and run.state[model.places["a.n"]] == 2.5
