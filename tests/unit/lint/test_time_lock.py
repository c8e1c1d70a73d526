"""HA303: states where a run is stuck."""


def clock(domain: str, edge: str, start: str = "0 s", tail: str = "") -> str:
    """A mode with one clock."""
    return f"""automaton A {{
  var x: s in [0 s, 2 s]
  init M with x := {start}
  mode M {{
    domain {domain}
    flow {{ x' = 1 }}
    {edge}
  }}
}}
{tail}"""


BACK = "urgent edge back: -> M when x >= 1 s do x := 0 s"


def test_the_exact_instant_and_the_guard_that_is_missing(lint):
    found = lint(clock("x <= 1.6 s", "edge back: -> M when x > 1.6 s do x := 0 s"))
    (d,) = found.of("HA303")
    assert d.message == "mode M: at x = 1.6 s the flow leaves the domain and no guard holds (back needs x > 1.6 s)"
    assert d.help == "include the bound: `when x >= 1.6 s`"
    assert found.at("HA303") == "x <= 1.6 s"


def test_a_closed_guard_lets_the_run_go_on(lint):
    assert lint(clock("x <= 1.6 s", "edge back: -> M when x >= 1.6 s do x := 0 s")).of("HA303") == []


def test_a_strict_urgent_guard_is_due_at_its_bound(lint):
    assert lint(clock("x <= 1 s", "urgent edge back: -> M when x > 1 s do x := 0 s")).of("HA303") == []


def test_a_mode_where_runs_may_end(lint):
    assert lint(clock("x <= 1 s", "terminal")).of("HA303") == []
    assert lint(clock("x <= 1 s", "")).of("HA303")


def test_a_lock_behind_an_edge_is_found_where_a_run_gets_there(lint):
    text = """automaton A {
  var x: s in [0 s, 9 s]
  init A with x := 0 s
  mode A { domain x <= 1 s; flow { x' = 1 }; edge on: -> B when x >= %s do x := x + 1 s }
  mode B { domain x <= 3 s; flow { x' = 2 }; urgent edge back: -> A when x >= 3 s do x := 5 s }
}"""
    (d,) = lint(text % "0.5 s").of("HA303")
    assert d.message.startswith("mode B: at x = 3 s")
    assert [d.message.split(":")[0] for d in lint(text % "1.5 s").of("HA303")] == ["mode A"]
