"""HA307: starts outside the domain."""


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


def test_the_value_at_the_start_is_shown_beside_the_need(lint):
    found = lint(clock("0.4 s <= x <= 1 s", "edge back: -> M when x >= 1 s do x := 0.4 s"))
    (d,) = found.of("HA307")
    assert d.message == "init M of A starts outside the domain of mode M, at x = 0 s"
    assert d.labels[0].text == "x is 0 s at the start"
    assert found.at("HA307") == "init M with x := 0 s"


def test_an_output_at_the_start(lint):
    text = clock("y <= 5 deg and x <= 1 s", BACK).replace("  init", "  let y: deg = 10 deg - x * 20 deg/s\n  init")
    (d,) = lint(text).of("HA307")
    assert d.labels[0].text == "y is 10 deg at the start"


def test_a_start_on_the_bound_of_a_strict_domain_is_inside(lint):
    assert lint(clock("0 s < x <= 1 s", BACK)).of("HA307") == []


def test_one_mode_whose_domain_holds_is_enough_without_a_name(lint):
    text = clock("x >= 0.5 s and x <= 1 s", "edge back: -> M when x >= 1 s do x := 0.5 s").replace("init M", "init")
    assert lint(text).of("HA307")
    assert lint(text.replace("x := 0 s", "x := 0.7 s")).of("HA307") == []


def test_without_a_start_nothing_else_is_reported_of_reach(lint):
    found = lint(clock("0.4 s <= x <= 1 s", "edge back: -> M when x > 1 s do x := 0.4 s"))
    assert found.of("HA303") == [] and found.of("HA301") == []
