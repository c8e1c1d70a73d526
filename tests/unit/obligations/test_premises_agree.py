"""The questions that haverify asks and those that the second checker derives are the same, entry by entry."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Iterable
from fractions import Fraction
from typing import Any

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from tests.unit.elaborate.texts import read

from hacheck import positivity
from hacheck.core import Core
from hacheck.functions import Functions as SecondFunctions
from hacheck.invariants import Induction as Second
from hacheck.obligations import Question, Setting
from hacheck.rational import Beyond
from haverify.maths.polynomial import constant, variable
from haverify.model.core import canonical, to_core
from haverify.obligations.formula import disjunction, literal
from haverify.obligations.functions import Functions
from haverify.obligations.induction import Induction
from haverify.obligations.premises import Premises, formula_json, polynomial_json
from haverify.obligations.translate import OutsideFragmentError

Json = Any

PIECES = """
spec "Pieces" version "1.0" unitless
enum Gear = 1..3
param k in [1/2, 2]
param one in [1, 1]
const half = 1/2
assume k <= 3/2
automaton A {
  input u in [-k, 2]
  var x
  var y in [-5, 5]
  var g: Gear
  let energy = x^2 / 2 + half * y^2
  let good = abs(x) <= 2 and energy < 9
  init Go where 0 <= x <= 1 with { y in [0, k]; g := 1 }
  init where abs(x) < 1 and energy <= 1/4 and g == 2
  mode Go {
    domain abs(x) <= 3 and not (x > 2 and y == 1) and (x <= 1 or y < 2)
    flow { x' = y / k + log(y + 9) * u; y' = (-x + cos(x - 1)) / (1 + y^2) }
    edge up: -> Rest when max(x, y) >= 1 and g < 3 do { g := g + 1; y in [-k, x^2] }
    urgent edge over: -> Go when x > 2 and abs(y) != 1 do x := x * k - 1
    edge over: -> Go when sin(1 - x) > u and min(x, y) < x do x := u * k
  }
  mode Rest { terminal; domain clamp(x, 0, 1) <= y; flow { x' = 0; y' = exp(-y) } }
}
property first on A { always good implies max(x, 2 * y, -1) <= 10 }
property second on A { within 3; assume one <= 2; always not (abs(x - y) > 3 or at(Rest) and x / (k + 1) >= 2) }
property third on A { can reach min(x, y) >= 8 and not (energy == 4) }
property timed on A { always at(Go) implies x <= 1 + time }
property uses on A { always x <= 3; using kept }
property roots on A { always sqrt(x + y) <= 3 - log(2 * x) and sqrt(4) * x <= sqrt(2) }
invariant kept on A in Go: good or cos(x) <= 1 / (k + 1) inductive
"""


def plain(f: Any) -> Json:
    """A formula of the second checker as JSON, terms sorted."""
    if isinstance(f, bool):
        return f
    if f[0] in ("and", "or"):
        return [f[0], *map(plain, f[1:])]
    return [f[0], sorted([str(c), *m] for m, c in f[1].terms.items())]


def told(f: Json) -> Json:
    """The same of what haverify has."""
    if isinstance(f, bool):
        return f
    return [f[0], *map(told, f[1:])] if f[0] in ("and", "or") else [f[0], sorted(f[1])]


def entries(known: Premises) -> list[Json]:
    return [told(formula_json(f)) for f in known.entries]


def unique(found: Iterable[Json]) -> list[Json]:
    """Each once, in order."""
    return [json.loads(f) for f in dict.fromkeys(map(json.dumps, found))]


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[Json]:
    """The lists of premises that the second checker looks at, with no proof asked for, and those of what is read."""
    found: list[Json] = []
    read: list[Json] = []

    def seen(known: Any) -> None:
        found.append(([plain(f) for f in known.entries], unique(read)))
        read.clear()

    def defined(of: Second, *about: Any) -> None:
        read.extend([plain(f) for f in known.entries] for known in of.undefined(*about))

    class Flow:
        def __init__(self, always: Any, rates: Any, names: Any, has_inputs: bool = False) -> None:
            self.always = always

        def given(self, value: Json) -> Json:
            from hacheck.positivity import formula

            return formula(value)

        def kept(self, proof: Json, start: Any, wanted: Any) -> None:
            seen(self.always)

    monkeypatch.setattr("hacheck.invariants.refute", lambda _, known: seen(known))
    monkeypatch.setattr("hacheck.invariants.Induction.defined", defined)
    monkeypatch.setattr("hacheck.invariants.Flow", Flow)
    return found


@pytest.mark.parametrize("name", ["first", "second", "third", "timed", "uses", "kept", "roots"])
@pytest.mark.parametrize("is_bare", [True, False])
def test_premises_are_the_same_on_both_sides(name: str, is_bare: bool, asked: list[Json]) -> None:
    compare(PIECES, name, is_bare, asked)


def compare(text: str, name: str, is_bare: bool, asked: list[Json]) -> None:
    """Both sides ask the same of a claim."""
    asked.clear()
    spec, found, _ = read(text.strip())
    assert [d.message for d in found if d.code < "HA2" and "never read" not in d.message] == []
    claim = next(c for c in spec.claims if c.name == name)
    core = Core(json.loads(canonical(to_core(spec))))
    used = tuple(c.goals[0].condition for c in spec.claims if c.name in claim.using)
    mine = Induction(spec, spec.automata[0], claim, claim.goals[0], used)
    mine.check()
    bare = is_bare and not claim.inductive
    formulas = {m.name: True if bare else mine.aim(m.name) for m in spec.automata[0].modes}
    asking = ((ob, entries(ob.premises), unique(map(entries, ob.undefined))) for ob in mine.parts(formulas))
    parts = [(ob.kind, ob.where, (premises, undefined)) for ob, premises, undefined in asking]
    setting = Setting(core, core.automata["A"], False, lambda _: None, lambda n: core.claims[n])
    question = Question(setting, core.claims[name], core.claims[name]["goals"][0])
    modes = None if claim.inductive else {m: formula_json(f) for m, f in formulas.items()}
    second = Second(question, list(claim.using), modes)
    for m in formulas:
        rates = {v: sorted([str(c), *n] for n, c in p.terms.items()) for v, p in second.scope.field(m).items()}
        assert rates == {v: sorted(polynomial_json(p)) for v, p in mine.field(m).items()}
    for kind, where, check in second.parts():
        check(None)
        assert (kind, where, asked[-1]) == parts[len(asked) - 1]
    assert len(parts) == len(asked)


TERMS = ("x", "y", "2 * x - y", "x * y", "k", "1/2", "x^2", "x / k", "sin(x)", "sqrt(y + 3)",
         "exp(-x)", "(x + 1) / (1 + y^2)", "log(x^2 + 1)")  # fmt: skip
RATES = ("y", "-x", "x * y", "k * u", "u - x", "sin(k * x)", "x / (1 + x^2)", "log(2 + y^2)", "1 / k", "0")


@st.composite
def conditions(draw: Any, depth: int = 1) -> str:
    """A condition on the state."""
    if depth and draw(st.booleans()):
        a, b = draw(conditions(depth - 1)), draw(conditions(depth - 1))
        return draw(st.sampled_from([f"({a} and {b})", f"({a} or {b})", f"not ({a})", f"({a} implies {b})"]))
    op = draw(st.sampled_from(["<=", "<", ">=", ">", "==", "!="]))
    return f"{draw(st.sampled_from(TERMS))} {op} {draw(st.sampled_from(TERMS))}"


@settings(
    max_examples=25, deadline=None, derandomize=True, phases=[Phase.generate], suppress_health_check=list(HealthCheck)
)
@given(data=st.data(), is_bare=st.booleans())
def test_premises_of_random_models_are_the_same(asked: list[Json], data: st.DataObject, is_bare: bool) -> None:
    def drawn(of: st.SearchStrategy[str]) -> str:
        return data.draw(of)

    rate = st.sampled_from(RATES)
    text = f"""
