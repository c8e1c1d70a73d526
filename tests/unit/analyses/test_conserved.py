"""What flows and jumps keep: found exactly, true of simulated runs, and decided by the starts in claims."""

from __future__ import annotations

import random
from collections.abc import Callable
from fractions import Fraction as Q

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.unit.elaborate.texts import read

from haverify.analyses.hybrid.conditions import Atom, Some, condition
from haverify.analyses.hybrid.conserved import Conserved, conserved, decides, kernel
from haverify.analyses.hybrid.decide import decide_flow
from haverify.analyses.hybrid.model import hybrid_model
from haverify.analyses.hybrid.question import question_of
from haverify.analyses.hybrid.runs import by_a_run
from haverify.analyses.portfolio import decide_all
from haverify.evidence.verdict import Proved, Refuted, Unknown
from haverify.maths.polynomial import Polynomial
from haverify.model.expression import Expr
from haverify.model.spec import Spec
from haverify.text.record import replace

REACTION = "x' = -0.4 * x + 100 * y * z; y' = 0.4 * x - 100 * y * z - 1000 * y^2; z' = 1000 * y^2"
PLANKTON = "x' = -x * y / (1 + x); y' = x * y / (1 + x) - 0.3 * y; z' = 0.3 * y"
BODY = "x' = y * z; y' = -2 * x * z; z' = x * y"
DRIVEN = "x' = -3 * sin(x) + u; y' = 0; z' = 3 * sin(x) - u"
CHAIN = "x' = -x + u; y' = x - y; z' = y - u"
POINT = "x == 9.75 and y == 0.01 and z == 0.01"
ROOT = Expr(">=", (Expr("sqrt", (Expr("var", ("y",)),)), Expr("num", (Q(-5),))))
BOX = "9.5 <= x <= 10 and y == 0.01 and z == 0.01"


def spec_of(flow: str, start: str, claim: str, more: str = "", inputs: str = "") -> Spec:
    text = f"""
spec "Kept" version "1.0" unitless
{inputs}
automaton A {{
  var x
  var y
  var z
  init M where {start}
  mode M {{
    flow {{ {flow} }}
    {more}
  }}
}}
property p on A {{ within 2; {claim} }}
"""
    return read(text.strip())[0]


def kept(flow: str, start: str = POINT, claim: str = "always x <= 99", **more: str) -> Conserved:
    spec = spec_of(flow, start, claim, **more)
    model = hybrid_model(spec, spec.automata[0], [spec.claims[0].goals[0].condition])
    found = conserved(model)
    assert found is not None
    return found


def forms(found: Conserved) -> list[dict[str, Q]]:
    return [{m[0][0]: c for m, c in law.form.terms.items()} for law in found.laws]


ALL = {"x": Q(1), "y": Q(1), "z": Q(1)}


def test_linear_laws_are_the_null_space() -> None:
    assert forms(kept(REACTION)) == forms(kept(PLANKTON)) == [ALL]
    (law,) = kept(PLANKTON, BOX).laws
    assert (law.low, law.high) == (Q("9.52"), Q("10.02"))
    assert forms(kept(BODY)) == forms(kept("x' = x - x * y; y' = x * y - y; z' = x * z")) == []
    timed = kept("x' = 2; y' = 3 * sin(x); z' = -sin(x)")
    ratios = [{v: c / f["x" if "x" in f else "y"] for v, c in f.items()} for f in forms(timed)]
    assert sorted(ratios, key=repr) == sorted([{"x": Q(1), "time": Q(-2)}, {"y": Q(1), "z": Q(3)}], key=repr)


def test_an_input_that_enters_breaks_a_law_and_one_that_cancels_does_not() -> None:
    inputs = "input u in [0, 1]"
    assert forms(kept(CHAIN, inputs=inputs)) == [ALL]
    assert forms(kept(CHAIN.replace("y - u", "y - 0.9 * u"), inputs=inputs)) == []
    assert forms(kept("x' in [0, 1]; y' = -x; z' = x")) == [{"y": Q(1), "z": Q(1)}]


