"""Sugar and what it stands for."""

from tests.unit.elaborate.texts import healthy

from haverify.model.core import expr_to_json, to_core

CYCLE = """
enum Phase { LR, TS }
automaton A {
  var x: s
  let late: bool = phase is TS
  init with x := 0 s
  mode Run for phase in Phase { flow { x' = if phase is LR then 1 else 2 } }
  schedule on x from 0 s { LR until 500 ms; TS until 1 s then LR do x := 0 s }
}
property p on A { always phase is TS implies x >= 0.5 s }
property q on A { always at(Run) }
property r for p in Phase on A { can reach at(p) within 2 s }
"""


def test_schedule_and_mode_family() -> None:
    a = to_core(healthy(CYCLE))["automata"][0]
    x = ["var", "x"]
    assert [m["name"] for m in a["modes"]] == ["LR", "TS"]
    assert [m["domain"] for m in a["modes"]] == [
        ["and", ["<=", "0", x], ["<=", x, "1/2"]], ["and", ["<=", "1/2", x], ["<=", x, "1"]],
    ]  # fmt: skip
    assert [m["flow"] for m in a["modes"]] == [[{"var": "x", "rate": "1"}], [{"var": "x", "rate": "2"}]]
    assert [m["lets"][0]["expr"] for m in a["modes"]] == [False, True]
    assert a["edges"] == [
        {"name": "LR_TS", "source": "LR", "target": "TS", "urgent": True, "guard": [">=", x, "1/2"], "resets": []},
        {"name": "TS_LR", "source": "TS", "target": "LR", "urgent": True, "guard": [">=", x, "1"],
         "resets": [{"var": "x", "to": "0"}]},
    ]  # fmt: skip
    assert a["init"] == [{"mode": None, "where": True, "with": [{"var": "x", "to": "0"}]}]


def test_mode_parameter_in_claims() -> None:
    claims = {c.name: expr_to_json(c.goals[0].condition) for c in healthy(CYCLE).claims}
    assert claims["p"] == ["implies", ["at", "TS"], [">=", ["var", "x"], "1/2"]]
    assert claims["q"] == ["or", ["at", "LR"], ["at", "TS"]]
    assert claims["r[TS]"] == ["at", "TS"]


def test_modes_of_two_families_keep_their_family() -> None:
    text = """
enum I { a, b }
automaton A {
  var x: 1
  init P with x := 0
  flow { x' = 0 }
  mode P for i in I { edge go: -> Q[i] }
  mode Q for i in I { edge back: -> P[i] }
}
"""
    a = healthy(text).automata[0]
    assert [m.name for m in a.modes] == ["P[a]", "P[b]", "Q[a]", "Q[b]"]
    assert [i.mode for i in a.init] == ["P[a]", "P[b]"]
    assert [(e.name, e.source, e.target) for e in a.edges][:2] == [("go", "P[a]", "Q[a]"), ("go", "P[b]", "Q[b]")]


def test_sample_is_a_clock_with_self_edges() -> None:
    text = """
automaton A {
  var u: m
  init M with u := 0 m
  flow { u' = 0 m/s }
  mode M { edge go: -> N }
  mode N { terminal }
  sample tick every [5 ms, 10 ms] do u := u + 1 m
}
"""
    a = to_core(healthy(text))["automata"][0]
    clock = ["var", "tick_clock"]
    assert [v["name"] for v in a["vars"]] == ["u", "tick_clock"]
    assert [m["domain"] for m in a["modes"]] == [["<=", clock, "1/100"]] * 2
    assert a["init"][0]["with"][-1] == {"var": "tick_clock", "to": "0"}
    ticks = [e for e in a["edges"] if e["name"] == "tick"]
    assert [(e["source"], e["target"], e["urgent"], e["guard"]) for e in ticks] == [
        ("M", "M", False, [">=", clock, "1/200"]), ("N", "N", False, [">=", clock, "1/200"]),
    ]  # fmt: skip


def test_instance_rebinds_and_recomputes_what_depends_on_it() -> None:
    text = """
const k = 2
const twice = 2 * k
const apart = 7
automaton A { var x: 1; init M with x := k; mode M { flow { x' = twice * 1 Hz } } }
automaton B = A with { k = k + 1 }
property p on B { always k > apart }
"""
    spec = healthy(text)
    b = spec.automata[1]
    assert [(c.name, expr_to_json(c.value)) for c in b.constants] == [
        ("B_k", ["+", ["const", "k"], "1"]), ("B_twice", ["*", "2", ["const", "B_k"]]),
    ]  # fmt: skip
    assert expr_to_json(b.modes[0].flow[0].rate) == ["*", ["const", "B_twice"], "1"]


