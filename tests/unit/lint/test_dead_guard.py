"""HA302: guards that never hold in their mode."""


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


def test_a_strict_guard_at_the_end_of_the_domain(lint):
    found = lint(clock("x <= 1 s", "edge back: -> M when x > 1 s do x := 0 s"))
    (d,) = found.of("HA302")
    assert d.message == "edge back (M -> M) is never enabled: `x > 1 s` cannot hold in mode M"
    assert d.help == "include the bound: `when x >= 1 s`"
    assert found.at("HA302") == "x > 1 s"


def test_a_guard_inside_the_domain(lint):
    assert lint(clock("x <= 1 s", "edge back: -> M when x >= 1 s do x := 0 s")).of("HA302") == []


def test_no_help_where_closing_would_not_help(lint):
    (d,) = lint(clock("x <= 1 s", "edge back: -> M when x > 1.5 s do x := 0 s")).of("HA302")
    assert d.help is None


def test_a_param_that_may_make_it_true(lint):
    text = "param t: s in [0.5 s, 3 s]\n" + clock("x <= 1 s", "edge back: -> M when x >= t do x := 0 s")
    assert lint(text).of("HA302") == []
    assert lint(text.replace("0.5 s, 3 s", "1.5 s, 3 s")).of("HA302")


def test_an_urgent_edge_is_due_where_its_strict_bound_begins(lint):
    assert lint(clock("x <= 1 s", "urgent edge back: -> M when x > 1 s do x := 0 s")).of("HA302") == []
    assert lint(clock("x <= 1 s", "urgent edge back: -> M when x > 1.5 s do x := 0 s")).of("HA302")