def test_resets_break_laws_or_keep_them() -> None:
    edge = "edge e: -> M when x <= 9 do {{ x := {x}; y := {y} }}"
    assert forms(kept(PLANKTON, more=edge.format(x="x - 1", y="y + 1").replace("{{", "{").replace("}}", "}"))) == [ALL]
    assert forms(kept(PLANKTON, more=edge.format(x="y", y="x").replace("{{", "{").replace("}}", "}"))) == [ALL]
    assert forms(kept(PLANKTON, more=edge.format(x="x - 1", y="y").replace("{{", "{").replace("}}", "}"))) == []
    assert forms(kept(PLANKTON, more="edge e: -> M when x <= 9 do x in [8, 9]")) == []


def test_quantities_of_higher_degree_are_kept_too() -> None:
    found = kept(BODY)
    x, y, z = (Polynomial({((v, 2),): 1}) for v in "xyz")
    assert found.keeps(x.scaled(Q(2)) + y) and found.keeps(y + z.scaled(Q(2))) and not found.keeps(x + y)


@given(st.lists(st.lists(st.integers(-3, 3), min_size=4, max_size=4), min_size=1, max_size=5))
@settings(max_examples=100, derandomize=True, deadline=None)
def test_the_kernel_is_taken_to_zero_and_is_as_large_as_it_should_be(rows: list[list[int]]) -> None:
    found = kernel([[Q(x) for x in r] for r in rows])
    assert all(sum(a * b for a, b in zip(r, v, strict=True)) == 0 for r in rows for v in found)
    import numpy as np

    assert len(found) == 4 - np.linalg.matrix_rank(np.array(rows, dtype=float))


Rates = Callable[[tuple[float, ...]], tuple[float, ...]]
RATES: dict[str, Rates] = {
    PLANKTON: lambda s: (-s[0] * s[1] / (1 + s[0]), s[0] * s[1] / (1 + s[0]) - 0.3 * s[1], 0.3 * s[1]),
    BODY: lambda s: (s[1] * s[2], -2 * s[0] * s[2], s[0] * s[1]),
}


def end_of(rates: Rates, state: tuple[float, ...], steps: int = 200, h: float = 0.01) -> tuple[float, ...]:
    """Where the classical Runge-Kutta method comes to."""

    def ahead(k: tuple[float, ...], share: float) -> tuple[float, ...]:
        return tuple(x + share * h * r for x, r in zip(state, k, strict=True))

    for _ in range(steps):
        a = rates(state)
        b = rates(ahead(a, 0.5))
        c = rates(ahead(b, 0.5))
        d = rates(ahead(c, 1.0))
        mean = tuple((p + 2 * q + 2 * r + s) / 6 for p, q, r, s in zip(a, b, c, d, strict=True))
        state = ahead(mean, 1.0)
    return state


@pytest.mark.parametrize(("flow", "start"), [(PLANKTON, BOX), (BODY, "0 <= x <= 1 and 0 <= y <= 1 and z == 1")])
def test_what_is_kept_is_kept_by_runs_in_floats_and_in_its_range(flow: str, start: str) -> None:
    found, chance = kept(flow, start), random.Random(2)
    quantities = [law.form for law in found.laws]
    quantities += [Polynomial({(("x", 2),): 2, (("y", 2),): 1})] if flow is BODY else []
    assert quantities and all(found.keeps(q) for q in quantities)
    (begun,) = found.model.starts
    for _ in range(5):
        first = tuple(chance.uniform(float(low), float(high)) for low, high in begun.box[:3])
        last = end_of(RATES[flow], first)
        for q in quantities:
            ends = [float(q.value({v: Q(s["xyz".index(v)]) for v in q.variables})) for s in (first, last)]
            low, high = found.at_starts(q)
            assert abs(ends[0] - ends[1]) < 1e-7 and float(low) - 1e-7 <= ends[1] <= float(high) + 1e-7
    moved = Polynomial({(("x", 1),): 1, (("z", 1),): 2})
    assert not found.keeps(moved)


def verdict(flow: str, start: str, claim: str) -> type:
    return type(decide_all(spec_of(flow, start, claim))["p"].verdict)


def test_claims_about_what_is_kept_are_decided_to_the_last_digit() -> None:
    assert verdict(PLANKTON, POINT, "always x + y + z == 9.77") is Proved
    assert verdict(PLANKTON, POINT, "always x + y + z < 9.77") is Refuted
    assert verdict(PLANKTON, POINT, "can reach x + y + z > 9.77") is Refuted
    assert verdict(PLANKTON, POINT, "reach x + y <= 9.77 - z within 1") is Proved
    assert verdict(PLANKTON, POINT, "always x + y + z <= 9.77 and x <= 1") is Refuted


