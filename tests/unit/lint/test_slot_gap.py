"""HA204: slots that do not meet."""


def slots(end: str, begin: str, guard: str = "") -> str:
    return f"""automaton A {{
  var x: s in [0 s, 2 s]
  init A with x := 0 s
  mode A {{
    domain 0 s <= x <= {end}
    flow {{ x' = 1 }}
    edge on: -> B {guard}
  }}
  mode B {{
    domain {begin} <= x <= 1 s
    flow {{ x' = 1 }}
    edge back: -> A when x >= 1 s do x := 0 s
  }}
}}
"""


def test_a_gap_is_an_error_that_says_which_edge_dies(lint):
    found = lint(slots("0.733 s", "0.7333 s", "when x >= 0.733 s"))
    (d,) = found.of("HA204")
    assert d.message == "x in 0.733 s .. 0.7333 s belongs to no slot: edge on (A -> B) can never be taken"
    assert d.severity is not None and d.severity.value == "error"
    assert found.at("HA204") == "0.7333 s"
    assert found.of("HA306") == []


def test_the_fix_makes_the_slots_meet(lint):
    assert lint(lint(slots("0.733 s", "0.7333 s")).fixed("HA204")).of("HA204") == []


def test_an_overlap_without_a_guard(lint):
    (d,) = lint(slots("0.8 s", "0.7 s")).of("HA204")
    assert d.message == "x in 0.7 s .. 0.8 s belongs to two slots, A and B"


def test_an_overlap_that_a_guard_decides_is_fine(lint):
    assert lint(slots("0.8 s", "0.7 s", "when x >= 0.75 s")).of("HA204") == []


def test_slots_that_meet(lint):
    assert lint(slots("0.7 s", "0.7 s")).of("HA204") == []
