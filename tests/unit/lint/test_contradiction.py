"""HA202: conditions that contradict themselves."""


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


def test_a_linear_contradiction_names_its_core(lint):
    found = lint(clock("x <= 1 s and 2 * x >= 4 s and x >= 0 s", BACK))
    (d,) = found.of("HA202")
    assert d.message == "the domain of mode M can never hold: `x <= 1 s` and `2 * x >= 4 s` contradict each other"


def test_a_polynomial_contradiction_in_one_variable(lint):
    assert lint(clock("x * x <= 2 s^2 and x >= 1.4143 s", BACK)).of("HA202")
    assert lint(clock("x * x <= 2 s^2 and x >= 1.4142 s", BACK)).of("HA202") == []


def test_a_polynomial_contradiction_in_two_variables_is_left_to_the_solver(lint):
    text = "param a in [-9, 9]\nparam b in [-9, 9]\nassume {}\nproperty p {{ holds a <= 9; expect proved }}"
    assert lint(text.format("a * a + b * b <= 1 and a * b >= 0.6")).of("HA202")
    assert lint(text.format("a * a + b * b <= 1 and a * b >= 0.4")).of("HA202") == []


def test_a_domain_is_read_as_closed(lint):
    assert lint(clock("1 s < x and x + x <= 2 s", BACK, start="1 s")).of("HA202") == []


def test_backwards_bounds_are_not_reported_twice(lint):
    assert lint(clock("1 s <= x <= 0 s", BACK)).of("HA202") == []