spec "Random" version "1.0" unitless
param k in [1/2, 2]
input u in [-1, k]
automaton A {{
  var x
  var y
  init Go where {drawn(conditions())}
  mode Go {{
    domain {drawn(conditions(0))}
    flow {{ x' = {drawn(rate)}; y' = {drawn(rate)} }}
    edge a: -> Go when {drawn(conditions())} do x := {drawn(rate)}
    urgent edge b: -> Halt when {drawn(conditions(0))} do {{ x := 1; y in [-1, k] }}
  }}
  mode Halt {{ flow {{ x' = {drawn(rate)}; y' = 0 }} }}
}}
property p on A {{ always {drawn(conditions())} }}
"""
    with contextlib.suppress(OutsideFragmentError, Beyond):
        compare(text, "p", is_bare, asked)


def test_cases_that_become_alike_are_one_on_both_sides() -> None:
    """`2x - 1 < 0 or x - t < 1/2` has one case where t is 0."""
    cases = ["or", ["<", [["-1"], ["2", "x"]]], ["<", [["-1"], ["2", "x"], ["-2", "t"]]]]
    zero = positivity.polynomial([["0"]])
    theirs = positivity.Premises(SecondFunctions(), [positivity.formula(cases)]).mapped(positivity.Env({"t": zero}))
    x, t, half = variable("x"), variable("t"), constant(Fraction(1, 2))
    ours = disjunction([literal("<", x - half), literal("<", x - t - half)])
    mine = Premises(Functions(), (ours,)).mapped({"t": constant(0)})
    assert [plain(f) for f in theirs.entries] == [told(formula_json(f)) for f in mine.entries]
    assert len(theirs.entries) == 1 and theirs.entries[0][0] == "<"
