"""HA312 and HA313: priorities that leave nothing to fire."""


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


def ordered(guard: str, priorities: str) -> str:
    edges = f"""edge a: -> M when x >= 1 s do x := 0 s
    edge b: -> M when x >= {guard} do x := 0.5 s"""
    return clock("x <= 1 s", edges).rstrip().removesuffix("}") + priorities + "\n}"


def test_a_circle_is_spelled_out(lint):
    (d,) = lint(ordered("1 s", "  priority a over b\n  priority b over a")).of("HA312")
    assert d.message == "priorities of A form a cycle: a over b, b over a"


def test_an_order_is_no_circle(lint):
    assert lint(ordered("1 s", "  priority a over b")).of("HA312") == []


def test_the_lower_edge_is_silenced_where_the_higher_is_always_enabled(lint):
    (d,) = lint(ordered("1 s", "  priority a over b")).of("HA313")
    assert d.message == "a is enabled whenever b is, so edge b (M -> M) below it can never fire"
    assert lint(ordered("0.5 s", "  priority a over b")).of("HA313") == []


def test_a_condition_leaves_it_a_chance(lint):
    assert lint(ordered("1 s", "  priority a over b when x <= 0.5 s")).of("HA313") == []
