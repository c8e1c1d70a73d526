"""HA305: edges that may wait."""


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


def test_the_stay_that_is_possible_is_shown(lint):
    found = lint(clock("x <= 1.6 s", "edge back: -> M when x > 0.5 s do x := 0 s"))
    (d,) = found.of("HA305")
    assert d.message == ("edge back (M -> M) may fire from x = 0.5 s on, but the run may stay in mode M up to 1.6 s")
    assert "urgent edge back" in found.fixed("HA305")


def test_urgent_edges_and_edges_at_the_end_of_the_domain(lint):
    assert lint(clock("x <= 1.6 s", "urgent edge back: -> M when x > 0.5 s do x := 0 s")).of("HA305") == []
    assert lint(clock("x <= 1.6 s", "edge back: -> M when x >= 1.6 s do x := 0 s")).of("HA305") == []
