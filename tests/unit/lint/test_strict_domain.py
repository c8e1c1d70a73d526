"""HA205: strict bounds of a domain."""


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


def test_each_strict_bound_is_named_and_closed_by_the_fix(lint):
    found = lint(clock("0 s < x and x < 1 s", BACK))
    assert "`0 s < x`, `x < 1 s`" in found.of("HA205")[0].message
    assert "domain 0 s <= x and x <= 1 s" in found.fixed("HA205")
    assert lint(found.fixed("HA205")).of("HA205") == []


def test_closed_bounds_are_silent(lint):
    assert lint(clock("0 s <= x <= 1 s", BACK)).of("HA205") == []
