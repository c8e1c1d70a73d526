"""HA301 and HA309: modes without a way in or out."""

TEXT = """automaton A {
  var x: s in [0 s, 2 s]
  init A with x := 0 s
  mode A { domain x <= 1 s; flow { x' = 1 }; urgent edge on: -> %s when x >= 1 s do x := 0 s }
  mode B { flow { x' = 1 } }
}"""


def test_a_mode_that_no_edge_leads_to(lint):
    (d,) = lint(TEXT % "A").of("HA301")
    assert d.message == "mode B is never entered: no edge leads to it and no run starts there"


def test_a_mode_behind_an_edge(lint):
    assert lint(TEXT % "B").of("HA301") == []


def test_a_mode_behind_a_dead_edge_is_the_edges_fault(lint):
    found = lint((TEXT % "B").replace("x >= 1 s", "x >= 1.5 s"))
    assert found.of("HA302") and found.of("HA301") == []


def test_a_mode_without_exit_is_made_terminal_by_the_fix(lint):
    found = lint(TEXT % "B")
    assert found.of("HA309")[0].message == "mode B has no edge and is not marked `terminal`"
    assert lint(found.fixed("HA309")).of("HA309") == []
