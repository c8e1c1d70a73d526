"""Random flows with an invariant planted, or a violation: no verdict on them is wrong."""

from __future__ import annotations

import copy
import json
from fractions import Fraction as Q
from random import Random

import pytest
from tests.unit.elaborate.texts import read

from hacheck.core import Core
from hacheck.obligations import Setting, established
from haverify.analyses.induction.decide import decide_invariant
from haverify.analyses.induction.refutation import by_run
from haverify.evidence.verdict import Proved, Refuted
from haverify.model.core import canonical, to_core
from haverify.obligations.induction import Induction

SYSTEMS = 200


def planted(seed: int, sign: int) -> str:
    """A flow across the level sets of a random ellipse, inwards where `sign` is -1, outwards where it is 1, or along.

    With g = a x^2 + b x y + c y^2 - 1 positive definite up to the constant, the flow is q J grad g + s grad g: the
    slope of g is s |grad g|^2, and s is `sign` times a positive number plus squares.
    """
    r = Random(seed)
    a, c = r.randint(1, 4), r.randint(1, 4)
    b = r.randint(-1, 1)
    gx, gy = f"({2 * a} * x + {b} * y)", f"({b} * x + {2 * c} * y)"
    turn = r.choice(["1", "2", "x", "(1 + y^2)", "(x - y)", "-1"])
    push = f"({sign}) * ({r.choice(['1/2', '1', '1/4'])} + {r.choice(['0', 'x^2', 'y^2', '(x - y)^2'])})"
    size = r.choice(["1/4", "1/9"]) if sign < 1 else "1"
    low = f" and 1/4 <= {a} * x^2 + {b} * x * y + {c} * y^2" if sign == 1 else ""
    g = f"{a} * x^2 + {b} * x * y + {c} * y^2"
    return f"""
spec "planted" version "1.0" unitless
automaton A {{
  var x
  var y
  init M where {g} <= {size}{low}
  mode M {{ flow {{ x' = {turn} * {gy} + {push} * {gx}; y' = -({turn}) * {gx} + {push} * {gy} }} }}
}}
invariant inside on A: {g} <= 1 inductive
"""


def verdict_on(text: str) -> str:
    """What induction says, a proof of it accepted by the second checker."""
    spec, _, _ = read(text.strip())
    core = json.loads(canonical(to_core(spec)))
    found = decide_invariant(spec, spec.automata[0], spec.claims[0], core)
    if not isinstance(found.verdict, Proved):
        return "refuted" if isinstance(found.verdict, Refuted) else "unknown"
    known = Core(copy.deepcopy(core))

    def setting(automaton: object, rounding: bool) -> Setting:
        return Setting(known, automaton, rounding, lambda _: None)

    assert established(known, known.claims["inside"], json.loads(canonical(found.certificate)), setting)[0] == "proved"
    return "proved"


@pytest.fixture
def is_brief(monkeypatch: pytest.MonkeyPatch) -> None:
    """Few starts, short runs, no programs: what is not decided so stays open."""
    monkeypatch.setattr("haverify.analyses.induction.refutation.STARTS", 2)
    monkeypatch.setattr("haverify.analyses.induction.refutation.STEPS", 100)
    monkeypatch.setattr("haverify.analyses.induction.decide._shown", lambda _, before, _seconds: before)


@pytest.mark.usefixtures("is_brief")
def test_what_is_kept_is_never_refuted_and_what_is_left_never_proved() -> None:
    kept = [verdict_on(planted(seed, 0 if seed % 4 == 0 else -1)) for seed in range(SYSTEMS)]
    left = [verdict_on(planted(seed, 1)) for seed in range(SYSTEMS)]
    assert "refuted" not in kept
    assert "proved" not in left
    assert kept.count("proved") >= SYSTEMS / 4
    assert left.count("refuted") >= SYSTEMS / 4


def test_a_param_with_one_value_has_it_in_runs() -> None:
    """With k = 0 the run would go down at once."""
    text = """
spec "one" version "1.0" unitless
param k in [2, 2]
automaton A { var x; init M where x == 1; mode M { flow { x' = (k - 1) - x / 2 } } }
property p on A { always x >= 0 }
"""
    spec, _, _ = read(text.strip())
    induction = Induction(spec, spec.automata[0], spec.claims[0], spec.claims[0].goals[0])
    induction.check()
    assert by_run(induction) is None
    assert Q(1) == induction.params["k"][0] / 2