def test_instance_binds_an_input_and_widens_a_param() -> None:
    text = """
automaton A {
  input u: m in [0 m, 1 m]
  param c in [0, 1]
  var x: m
  init M with x := 0 m
  mode M { flow { x' = c * u * 1 Hz } }
}
automaton B = A with { u = 2 m * sin(1 Hz * time); c in [0, 2] }
"""
    b = to_core(healthy(text))["automata"][1]
    assert b["inputs"] == []
    assert b["params"][0]["high"] == "2"
    assert b["lets"][0]["expr"] == ["*", "2", ["sin", ["*", "1", ["time"]]]]
    assert b["modes"][0]["flow"][0]["rate"] == ["*", ["param", "c"], ["let", "u"], "1"]


def test_units_convert_exactly_and_visibly() -> None:
    text = """
const a: rad = 90 deg
const b: deg = 1 rad
const v: m/s = 36 km/h
property p { holds a > b and v > 1 km/h and sin(b) < 1 }
"""
    core = to_core(healthy(text))
    assert [c["value"] for c in core["constants"]] == [["scale", "1/180", 1, "90"], ["scale", "180", -1, "1"], "10"]
    assert core["claims"][0]["goals"][0]["condition"] == [
        "and", [">", ["const", "a"], ["scale", "1/180", 1, ["const", "b"]]], [">", ["const", "v"], "5/18"],
        ["<", ["sin", ["scale", "1/180", 1, ["const", "b"]]], "1"],
    ]  # fmt: skip


def test_quantifiers_and_sums_over_enumerations_are_written_out() -> None:
    text = """
enum I = 1..3
param x for i in I in [0, 1]
property p { holds exists i in I: i != 2 and x[i] > 0 }
property q { holds sum(x[i] for i in I) <= max(x[i] for i in I) }
property r { holds unique i in I: x[i] > 0 }
"""
    claims = {c.name: expr_to_json(c.goals[0].condition) for c in healthy(text).claims}
    x = [["param", f"x[{i}]"] for i in (1, 2, 3)]
    assert claims["p"] == ["or", [">", x[0], "0"], [">", x[2], "0"]]
    assert claims["q"] == ["<=", ["+", *x], ["max", *x]]
    assert claims["r"][0] == "or" and len(claims["r"]) == 4


def test_excluded_branches_are_not_looked_at() -> None:
    text = """
enum I = 1..3
param x for i in I in [0, 1]
fn before(i: I) = if i == 1 then 0 else x[i - 1]
property p for i in I { holds before(i) <= 1 }
"""
    claims = [expr_to_json(c.goals[0].condition) for c in healthy(text).claims]
    assert claims == [True, ["<=", ["param", "x[1]"], "1"], ["<=", ["param", "x[2]"], "1"]]


def test_system_names_syncs_and_priorities() -> None:
    text = """
enum I = 1..2
automaton A {
  var x: s
  init M with x := 0 s
  flow { x' = 1 }
  mode M { edge go: -> M; edge halt: -> N }
  mode N { terminal }
}
system S {
  part a for i in I = A
  part b = A
  sync both for i in I: a[i].go, b.go when a[i].x <= b.x
  sync all: b.halt -> a[1].halt, a[2].halt
  priority all over both
}
property p on S { never at(a[1].N) and jump(all) and a[2].x > 1 s }
"""
    s = to_core(healthy(text))["systems"][0]
    assert [p["name"] for p in s["parts"]] == ["a[1]", "a[2]", "b"]
    assert [(y["name"], y["edges"], y["listeners"]) for y in s["syncs"]] == [
        ("both[1]", ["a[1].go", "b.go"], []), ("both[2]", ["a[2].go", "b.go"], []),
        ("all", ["b.halt"], ["a[1].halt", "a[2].halt"]),
    ]  # fmt: skip
    assert s["syncs"][0]["guard"] == ["<=", ["var", "a[1].x"], ["var", "b.x"]]
    assert [p["over"] for p in s["priorities"]] == [["all", "both[1]"], ["all", "both[2]"]]


def test_chains_sets_and_never() -> None:
    text = """
const band: m = 2 m +- 50 cm
param x: m in [0 m, 1 m]
property p { holds 0 m < x <= 1 m and x in band }
"""
    spec = healthy(text)
    x = ["param", "x"]
    assert expr_to_json(spec.claims[0].goals[0].condition) == [
        "and", ["<", "0", x], ["<=", x, "1"], ["<=", "3/2", x], ["<=", x, "5/2"],
    ]  # fmt: skip
