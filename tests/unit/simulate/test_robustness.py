"""Margins of bounded time formulas on runs: closed forms, dense time, and the exact decision procedure."""

import math
from pathlib import Path

import pytest

from haverify.elaborate.elaborate import elaborate
from haverify.model.spec import Spec
from haverify.run.load import load
from haverify.simulate.certify import certified
from haverify.simulate.draws import Drawing
from haverify.simulate.falsify import searched, subject
from haverify.simulate.formula import asked_of_runs
from haverify.simulate.model import SimulatedAutomaton
from haverify.simulate.run import Settings, followed

ROOT = Path(__file__).parents[3]


def spec_of(path: Path) -> Spec:
    read, _ = load(str(path))
    assert read is not None
    spec, _ = elaborate(read.tree, read.files)
    assert spec is not None
    return spec


def margins(path: Path, until: float = 10.0) -> dict[str, float]:
    """The margin of the first goal of each claim on the nominal run."""
    spec, found = spec_of(path), {}
    for claim in spec.claims:
        automaton = next(a for a in spec.automata if a.name == claim.on)
        asked = asked_of_runs(spec, automaton, claim, claim.goals[0], until)
        model = SimulatedAutomaton(spec, automaton, asked.observed, asked.landings)
        run = followed(model, Drawing(model, asked.horizon).nominal(), Settings(asked.horizon))
        found[claim.name] = run.record.robustness(asked.words)
    return found


WAVE = """spec "wave" version "1.0" unitless
automaton A {
  var x in [-2, 2]; var y in [-2, 2]
  init M with { x := 0; y := 1 }
  mode M { flow { x' = y; y' = -x } }
}
property peak on A { stl globally[0, 6] x <= 2 }
property inner on A { stl globally[0, 6] eventually[0.5, 2] x >= 0.25 }
property later on A { stl eventually[2, 3] globally[0, 1] x >= 0.1 }
property both on A { stl (globally[0, 3] x >= -0.5) and eventually[4, 5] x <= -0.9 }
property before on A { stl x >= -0.5 until[0, 4] y <= -0.5 }
property slope on A { within 6; always abs(der(x)) <= 1.5 }
property during on A { always during [1, 2] x >= 0.5 }
"""


def test_margins_are_those_of_the_closed_form(tmp_path: Path) -> None:
    (tmp_path / "wave.ha").write_text(WAVE)
    found = margins(tmp_path / "wave.ha")
    expected = {
        "peak": 1.0,
        # sin is least at its best in a window that starts at 5 pi / 2 - 2, or whose ends 0.5 and 2 later are level.
        "inner": min(max(math.sin(t + 0.5), math.sin(t + 2), 1.0 if (t + 0.5) <= math.pi / 2 <= t + 2 else -1.0)
                     for t in [k * 6 / 200000 for k in range(200001)]) - 0.25,
        "later": math.sin(3.0) - 0.1,
        "both": 0.1 - 2 * (1 - 1),
        "before": 0.5,
        "slope": 0.5,
        "during": math.sin(1) - 0.5,
    }  # fmt: skip
    expected["both"] = min(0.5, 0.1)
    for name in ("peak", "later", "both", "slope", "during"):
        assert math.isclose(found[name], expected[name], abs_tol=1e-12), name
    assert math.isclose(found["inner"], expected["inner"], abs_tol=1e-4)
    assert math.isclose(found["before"], 0.5, abs_tol=1e-9)


def test_extrema_between_samples_count(tmp_path: Path) -> None:
    text = WAVE.split("property")[0] + "property p on A { stl globally[0, 6] x <= 0.9999999999 }"
    (tmp_path / "near.ha").write_text(text)
    assert math.isclose(margins(tmp_path / "near.ha")["p"], -1e-10, rel_tol=1e-4)


@pytest.mark.parametrize("name", ["gait_temporal.ha"])
def test_margins_agree_with_the_exact_decision(name: str) -> None:
    """Claims proved of all runs have no negative margin on any; those refuted have one on some."""
    spec = spec_of(ROOT / "spec" / name)
    seen = 0
    for claim in spec.claims:
        if claim.name == "flexed_until_push_off" or claim.expect is None:
            continue
        automaton = next(a for a in spec.automata if a.name == claim.on)
        found = searched(subject(spec, automaton, claim, claim.goals[0], 10.0, "earliest", 0), 80, 0)
        assert found.is_violated == (claim.expect.verdict == "refuted"), claim.name
        seen += 1
    assert seen >= 3


def test_a_violation_is_found_and_certified_by_enclosures() -> None:
    spec = spec_of(ROOT / "tests" / "samples" / "rocking_block.ha")
    claim = next(c for c in spec.claims if c.name == "printed_sign_is_wrong")
    automaton = next(a for a in spec.automata if a.name == claim.on)
    found = searched(subject(spec, automaton, claim, claim.goals[0], 10.0, "earliest", 0), 200, 0)
    assert found.is_violated and found.run is not None
    assert certified(found.run, claim, claim.goals[0]).run is not None


DRIVEN = """spec "driven" version "1.0" unitless
input u in [-1, 1]
automaton A {
  var x in [-9, 9]; var y in [-9, 9]
  init M with { x := 0; y := 0 }
  mode M { flow { x' = y; y' = -x + u } }
}
property small on A { within 6; always x <= %s }
"""


@pytest.mark.parametrize(("bound", "violated"), [("2.5", True), ("4", False)])
def test_inputs_are_searched_and_a_certified_run_has_them(tmp_path: Path, bound: str, violated: bool) -> None:
    (tmp_path / "driven.ha").write_text(DRIVEN % bound)
    spec = spec_of(tmp_path / "driven.ha")
    claim = spec.claims[0]
    found = searched(subject(spec, spec.automata[0], claim, claim.goals[0], 10.0, "earliest", 0), 400, 0)
    assert found.is_violated == violated
    if violated and found.run is not None:
        assert certified(found.run, claim, claim.goals[0]).run is not None
