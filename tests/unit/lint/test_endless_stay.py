"""HA310: stays without an end, and claims that read what moves meanwhile."""


def spec(mode: str, claim: str) -> str:
    return f"""automaton A {{
  var x: s
  let y: deg = 2 deg / 1 s * x
  let z: deg = 1 deg
  init M with x := 0 s
  mode M {{
    flow {{ x' = 1 }}
    {mode}
  }}
  mode N {{ terminal; flow {{ x' = 0 }} }}
}}
property p on A {{ {claim} }}
"""


WAITS = "edge stop: -> N when x >= 1 s do x := 0 s"


def test_a_mode_that_may_keep_a_run_for_ever(lint):
    found = lint(spec(WAITS, "always x <= 5 s"))
    (d,) = found.of("HA310")
    assert d.message == "mode M has no upper bound on the stay, and property p has no horizon"
    assert found.at("HA310").startswith("mode M")


def test_outputs_of_what_moves_count_and_others_do_not(lint):
    assert len(lint(spec(WAITS, "always y <= 5 deg")).of("HA310")) == 1
    assert lint(spec(WAITS, "always z <= 5 deg")).of("HA310") == []


def test_a_bound_an_urgent_edge_or_a_horizon_ends_it(lint):
    assert lint(spec("domain x <= 2 s; " + WAITS, "always x <= 5 s")).of("HA310") == []
    assert lint(spec("urgent " + WAITS, "always x <= 5 s")).of("HA310") == []
    assert lint(spec(WAITS, "always x <= 5 s; within 4 s")).of("HA310") == []
