"""HA304: edges that compete."""


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


TWO = """urgent edge a: -> M when x >= 1 s do x := 0 s
    urgent edge b: -> M when x >= {} do x := 0.5 s"""


def test_two_urgent_edges_at_one_state(lint):
    (d,) = lint(clock("x <= 1 s", TWO.format("1 s"))).of("HA304")
    assert d.message == "edge a (M -> M) and edge b (M -> M) are both enabled at x = 1 s"


def test_guards_that_exclude_each_other(lint):
    assert lint(clock("x <= 1 s", TWO.format("1.5 s"))).of("HA304") == []


def test_a_priority_settles_it(lint):
    text = clock("x <= 1 s", TWO.format("1 s")).rstrip().removesuffix("}") + "  priority a over b\n}"
    assert lint(text).of("HA304") == []


def test_plain_edges_are_a_choice(lint):
    assert lint(clock("x <= 1 s", TWO.format("1 s").replace("urgent ", ""))).of("HA304") == []
