"""HA306: edges that land outside."""

TEXT = """automaton A {
  var x: s in [0 s, 2 s]
  init A with x := 0 s
  mode A { domain x <= 0.5 s; flow { x' = 1 }; urgent edge on: -> B when x >= 0.5 s do x := 1 s }
  mode B { domain x <= 1.6 s; flow { x' = 1 }; urgent edge again: -> A when x >= 1.6 s%s }
}"""


def test_a_clock_that_is_not_set_back(lint):
    (d,) = lint(TEXT % "").of("HA306")
    assert d.message == "edge again (B -> A) keeps x, but mode A needs `x <= 0.5 s`"
    assert "x = 1.6 s" in d.notes[0]


def test_a_reset_to_a_wrong_value(lint):
    (d,) = lint(TEXT % " do x := 0.6 s").of("HA306")
    assert d.message == "edge again (B -> A) sets x, but mode A needs `x <= 0.5 s`"


def test_a_set_reset_that_reaches_the_domain_somewhere(lint):
    assert lint(TEXT % " do x in [0.4 s, 0.9 s]").of("HA306") == []
    assert lint(TEXT % " do x in [0.6 s, 0.9 s]").of("HA306")


def test_a_reset_into_the_domain(lint):
    assert lint(TEXT % " do x := 0 s").of("HA306") == []
