"""Verdicts on short specs written as people write them, and the checker's opinion of every certificate."""

from fractions import Fraction as Q

from tests.unit.analyses.test_portfolio import checked
from tests.unit.elaborate.texts import read

from haverify.analyses.portfolio import decide_all
from haverify.evidence.verdict import Proved, Refuted, Unknown

WORDS = {Proved: "proved", Refuted: "refuted", Unknown: "unknown"}


def decided(tmp_path, text, data=None):
    """The evidence for each claim; every certificate is accepted."""
    spec = read(text, data)[0]
    found = decide_all(spec)
    opinions = checked(tmp_path, spec, found)
    for name, e in found.items():
        assert opinions[name] == ("absent" if isinstance(e.verdict, Unknown) else "accepted"), name
    return found


def words(found):
    return {k: WORDS[type(e.verdict)] for k, e in found.items()}


def kind(evidence):
    return evidence.verdict.kind


def test_an_interval_of_starts_and_an_interval_reset_are_proved_by_the_domain(tmp_path):
    text = """
automaton N {
  var x: s in [0 s, 10 s]
  init W where 0 s <= x <= 1 s
  mode W { domain x <= 3 s; flow { x' = 1 }; edge go: -> G when x >= 2 s do x in [0 s, 0.5 s] }
  mode G { domain x <= 1 s; flow { x' = 1 }; edge over: -> D when x >= 0.9 s and x < 1 s }
  mode D { terminal; flow { x' = 0 } }
}
property a on N { always x <= 3 s }
property b on N { always jump(go) implies pre(x) >= 2 s }
"""
    assert words(decided(tmp_path, text)) == {"a": "proved", "b": "proved"}


def test_a_violation_is_where_the_quotient_is_defined(tmp_path):
    text = """
automaton M {
  var x: 1 in [0, 2]
  init R with x := 0
  mode R { domain x <= 2; flow { x' = 1 s^-1 }; urgent edge back: -> R when x >= 2 do x := 0 }
}
property a on M { always 1/(x-1) <= 1000 }
"""
    found = decided(tmp_path, text)
    assert words(found) == {"a": "refuted"}
    assert found["a"].verdict.margin is None  # a multiple of the claim's unit would be none
    assert 1 < found["a"].run.last < Q(1001, 1000)


def test_a_run_is_followed_while_it_is_inside_the_declared_ranges(tmp_path):
    text = """
automaton W {
  var x: s in [0 s, 2 s]
  init A with x := 0 s
  mode A { flow { x' = 1 } }
}
property inside on W { always x <= 2 s }
property before on W { always x < 2 s }
property soon on W { within 2 s; always x <= 2 s }
property late on W { reach x >= 3 s within 4 s }
"""
    found = decided(tmp_path, text)
    assert words(found) == {"inside": "unknown", "before": "refuted", "soon": "proved", "late": "unknown"}
    assert kind(found["inside"]) == "window"
    assert kind(found["late"]) == "window"


TWO_MODES = """
automaton A {
  var x: s in [0 s, 5 s]
  init M with x := 0 s
  mode M { domain x <= 2 s; flow { x' = 1 }; edge go: -> N when x == 2 s do x := 0 s }
  mode N { domain x <= 1 s; flow { x' = 2 }; urgent edge back: -> M when x >= 1 s do x := 0 s }
}
"""


def test_a_claim_whose_premise_no_state_satisfies_is_vacuous(tmp_path):
    text = (
        TWO_MODES
        + """
property far on A { always x > 3 s implies x < 0 s }
property there on A { always at(N) and x > 2 s implies x < 0 s }
property both on A { always (x > 3 s implies x < 0 s) and (x > 4 s implies x < 1 s) }
property one on A { always (x > 3 s implies x < 0 s) and (x > 1 s implies x < 3 s) }
property end on A { always x >= 2 s implies at(M) }
"""
    )
    found = decided(tmp_path, text)
    assert [kind(found[k]) for k in ("far", "there", "both")] == ["vacuous"] * 3
    assert {k: words(found)[k] for k in ("one", "end")} == {"one": "proved", "end": "proved"}


def test_an_edge_with_an_equation_is_taken_at_the_end_of_the_domain(tmp_path):
    text = (
        TWO_MODES
        + """
property on on A { never stuck }
property two on A { reach at(N) within 2 s }
property round on A { reach jump(back) within 2.5 s }
property soon on A { reach jump(back) within 2.4 s }
"""
    )
    found = decided(tmp_path, text)
    assert words(found) == {"on": "proved", "two": "proved", "round": "proved", "soon": "refuted"}