def test_with_one_value_bounds_hold_where_they_hold_without_a_variable() -> None:
    found = kept(PLANKTON)
    spec = spec_of(PLANKTON, POINT, "always x + y <= 9")
    atom = condition(spec.claims[0].goals[0].condition, {})
    told = found.simpler(atom, 0)
    assert isinstance(told, Some) and isinstance(atom, Atom) and told.members[0] == atom
    p = found.normal.of(atom.quantity, {})
    for other in told.members[1:]:
        assert isinstance(other, Atom) and other.op == atom.op
        q = found.normal.of(other.quantity, {})
        assert len(q.variables) <= 2 and found.keeps(p - q) and found.at_starts(p - q) == (0, 0)
    assert ("z",) in {found.normal.of(a.quantity, {}).variables for a in told.members if isinstance(a, Atom)}
    assert kept(PLANKTON, BOX).simpler(atom, 0) == atom
    equal = Atom(atom.quantity, "==")
    assert found.simpler(equal, 0) == equal
    assert decides(spec, spec.automata[0], spec.claims[0])
    other_spec = spec_of(PLANKTON, BOX, "always x + 2 * y <= 9")
    assert not decides(other_spec, other_spec.automata[0], other_spec.claims[0])


def test_a_bound_that_an_enclosure_misses_is_shown_by_the_other_variables() -> None:
    def found(claim: str, with_laws: bool) -> type:
        start = "x == 0 and y == 0 and z == 0"
        spec = spec_of(DRIVEN, start, claim, inputs="input u in [-0.5, 0.5]")
        return type(decide_flow(spec, spec.automata[0], spec.claims[0], None, with_laws=with_laws).verdict)

    assert found("always z <= 0.4", False) is Unknown and found("always z <= 0.4", True) is Proved
    assert found("always z <= 0.1", True) is Refuted  # x tends to -0.1674 where u is -0.5


def test_what_is_very_large_is_not_looked_at() -> None:
    power = " * ".join(f"(1 + {a} * x + {b} * y + z)" for a, b in [(1, 2), (3, 4), (5, 6), (7, 8), (9, 10)] * 3)
    spec = spec_of(f"x' = {power}; y' = 1; z' = 0", POINT, "always x <= 9")
    assert conserved(hybrid_model(spec, spec.automata[0], [spec.claims[0].goals[0].condition])) is None


def test_terms_that_have_no_value_do_not_cancel() -> None:
    """Claims say that all they name is defined (LANGUAGE S1): the square root never is."""
    claim = "reach z + sqrt(y - 2) - sqrt(y - 2) >= 0.5 within 2"
    spec = spec_of("x' = -y; y' = x; z' = 0", "0.9 <= x <= 1 and -0.1 <= y <= 0.1 and 1 <= z <= 1.1", claim)
    assert isinstance(decide_all(spec)["p"].verdict, Unknown)


def test_a_claim_without_a_value_is_no_fault_of_the_claims_that_share_its_flowpipe() -> None:
    spec = spec_of("x' = -y; y' = x; z' = 0", "0.9 <= x <= 1 and -0.1 <= y <= 0.1 and z == 1", "always x <= 5")
    second = replace(spec.claims[0], name="q", goals=(replace(spec.claims[0].goals[0], condition=ROOT),))
    found = decide_all(replace(spec, claims=(*spec.claims, second)))
    assert isinstance(found["p"].verdict, Proved)
    assert isinstance(found["q"].verdict, Unknown)


@pytest.mark.parametrize(("claim", "followed"), [("x + y + z >= 10", 1), ("x + y + z >= 11", 0), ("x >= 9.99", 3)])
def test_starts_that_keep_the_goal_out_of_reach_are_not_followed(claim: str, followed: int) -> None:
    spec = spec_of(PLANKTON, BOX, f"can reach time >= 1 and {claim}")
    goal = spec.claims[0].goals[0]
    question = question_of(hybrid_model(spec, spec.automata[0], [goal.condition]), spec.claims[0], goal)
    _, run = by_a_run(question)
    assert (run is not None) is (followed == 1)
    assert len(question.points) == followed