def test_an_equation_may_be_passed_before_the_end_or_not_hold_with_the_rest(tmp_path):
    text = """
automaton A {
  var x: s in [0 s, 5 s]
  init M with x := 0 s
  mode M { domain x <= 3 s; flow { x' = 1 }; edge go: -> N when x == 2 s }
  mode N { terminal; flow { x' = 0 } }
}
automaton B {
  var x: s in [0 s, 5 s]
  init M with x := 0 s
  mode M { domain x <= 2 s; flow { x' = 1 }; edge go: -> N when x == 2 s and x == 1 s }
  mode N { terminal; flow { x' = 0 } }
}
automaton C {
  var x: s in [0 s, 5 s]
  init M where x <= 3 s
  mode M { domain x <= 4 s; flow { x' = 1 }; urgent edge go: -> N when x == 2 s }
  mode N { terminal; flow { x' = 0 } }
}
property a on A { never stuck }
property b on B { never stuck }
property c on C { never stuck }
property d on C { always at(M) implies x <= 2 s }
property e on C { reach at(N) within 5 s }
"""
    assert words(decided(tmp_path, text)) == dict.fromkeys("abcde", "refuted")


def test_a_double_root_beside_a_param_and_an_unbounded_clock(tmp_path):
    text = """
param amp in [0.5, 2]
automaton A {
  var x: s in [0 s, 5 s]
  var y: s
  let f: deg = amp * (x / 1 s - 1)^2 * 10 deg
  let h: rad = f
  init M with { x := 0 s; y := 0 s }
  mode M { domain x <= 2 s; flow { x' = 1; y' = 1 }; urgent edge back: -> M when x >= 2 s do x := 0 s }
}
property least on A { always f >= 0 deg }
property above on A { always f > 0 deg }
property radians on A { always h <= 0.349 rad }
property enough on A { always h <= 0.35 rad }
property there on A { can reach h >= 0.349 rad }
property clock on A { always y <= 10 s }
"""
    expected = {"least": "proved", "above": "refuted", "radians": "refuted", "enough": "proved"}
    assert words(decided(tmp_path, text)) == {**expected, "there": "proved", "clock": "refuted"}


def test_a_bound_in_radians_on_printed_degrees(tmp_path):
    text = """
enum P { A }
table T from "r.csv" {
  key p: P
  poly a1..a2 descending in x: s -> deg
  digits 2
}
automaton G {
  var x: s in [0 s, 2 s]
  let y: deg = T[phase](x)
  init A with x := 0 s
  mode R for phase in P { flow { x' = 1 } }
  schedule on x from 0 s { A until 2 s then A do x := 0 s }
}
property a on G { always -0.345 rad <= y }
property b on G { always y <= -0.36 rad }
"""
    found = decided(tmp_path, text, {"r.csv": "p,a1,a2\nA,1.5,-20\n"})
    assert words(found) == {"a": "refuted", "b": "refuted"}
    assert isinstance(found["a"].rounding.verdict, Unknown)
    assert isinstance(found["b"].rounding.verdict, Refuted)


CYCLE = """
param v in [0.5, 2]
automaton M {
  var x: s in [0 s, 2 s]
  init R with x := 0 s
  mode R { domain x <= 2 s; flow { x' = 1 }; urgent edge back: -> R when x >= 2 s do x := 0 s }
}
"""


def test_an_assumption_pins_a_param(tmp_path):
    text = (
        CYCLE
        + """
property a on M { assume v == 1; always v * x <= 2 s }
property b on M { assume v == 1; always v * x < 2 s }
property c on M { assume v == 3; always v * x < 2 s }
"""
    )
    found = decided(tmp_path, text)
    assert words(found) == {"a": "proved", "b": "refuted", "c": "unknown"}
    assert kind(found["c"]) == "vacuous"
    assert dict(found["b"].run.params) == {"v": 1}


def test_a_window_far_away_is_given_up_with_what_was_reached(tmp_path):
    found = decided(tmp_path, CYCLE + "property a on M { always during [1e6 s, 1e6 s] x <= 5 s + time }")
    assert kind(found["a"]) == "budget"
    assert "runs were followed to" in found["a"].verdict.reason


def test_a_margin_is_that_of_the_instants_claimed(tmp_path):
    found = decided(tmp_path, CYCLE + "property a on M { within 1 s; always x <= 0.5 s }")
    margin = found["a"].verdict.margin
    assert margin.low <= Q(-1, 2) <= margin.high
    assert margin.high - margin.low < Q(1, 1000)


def test_why_a_mode_is_never_entered(tmp_path):
    text = """
automaton A {
  var x: s in [0 s, 5 s]
  init M with x := 0 s
  mode M {
    domain x <= 2 s
    flow { x' = 1 }
    urgent edge back: -> M when x >= 2 s do x := 0 s
    edge go: -> N when x > 3 s
  }
  mode N { terminal; flow { x' = 0 } }
}
property a on A { can reach at(N) }
"""
    found = decided(tmp_path, text)
    assert words(found) == {"a": "refuted"}
    assert found["a"].notes == ("no run enters mode N: edge go (M -> N) is enabled in no state reached",)
